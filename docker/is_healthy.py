#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Succeeds when a node says on /diagnostics, once a second as each does, that all is not lost.

A node that hangs is silent; one that runs on the simulator's clock is too when the simulator is
gone.
"""

import argparse
import sys
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus


def is_healthy(name: str, patience: float) -> bool:
    """Listen for a node, by its name without namespace, at most so many seconds."""
    heard: list[bytes] = []

    def take(message: DiagnosticArray) -> None:
        heard.extend(status.level for status in message.status
                     if status.name.split('/')[-1] == name)
    rclpy.init()
    try:
        node = rclpy.create_node(f'health_of_{name}')
        node.create_subscription(DiagnosticArray, '/diagnostics', take, 10)
        end = time.monotonic() + patience
        while not heard and time.monotonic() < end:
            rclpy.spin_once(node, timeout_sec=0.1)
        node.destroy_node()
    finally:
        rclpy.try_shutdown()
    return bool(heard) and heard[-1] in (DiagnosticStatus.OK, DiagnosticStatus.WARN)


def main() -> None:
    """End with status 0 when the node is healthy, else 1."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('node', help='for instance terrain_mapper')
    parser.add_argument('--patience', type=float, default=15.0, help='time to listen [s]')
    options = parser.parse_args()
    sys.exit(0 if is_healthy(options.node, options.patience) else 1)


if __name__ == '__main__':
    main()
