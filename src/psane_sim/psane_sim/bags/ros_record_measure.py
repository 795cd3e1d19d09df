# SPDX-License-Identifier: Apache-2.0
"""Publishes at a high rate, records that in another process, and compares the counts."""

import signal
import subprocess
import sys
import tempfile
import time
from array import array
from collections import Counter
from pathlib import Path

import rclpy
from nav_msgs.msg import OccupancyGrid
from rclpy.publisher import Publisher
from sensor_msgs.msg import Imu

from psane_mapping.bag_file import BagFile
from psane_mapping.conversions import stamp
from psane_mapping.errors import BagError
from psane_mapping.quality_of_service import LATCHED, SENSORS
from psane_sim.processes import use_private_graph

RATE, GRID_RATE, GRIDS, EDGE = 1000, 5, 4, 101
"""Small messages and rounds of grids in a second [Hz], grids in a round, their edge [cells]."""

PATIENCE = 120.0
"""Longest start and longest end of the recorder [s]."""

_RECORD = 'from psane_sim.bags.record import main; main()'


def measure(duration: float) -> dict[str, float]:
    """Return what was published and what is in the bag after some seconds of load.

    Raises
    ------
    BagError
        When the recorder does not come up.
    """
    use_private_graph()
    rclpy.init(args=[])
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        node = rclpy.create_node('load', enable_rosout=False)
        small = node.create_publisher(Imu, 'load/small', SENSORS)
        grids = [node.create_publisher(OccupancyGrid, f'load/grid_{number}', LATCHED)
                 for number in range(GRIDS)]
        recorder = subprocess.Popen([sys.executable, '-c', _RECORD, 'load/*', '--out', str(bag)],
                                    stdout=subprocess.DEVNULL)
        try:
            _wait_for_listeners([small, *grids], recorder)
            published, wall = _publish(small, grids, duration)
        finally:
            recorder.send_signal(signal.SIGINT)
            status = recorder.wait(PATIENCE)
            node.destroy_node()
            rclpy.try_shutdown()
        with BagFile(bag) as found:
            recorded = Counter(message.topic for message in found.messages())
    return {'record_published': published.total(), 'record_published_per_s':
            published.total() / wall, 'record_missing': (published - recorded).total(),
            'record_status': status}


def _wait_for_listeners(publishers: list[Publisher], recorder: 'subprocess.Popen[bytes]') -> None:
    deadline = time.monotonic() + PATIENCE
    while not all(publisher.get_subscription_count() for publisher in publishers):
        if recorder.poll() is not None or time.monotonic() > deadline:
            raise BagError('the recorder did not come up')
        time.sleep(0.02)


def _publish(small: Publisher, grids: list[Publisher],
             duration: float) -> tuple[Counter[str], float]:
    """Publish for some time [s]; return how many messages on each topic, and how long it took."""
    count: Counter[str] = Counter()
    grid = OccupancyGrid(data=array('b', [50]) * (EDGE * EDGE))
    grid.info.width = grid.info.height = EDGE
    began = time.monotonic()
    for number in range(round(RATE * duration)):
        due = began + number / RATE
        if (left := due - time.monotonic()) > 0.0:
            time.sleep(left)
        message = Imu()
        message.header.stamp = stamp(number / RATE)
        small.publish(message)
        count['/load/small'] += 1
        if number % (RATE // GRID_RATE) == 0:
            for index, publisher in enumerate(grids):
                publisher.publish(grid)
                count[f'/load/grid_{index}'] += 1
    wall = time.monotonic() - began
    time.sleep(0.5)
    return count, wall
