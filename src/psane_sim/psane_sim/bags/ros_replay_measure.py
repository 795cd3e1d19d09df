# SPDX-License-Identifier: Apache-2.0
"""Replays a bag, records the replay in another process, and compares the two."""

import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from psane_mapping.bag_file import BagFile
from psane_mapping.errors import BagError
from psane_sim.bags.ros_bag_player import ReplaySettings, replay
from psane_sim.bags.selection import Selection
from psane_sim.bags.timing import ReplayTiming, compare
from psane_sim.processes import use_private_graph

STARTING, PATIENCE = 120.0, 60.0
"""Longest start and longest end of the recorder [s]."""

_RECORD = 'from psane_sim.bags.record import main; main()'


def measure(path: Path, rate: float) -> ReplayTiming:
    """Return how the replay of all topics of a bag was heard.

    Raises
    ------
    BagError
        When the bag cannot be read, or the recorder ends by itself.
    """
    use_private_graph()
    with tempfile.TemporaryDirectory() as folder, BagFile(path) as bag:
        copy = Path(folder) / 'heard'
        topics = [topic.name for topic in bag.topics]
        recorder = subprocess.Popen(
            [sys.executable, '-c', _RECORD, *topics, '--out', str(copy)],
            stdout=subprocess.DEVNULL)

        def is_over() -> bool:
            if recorder.poll() is not None:
                raise BagError(f'the recorder ended with status {recorder.returncode}')
            return False
        try:
            settings = ReplaySettings(rate=rate, wait=STARTING, clock_rate=0.0,
                                      selection=Selection(topics))
            player = replay(bag, settings, is_over, [])
        finally:
            recorder.send_signal(signal.SIGINT)
            recorder.wait(PATIENCE)
        with BagFile(copy) as heard:
            return compare(bag, heard, player.epoch, rate)
