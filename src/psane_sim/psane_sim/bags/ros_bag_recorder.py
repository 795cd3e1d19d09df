# SPDX-License-Identifier: Apache-2.0
"""Takes messages off the graph as they come over the wire, and writes them into a bag.

It does not spin: an executor hands out one message at a time, which is too slow at full rate.
Messages wait in the middleware, which has stamped them with the time of their arrival, until all
that are there are taken at once.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

from psane_mapping.errors import BagError
from psane_sim.bags.recording_report import RecordingReport, TopicCount
from psane_sim.bags.ros_message_types import class_of, type_of
from psane_sim.bags.ros_quality import hears, listening_to, quality_of
from psane_sim.bags.selection import Selection
from psane_sim.bags.sequence_watch import SequenceWatch
from psane_sim.bags.writer import BagWriter

NAME = 'recorder'
LOOK_PERIOD, REST = 0.1, 0.003
"""How often to look for new topics, and how long to rest when nothing waits [s]."""


@dataclass
class _Topic:
    """A topic that is being recorded."""

    name: str
    kind: str
    number: int
    quality: QoSProfile
    subscription: Any
    message: type
    publishers: set[bytes] = field(default_factory=set)
    unheard: set[bytes] = field(default_factory=set)
    watch: SequenceWatch = field(default_factory=SequenceWatch)


class Recorder:
    """Records the topics of a selection, those that appear later too.

    Parameters
    ----------
    node : Node
        Holds the subscriptions; is never spun.
    writer : BagWriter
    selection : Selection
    """

    def __init__(self, node: Node, writer: BagWriter, selection: Selection) -> None:
        self._node, self._writer, self._selection = node, writer, selection
        self._topics: dict[tuple[str, str], _Topic] = {}
        self._refused: dict[str, str] = {}

    def look(self) -> None:
        """Subscribe to what is new on the graph."""
        for name, kinds in self._node.get_topic_names_and_types():
            if not self._selection.holds(name):
                continue
            offers = self._node.get_publishers_info_by_topic(name)
            for kind in kinds:
                offered = [info for info in offers if info.topic_type == kind]
                if offered:
                    self._attend(name, kind, offered)

    def _attend(self, name: str, kind: str, offered: list[Any]) -> None:
        topic = self._topics.get((name, kind))
        if topic is None:
            topic = self._subscribe(name, kind, [info.qos_profile for info in offered])
        if topic is None:
            return
        for info in offered:
            identity = bytes(info.endpoint_gid)
            topic.publishers.add(identity)
            if not hears(topic.quality, info.qos_profile):
                topic.unheard.add(identity)

    def _subscribe(self, name: str, kind: str, profiles: list[QoSProfile]) -> _Topic | None:
        try:
            message, definition = class_of(kind), type_of(kind)
        except BagError as error:
            self._refused[name] = str(error)
            return None
        quality = listening_to(profiles)
        number = self._writer.add_topic(name, definition, [quality_of(one) for one in profiles])
        subscription = self._node.create_subscription(message, name, lambda _: None, quality,
                                                      raw=True)
        topic = _Topic(name, kind, number, quality, subscription, message)
        self._topics[name, kind] = topic
        return topic

    def drain(self) -> int:
        """Write all messages that wait, and return how many there were."""
        before = self._writer.count
        for topic in self._topics.values():
            handle = topic.subscription.handle
            with handle:
                while (taken := handle.take_message(topic.message, True)) is not None:
                    data, info = taken
                    sequence = info['publication_sequence_number'] or 0
                    topic.watch.take(sequence, len(topic.publishers))
                    self._writer.write(
                        topic.number, data, info['received_timestamp'] or time.time_ns(),
                        info['source_timestamp'] or 0, sequence)
        return self._writer.count - before

    def run(self, is_over: Callable[[], bool]) -> None:
        """Record until it is over."""
        looked = -LOOK_PERIOD
        while not is_over():
            if time.monotonic() - looked >= LOOK_PERIOD:
                self.look()
                looked = time.monotonic()
            if not self.drain():
                time.sleep(REST)
        self.drain()

    def report(self) -> RecordingReport:
        """Return what was recorded and what was lost so far."""
        return RecordingReport(topics=tuple(
            TopicCount(name=topic.name, kind=topic.kind, publishers=len(topic.publishers),
                       unheard=len(topic.unheard), recorded=topic.watch.heard,
                       lost=topic.watch.lost, before=topic.watch.before)
            for topic in sorted(self._topics.values(), key=lambda entry: entry.name)),
            refused=dict(self._refused))


def record(writer: BagWriter, selection: Selection, is_over: Callable[[], bool],
           arguments: list[str], name: str = NAME) -> RecordingReport:
    """Record on a graph of one's own making until it is over, close the bag, and report."""
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node(name, enable_rosout=False, start_parameter_services=False)
        recorder = Recorder(node, writer, selection)
        recorder.run(is_over)
        report = recorder.report()
        writer.close(report.notes())
        node.destroy_node()
        return report
    finally:
        rclpy.try_shutdown()
