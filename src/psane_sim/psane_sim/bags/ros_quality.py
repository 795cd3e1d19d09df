# SPDX-License-Identifier: Apache-2.0
"""Qualities of service as bags hold them, and those that fit what publishers offer."""

from collections.abc import Sequence
from typing import Any

from rclpy.duration import Infinite
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from psane_mapping.bag_file import BagTopic
from psane_sim.bags.writer import Quality

RECORDED_DEPTH, REPLAYED_DEPTH, LATCHED_DEPTH = 10_000, 100, 1
"""Messages that wait for the recorder, that a replay keeps, and that a latched topic keeps."""


def quality_of(profile: QoSProfile) -> Quality:
    """Return a profile with the names that rosbag2 writes."""
    return {
        'history': profile.history.name.lower(), 'depth': int(profile.depth),
        'reliability': profile.reliability.name.lower(),
        'durability': profile.durability.name.lower(),
        'deadline': _time(profile.deadline), 'lifespan': _time(profile.lifespan),
        'liveliness': profile.liveliness.name.lower(),
        'liveliness_lease_duration': _time(profile.liveliness_lease_duration),
        'avoid_ros_namespace_conventions': bool(profile.avoid_ros_namespace_conventions)}


def _time(duration: Any) -> dict[str, int]:
    """Return a duration; 0 stands for no limit, which the graph shows as the longest time."""
    if duration.nanoseconds == 0:
        duration = Infinite
    seconds, nanoseconds = divmod(int(duration.nanoseconds), 10**9)
    return {'sec': seconds, 'nsec': nanoseconds}


def listening_to(offered: Sequence[QoSProfile]) -> QoSProfile:
    """Return a profile that hears all of some publishers, as surely as they all allow."""
    is_reliable = all(one.reliability == ReliabilityPolicy.RELIABLE for one in offered)
    is_latched = all(one.durability == DurabilityPolicy.TRANSIENT_LOCAL for one in offered)
    return _profile(RECORDED_DEPTH, is_reliable, is_latched)


def hears(listening: QoSProfile, offered: QoSProfile) -> bool:
    """Tell whether a subscription with one profile hears a publisher with another."""
    reliably = listening.reliability == ReliabilityPolicy.RELIABLE
    late = listening.durability == DurabilityPolicy.TRANSIENT_LOCAL
    return ((not reliably or offered.reliability == ReliabilityPolicy.RELIABLE)
            and (not late or offered.durability == DurabilityPolicy.TRANSIENT_LOCAL))


def replaying(topic: BagTopic) -> QoSProfile:
    """Return the profile with which a topic is published again; reliable where a bag is silent."""
    is_latched = bool(topic.is_latched)
    depth = LATCHED_DEPTH if is_latched else REPLAYED_DEPTH
    return _profile(depth, topic.is_reliable is not False, is_latched)


def _profile(depth: int, is_reliable: bool, is_latched: bool) -> QoSProfile:
    reliability = ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT
    durability = (DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE)
    return QoSProfile(depth=depth, history=HistoryPolicy.KEEP_LAST, reliability=reliability,
                      durability=durability)
