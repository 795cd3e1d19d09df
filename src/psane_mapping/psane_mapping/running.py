# SPDX-License-Identifier: Apache-2.0
"""How every node starts, takes messages in and ends."""

import sys
from collections import Counter
from collections.abc import Callable
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

from psane_mapping.errors import MessageError, ParameterError
from psane_mapping.quality_of_service import DEFAULT

THROTTLE = 2.0
"""Least time between two equal warnings [s]."""


def run_node(make: Callable[[], Node], arguments: list[str] | None = None) -> None:
    """Spin a node until it is told to stop; a bad parameter ends it with a sentence and status 2.

    Parameters
    ----------
    make : callable
        Builds the node; rclpy is initialised before.
    """
    rclpy.init(args=arguments)
    status = 0
    try:
        node = make()
        try:
            rclpy.spin(node)
        finally:
            node.destroy_node()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except ParameterError as error:
        print(f'psane: {error}', file=sys.stderr)
        status = 2
    finally:
        rclpy.try_shutdown()
    if status:
        sys.exit(status)


class Intake:
    """Drops messages that cannot be used, counts them, and says so now and then.

    Parameters
    ----------
    node : Node
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.dropped: Counter[str] = Counter()

    def subscribe(self, kind: type, topic: str, callback: Callable[[Any], None],
                  quality: Any) -> None:
        """Subscribe, and drop each message at which `callback` raises a `MessageError`."""
        def take(message: Any) -> None:
            try:
                callback(message)
            except MessageError as error:
                self.dropped[topic] += 1
                self._node.get_logger().warning(
                    f'dropped a message on {topic} ({self.dropped[topic]} so far): {error}',
                    throttle_duration_sec=THROTTLE)
        self._node.create_subscription(kind, topic, take, quality)


class Diagnostics:
    """Publishes /diagnostics once a second.

    Parameters
    ----------
    node : Node
    intake : Intake
        Its dropped messages are part of the report.
    report : callable
        Returns (level, message, values) of this moment; level is one of `DiagnosticStatus`.
    """

    def __init__(self, node: Node, intake: Intake,
                 report: Callable[[], tuple[bytes, str, dict[str, object]]]) -> None:
        self._node, self._intake, self._report = node, intake, report
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', DEFAULT)
        node.create_timer(1.0, self.publish)

    def publish(self) -> None:
        """Publish the report of this moment."""
        level, message, values = self._report()
        for topic, count in self._intake.dropped.items():
            values[f'dropped on {topic}'] = count
        status = DiagnosticStatus(
            level=level, name=self._node.get_fully_qualified_name(), message=message,
            hardware_id='psane',
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
