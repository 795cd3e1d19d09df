# SPDX-License-Identifier: Apache-2.0
"""`psane run psane_sim record`: write topics into a rosbag2 bag until Ctrl-C."""

import argparse
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from types import FrameType

from psane_mapping.errors import BagError
from psane_sim.bags.selection import Selection
from psane_sim.bags.writer import BagWriter

COMPLETE, INCOMPLETE, BAD_ARGUMENT = 0, 1, 2
"""Exit statuses."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(
        prog='psane run psane_sim record',
        description='Record topics into a rosbag2 bag (MCAP) with their quality of service and '
        'message definitions, and say what was lost. Remap with --ros-args -r.',
        epilog='Exit status: 0 the bag is complete, 1 messages were lost, 2 a bad argument.')
    made.add_argument('topics', nargs='*', metavar='TOPIC',
                      help='names, with * and ? (default: all topics but hidden ones and '
                      '/parameter_events)')
    made.add_argument('--out', type=Path, metavar='DIR',
                      help='folder of the bag, must not exist (default: out/bag-DATE-TIME)')
    made.add_argument('--duration', type=float, metavar='S',
                      help='end after this time [s on the wall] (default: at Ctrl-C)')
    made.add_argument('--quiet', action='store_true', help='print the last line only')
    made.add_argument('--measure', action='store_true',
                      help='publish 1000 small messages and 20 maps a second on a graph of '
                      'its own for the duration (default 10 s), and print what a bag misses')
    return made


class Stop:
    """Becomes true at a signal, or when the time is over.

    Parameters
    ----------
    duration : float or None
        Time from the first question on [s].
    """

    def __init__(self, duration: float | None) -> None:
        self._duration, self._end = duration, float('inf')
        self._is_called = False
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._call)

    def _call(self, number: int, frame: FrameType | None) -> None:
        self._is_called = True

    def __call__(self) -> bool:
        """Tell whether it is time to stop."""
        if self._duration is not None:
            self._end, self._duration = time.monotonic() + self._duration, None
        return self._is_called or time.monotonic() >= self._end


def main(arguments: Sequence[str] | None = None) -> None:
    """Record, report, and end the program with its exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    cut = given.index('--ros-args') if '--ros-args' in given else len(given)
    options = parser().parse_args(given[:cut])
    if options.duration is not None and not 0.0 < options.duration < float('inf'):
        parser().error(f'--duration {options.duration:g}: expected a time above 0 s')
    if options.measure:
        sys.exit(_measure(options.duration or 10.0))
    out = options.out or Path('out') / time.strftime('bag-%Y%m%d-%H%M%S')
    stop = Stop(options.duration)
    try:
        writer = BagWriter(out)
        # Only here, so that a bad argument is answered at once.
        from psane_sim.bags.ros_bag_recorder import record
        print(f'recording into {out}; Ctrl-C ends it', flush=True)
        report = record(writer, Selection(options.topics), stop, given[cut:])
    except BagError as error:
        print(f'psane record: {error}', file=sys.stderr)
        sys.exit(BAD_ARGUMENT)
    words = report.in_words()
    print(words.splitlines()[-1] if options.quiet else words)
    sys.exit(COMPLETE if report.is_complete else INCOMPLETE)


def _measure(duration: float) -> int:
    """Print what a recording under load lost; return the exit status."""
    from psane_sim.bags.ros_record_measure import measure
    figures = measure(duration)
    for name, value in figures.items():
        print(f'  {name:28s} {value:.6g}')
    return INCOMPLETE if figures['record_missing'] else COMPLETE
