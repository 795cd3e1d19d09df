# SPDX-License-Identifier: Apache-2.0
"""Hears a robot's topics for some seconds and hands over what it heard.

Messages are kept as they come over the wire and read when the time is over, by the very functions
that the nodes read them with: what a node would drop is refused here, with the same sentence.
"""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import rclpy
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState

from psane_mapping.contact import LegContact
from psane_mapping.conversions import contact_of, seconds
from psane_mapping.errors import MessageError
from psane_mapping.grid import FloatArray
from psane_msgs.msg import HipWrenches
from psane_msgs.msg import LegContact as LegContactMessage
from psane_sim import conversions
from psane_sim.check.topic_record import Endpoint, Recording, TopicRecord

ANYTHING = QoSProfile(depth=1000, history=HistoryPolicy.KEEP_LAST,
                      reliability=ReliabilityPolicy.BEST_EFFORT,
                      durability=DurabilityPolicy.VOLATILE)
"""Hears every publisher, whatever it offers."""

NAME = 'topic_check'

Reader = Callable[[Any], Any]

KINDS: dict[str, tuple[type, Reader]] = {
    'odom': (Odometry, lambda message: conversions.odometry_of(message, message.header.frame_id)),
    'joint_states': (JointState, conversions.joints_of),
    'hip_wrenches': (HipWrenches,
                     lambda message: conversions.wrenches_of(message, message.header.frame_id)),
    'imu': (Imu, conversions.imu_of),
    'leg_contacts': (LegContactMessage,
                     lambda message: contact_of(message, message.header.frame_id)),
}
"""Type of each topic's messages, and what reads one."""


class _Heard(NamedTuple):
    arrival: float
    raw: bytes


class TopicListener(Node):
    """Keeps every message on a robot's topics.

    Parameters
    ----------
    arguments : list of str
        ROS arguments: remappings and a namespace.
    """

    def __init__(self, arguments: list[str]) -> None:
        super().__init__(NAME, cli_args=arguments, use_global_arguments=False)
        self._began = time.monotonic()
        self._wall = time.time()
        self._heard: dict[str, list[_Heard]] = {name: [] for name in ('/clock', *KINDS)}
        for name in self._heard:
            kind = Clock if name == '/clock' else KINDS[name][0]
            self.create_subscription(kind, name, self._keeper(name), ANYTHING, raw=True)

    def _keeper(self, name: str) -> Callable[[bytes], None]:
        heard = self._heard[name]

        def keep(raw: bytes) -> None:
            heard.append(_Heard(time.monotonic() - self._began, raw))
        return keep

    def recording(self) -> Recording:
        """Return what was heard so far."""
        duration = time.monotonic() - self._began
        ticks = [(entry.arrival, seconds(deserialize_message(entry.raw, Clock).clock))
                 for entry in self._heard['/clock']]
        arrival, now = np.array(ticks).reshape(-1, 2).T
        clock = TopicRecord(publishers=self._who_publishes('/clock'), arrival=arrival, stamp=now)
        topics = {name: self._record(name, clock) for name in KINDS}
        topics['cmd_vel'] = TopicRecord(publishers=self._who_publishes('cmd_vel'),
                                        subscribers=self._who_subscribes('cmd_vel'))
        return Recording(duration=duration, clock=clock, topics=topics)

    def _record(self, name: str, clock: TopicRecord) -> TopicRecord:
        kind, read = KINDS[name]
        headers, values, refusals, read_at = [], [], [], []
        for entry in self._heard[name]:
            message = deserialize_message(entry.raw, kind)
            headers.append((message.header.frame_id, getattr(message, 'child_frame_id', '')))
            try:
                values.append(read(message))
            except MessageError as error:
                refusals.append(str(error))
                continue
            read_at.append((entry.arrival, seconds(message.header.stamp)))
        arrival, stamp = np.array(read_at).reshape(-1, 2).T
        is_odometry = name == 'odom'
        return TopicRecord(
            publishers=self._who_publishes(name), subscribers=self._who_subscribes(name),
            arrival=np.array([entry.arrival for entry in self._heard[name]]), stamp=stamp,
            age=self._time_at(arrival, clock) - stamp,
            frames=frozenset(frame for frame, _ in headers),
            child_frames=frozenset(child for _, child in headers if is_odometry),
            refused=len(refusals), refusal=refusals[0] if refusals else '',
            columns={} if name == 'leg_contacts' else _columns(values),
            contacts=tuple(value for value in values if isinstance(value, LegContact)))

    def _time_at(self, arrival: FloatArray, clock: TopicRecord) -> FloatArray:
        """Return the graph's time at arrivals (n,) [s]; NaN before the first tick of /clock."""
        if not clock.publishers and not clock.count:
            return self._wall + arrival
        before = np.searchsorted(clock.arrival, arrival, side='right') - 1
        stamps = np.concatenate((clock.stamp, [np.nan]))
        return np.asarray(stamps[before])

    def _who_publishes(self, name: str) -> tuple[Endpoint, ...]:
        found = self.get_publishers_info_by_topic(self.resolve_topic_name(name))
        return tuple(_endpoint(info) for info in found if info.node_name != NAME)

    def _who_subscribes(self, name: str) -> tuple[Endpoint, ...]:
        found = self.get_subscriptions_info_by_topic(self.resolve_topic_name(name))
        return tuple(_endpoint(info) for info in found if info.node_name != NAME)


def _endpoint(info: Any) -> Endpoint:
    quality = info.qos_profile
    return Endpoint(node=info.node_name, kind=info.topic_type,
                    is_reliable=quality.reliability == ReliabilityPolicy.RELIABLE,
                    is_latched=quality.durability == DurabilityPolicy.TRANSIENT_LOCAL)


def _columns(samples: list[Any]) -> dict[str, FloatArray]:
    """Return the arrays of sensor samples, stacked in the order of arrival."""
    if not samples:
        return {}
    return {name: np.array([getattr(sample, name) for sample in samples])
            for name in vars(samples[0]) if name != 'time'}


def listen(duration: float, arguments: list[str]) -> Recording:
    """Listen for some seconds on the wall; Ctrl-C ends it earlier."""
    rclpy.init(args=arguments)
    try:
        node = TopicListener(arguments)
        end = time.monotonic() + duration
        try:
            while (left := end - time.monotonic()) > 0.0 and rclpy.ok():
                rclpy.spin_once(node, timeout_sec=left)
        except KeyboardInterrupt:
            pass
        recording = node.recording()
        node.destroy_node()
        return recording
    finally:
        rclpy.try_shutdown()
