# SPDX-License-Identifier: Apache-2.0
"""`psane run psane_sim replay`: publish a rosbag2 bag again, with its timing and its clock."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from psane_mapping.bag_file import BagFile
from psane_mapping.errors import BagError
from psane_sim.bags.record import BAD_ARGUMENT, Stop
from psane_sim.bags.selection import Renaming, Selection


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(
        prog='psane run psane_sim replay',
        description='Publish what a rosbag2 bag holds, each message at its time and with the '
        'quality of service that it was recorded with. /clock is that of the bag, or is made from '
        "the bag's time where it holds none.",
        epilog='Exit status: 0 replayed, 1 not every message came through (--measure), '
        '2 a bad argument.')
    made.add_argument('bag', type=Path, help="a bag's folder, or an .mcap file")
    made.add_argument('--rate', type=float, default=1.0, metavar='X',
                      help='seconds of the bag for each second on the wall (default 1)')
    made.add_argument('--loop', action='store_true',
                      help='begin anew at the end, until Ctrl-C; time then jumps back')
    made.add_argument('--topics', nargs='+', default=[], metavar='TOPIC',
                      help='only these; * and ? stand for any text and any letter')
    made.add_argument('--namespace', default='', metavar='NS',
                      help='put before all names but /clock, /tf, /rosout and /diagnostics')
    made.add_argument('--remap', nargs='+', default=[], metavar='OLD:=NEW',
                      help='other names for recorded topics')
    made.add_argument('--wait', type=float, default=0.0, metavar='S',
                      help='wait until somebody listens to each topic, a made /clock too, but no '
                      'longer than this (default 0)')
    made.add_argument('--delay', type=float, default=1.0, metavar='S',
                      help='time after that for further listeners to find the topics before the '
                      'first message (default 1)')
    made.add_argument('--clock-rate', type=float, default=100.0, metavar='HZ',
                      help='ticks of /clock where the bag holds none; 0 for none (default 100)')
    made.add_argument('--measure', action='store_true',
                      help='replay on a graph of its own, record that, and print how late each '
                      'message came')
    return made


def main(arguments: Sequence[str] | None = None) -> None:
    """Replay and end the program with its exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    cut = given.index('--ros-args') if '--ros-args' in given else len(given)
    options = parser().parse_args(given[:cut])
    for name, low, high in (('rate', 0.01, 100.0), ('wait', 0.0, 3600.0),
                            ('delay', 0.0, 600.0), ('clock_rate', 0.0, 1000.0)):
        if not low <= getattr(options, name) <= high:
            parser().error(f'--{name.replace("_", "-")} {getattr(options, name):g}: expected a '
                           f'value in [{low:g}, {high:g}]')
    try:
        sys.exit(_run(options, given[cut:]))
    except BagError as error:
        print(f'psane replay: {error}', file=sys.stderr)
        sys.exit(BAD_ARGUMENT)


def _run(options: argparse.Namespace, ros_arguments: list[str]) -> int:
    renaming = Renaming.of(options.namespace, options.remap)
    if options.measure:
        # Only here and below, so that a bad argument is answered at once.
        from psane_sim.bags.ros_replay_measure import measure
        timing = measure(options.bag, options.rate)
        for name, value in timing.figures().items():
            print(f'  {name:28s} {value:.6g}')
        return 0 if timing.heard == timing.expected and not timing.different else 1
    stop = Stop(None)
    with BagFile(options.bag) as bag:
        from psane_sim.bags.ros_bag_player import ReplaySettings, replay
        settings = ReplaySettings(rate=options.rate, loop=options.loop, wait=options.wait,
                                  delay=options.delay, clock_rate=options.clock_rate,
                                  selection=Selection(options.topics), renaming=renaming)
        player = replay(bag, settings, stop, ros_arguments,
                        lambda words: print(f'psane replay: {words}', file=sys.stderr))
    print(f'{player.sent} messages on {len(player.topics)} topics')
    for name, reason in player.refused.items():
        print(f'  {name} was not replayed: {reason}')
    return 0
