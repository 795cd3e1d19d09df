# SPDX-License-Identifier: Apache-2.0
"""A node of the test's own that publishes what it is told and keeps what it hears."""

import time

import rclpy
from node_process import PATIENCE
from rcl_interfaces.srv import GetParameters
from rclpy.duration import Duration


class NothingHeardError(LookupError):
    """Nothing has come on a topic yet."""


def _holds(condition):
    """Tell whether a condition holds; one about a message that has not come yet does not."""
    try:
        return condition()
    except NothingHeardError:
        return False


class Probe:
    """Speaks and listens on the graph of a test."""

    def __init__(self, name='probe'):
        rclpy.init()
        self.node = rclpy.create_node(name)
        self.heard = {}
        self._publishers = {}
        self._questions = {}

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

    def until(self, condition, seconds=PATIENCE, every=None):
        """Spin until a condition holds, calling `every` now and then; fail when it never does."""
        end = time.monotonic() + seconds
        while not _holds(condition):
            assert time.monotonic() < end, 'waited in vain'
            if every is not None:
                every()
            rclpy.spin_once(self.node, timeout_sec=0.05)

    def until_taken(self, topic):
        """Wait until what was published is with all who listen reliably."""
        assert self._publishers[topic].wait_for_all_acked(Duration(seconds=PATIENCE))

    def until_worked_off(self, name):
        """Ask a node for a parameter and wait for the answer.

        Its only thread goes round timers, topics and services and takes one message of each topic
        on each round, so that it cannot fall behind who asks after each message.
        """
        if name not in self._questions:
            self._questions[name] = self.node.create_client(GetParameters,
                                                            f'{name}/get_parameters')
            self.until(self._questions[name].service_is_ready)
        answer = self._questions[name].call_async(GetParameters.Request(names=['use_sim_time']))
        self.until(answer.done)

    def is_heard_on(self, topic):
        """Tell whether somebody listens to what is published on a topic."""
        return self._publishers[topic].get_subscription_count() > 0

    def last(self, topic):
        """Return the last message that was heard on a topic."""
        if not self.heard[topic]:
            raise NothingHeardError(topic)
        return self.heard[topic][-1]

    def close(self):
        """Leave the graph."""
        self.node.destroy_node()
        rclpy.try_shutdown()
