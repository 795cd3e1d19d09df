# SPDX-License-Identifier: Apache-2.0
"""A node of the test's own that publishes what it is told and keeps what it hears."""

import time

import rclpy


class Probe:
    """Speaks and listens on the graph of a test."""

    def __init__(self, name='probe'):
        rclpy.init()
        self.node = rclpy.create_node(name)
        self.heard = {}
        self._publishers = {}

    def listen(self, kind, topic, quality):
        """Keep every message on a topic, in `heard[topic]`."""
        self.heard[topic] = []
        self.node.create_subscription(kind, topic, self.heard[topic].append, quality)

    def speak(self, kind, topic, quality):
        """Prepare to publish on a topic."""
        self._publishers[topic] = self.node.create_publisher(kind, topic, quality)

    def publish(self, topic, message):
        """Publish now."""
        self._publishers[topic].publish(message)

    def spin(self, seconds):
        """Take in messages for a while [s on the wall]."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            rclpy.spin_once(self.node, timeout_sec=left)

    def until(self, condition, seconds=60.0, every=None):
        """Spin until a condition holds, calling `every` now and then; fail when it never does."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, 'waited in vain'
            if every is not None:
                every()
            rclpy.spin_once(self.node, timeout_sec=0.05)

    def is_heard_on(self, topic):
        """Tell whether somebody listens to what is published on a topic."""
        return self._publishers[topic].get_subscription_count() > 0

    def last(self, topic):
        """Return the last message that was heard on a topic."""
        return self.heard[topic][-1]

    def close(self):
        """Leave the graph."""
        self.node.destroy_node()
        rclpy.try_shutdown()
