# SPDX-License-Identifier: Apache-2.0
"""Measure how long a contact takes to come out of the mapper's node as a map, on a real graph.

``python -m psane_mapping.ros_latency_benchmark [--contacts n]`` starts the node as a process
of its own, in the graph of the environment, and prints one JSON object. Contacts come less often
than maps may be published, so that what is measured is not the publisher's rest.
"""

import argparse
import json
import subprocess
import sys
import time

import numpy as np
import rclpy
from nav_msgs.msg import OccupancyGrid

from psane_mapping import conversions
from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.map_cells import SLIP_STD
from psane_mapping.quality_of_service import CONTACTS, LATCHED
from psane_msgs.msg import LegContact as LegContactMessage

_START = 60.0
_PATIENCE = 5.0
_REST = 1.25
_NODE = 'from psane_mapping.terrain_mapper_node import main; main()'


def stance(point: tuple[float, float], now: float) -> LegContact:
    """Return a stance on ground of strength 0.3 at a point [m], felt at `now` [s]."""
    depth = 0.06 * np.sin(np.pi * np.linspace(0.0, 1.0, 80))
    force = np.outer(4.0e3 * np.maximum(depth, 0.0) ** 1.4, (0.3, 1.0, 0.5))
    return LegContact(leg=0, touch_down=now - 0.5, lift_off=now, point=np.array(point),
                      point_deviation=0.01, depth=depth, measured=0.3 * force, response=force,
                      deviation=1.0 + 0.03 * force)


class _Listener:
    """Publishes contacts and waits for the map that each brings."""

    def __init__(self, config: MappingConfiguration) -> None:
        self._config = config
        self.node = rclpy.create_node('latency_benchmark')
        self.maps = 0
        self.node.create_subscription(OccupancyGrid, SLIP_STD, self._take, LATCHED)
        self.publisher = self.node.create_publisher(
            LegContactMessage, config.topics_of_contacts[0], CONTACTS)

    def _take(self, _: OccupancyGrid) -> None:
        self.maps += 1

    def wait_for(self, maps: int, patience: float) -> bool:
        """Spin until so many maps came; False when they do not [s]."""
        end = time.perf_counter() + patience
        while self.maps < maps and time.perf_counter() < end:
            rclpy.spin_once(self.node, timeout_sec=0.05)
        return self.maps >= maps

    def latency(self, point: tuple[float, float]) -> float:
        """Return the time from a contact to its map [s]; infinite when none came."""
        message = conversions.contact_message(stance(point, time.time()), self._config.map_frame)
        maps = self.maps
        begin = time.perf_counter()
        self.publisher.publish(message)
        return time.perf_counter() - begin if self.wait_for(maps + 1, _PATIENCE) else float('inf')


def measure(contacts: int = 150, seed: int = 0) -> dict[str, float]:
    """Return `map_latency_ms_p50`, `_p99` and `_longest` over some contacts, 101 x 101 cells."""
    config = MappingConfiguration()
    # Maps that are sent again without a change would be taken for those of a contact.
    node = subprocess.Popen([sys.executable, '-c', _NODE, '--ros-args', '-p',
                             'republish_period:=3600.0'])
    listener = _Listener(config)
    try:
        if not listener.wait_for(1, _START):
            raise RuntimeError('terrain_mapper published no map')
        while not listener.publisher.get_subscription_count():
            rclpy.spin_once(listener.node, timeout_sec=0.05)
        rng = np.random.default_rng(seed)
        times = []
        for x, y in rng.uniform(0.5, 9.5, (contacts, 2)):
            listener.wait_for(listener.maps + 1, _REST / config.publish_rate)
            times.append(1e3 * listener.latency((float(x), float(y))))
    finally:
        node.terminate()
        node.wait()
        listener.node.destroy_node()
    return {'map_latency_ms_p50': float(np.median(times)),
            'map_latency_ms_p99': float(np.percentile(times, 99)),
            'map_latency_ms_longest': float(max(times))}


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--contacts', type=int, default=150)
    options = parser.parse_args()
    rclpy.init()
    try:
        print(json.dumps(measure(options.contacts)))
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
