# SPDX-License-Identifier: Apache-2.0
"""Time from a contact to its map, on a graph of its own."""

import rclpy

from psane_mapping import ros_latency_benchmark
from psane_sim.processes import use_private_graph


def measure() -> dict[str, float]:
    """Return the figures of `ros_latency_benchmark` [ms], measured on a private graph."""
    use_private_graph()
    rclpy.init(args=[])
    try:
        return ros_latency_benchmark.measure()
    finally:
        rclpy.try_shutdown()
