# SPDX-License-Identifier: Apache-2.0
"""Publishes a bag's messages again, each at its time."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock

from psane_mapping.bag_file import BagFile, BagTopic
from psane_mapping.conversions import stamp
from psane_mapping.errors import BagError
from psane_mapping.quality_of_service import DEFAULT
from psane_sim.bags.read_ahead import ReadAhead
from psane_sim.bags.replay_schedule import CLOCK, Due, schedule
from psane_sim.bags.ros_message_types import class_of, type_of
from psane_sim.bags.ros_quality import replaying
from psane_sim.bags.selection import Renaming, Selection

NAME = 'replay'
LONGEST_SLEEP, LAST_WORDS = 0.1, 2.0
"""Longest wait without a look whether to stop, and for listeners to get the last messages [s]."""


@dataclass(frozen=True, kw_only=True)
class ReplaySettings:
    """How a bag is replayed.

    Parameters
    ----------
    rate : float
        Seconds of the bag for each second on the wall.
    loop : bool
        Begin anew at the end.
    wait : float
        Longest time to wait until somebody listens to each topic [s].
    delay : float
        Time between that and the first message, in which listeners come [s].
    clock_rate : float
        Ticks of /clock in a second of the bag, where the bag holds no /clock of its own [Hz].
    selection : Selection
    renaming : Renaming
    """

    rate: float = 1.0
    loop: bool = False
    wait: float = 0.0
    delay: float = 1.0
    clock_rate: float = 100.0
    selection: Selection = field(default_factory=Selection)
    renaming: Renaming = field(default_factory=Renaming)


class Player:
    """Publishers for a bag's topics.

    Parameters
    ----------
    node : Node
        Holds the publishers; is never spun.
    bag : BagFile
    settings : ReplaySettings

    Raises
    ------
    BagError
        When no topic of the selection is in the bag.
    """

    def __init__(self, node: Node, bag: BagFile, settings: ReplaySettings) -> None:
        self._node, self._bag, self._settings = node, bag, settings
        self._publishers: dict[tuple[str, str], Any] = {}
        self.refused: dict[str, str] = {}
        self.sent = 0
        self.epoch = 0
        for topic in bag.topics:
            if settings.selection.holds(topic.name):
                self._advertise(topic)
        if not self._publishers:
            raise BagError(f'nothing to replay; the bag holds '
                           f'{[topic.name for topic in bag.topics]}')
        self._clock = None
        if settings.clock_rate > 0.0 and CLOCK not in self.topics:
            self._clock = node.create_publisher(Clock, CLOCK, DEFAULT)

    @property
    def topics(self) -> list[str]:
        """Recorded names of what is replayed."""
        return sorted({name for name, _ in self._publishers})

    def _advertise(self, topic: BagTopic) -> None:
        try:
            kind, digest = class_of(topic.kind), type_of(topic.kind).digest
        except BagError as error:
            self.refused[topic.name] = str(error)
            return
        if topic.digest not in ('', digest):
            self.refused[topic.name] = f'{topic.kind} is defined otherwise here than in the bag'
            return
        self._publishers[topic.name, topic.kind] = self._node.create_publisher(
            kind, self._settings.renaming.name_of(topic.name), replaying(topic))

    @property
    def unheard(self) -> list[str]:
        """Names, as they are replayed, of topics that nobody listens to; a made /clock too."""
        publishers = [*self._publishers.values(), *([] if self._clock is None else [self._clock])]
        return sorted({publisher.topic_name for publisher in publishers
                       if publisher.get_subscription_count() == 0})

    def play(self, is_over: Callable[[], bool]) -> None:
        """Publish everything once, each message at its time, or until it is over."""
        clock_rate = 0.0 if self._clock is None else self._settings.clock_rate
        ahead = ReadAhead(schedule(self._bag, self.topics, clock_rate))
        try:
            self.epoch = time.time_ns()
            began = time.monotonic_ns()
            for due in ahead:
                if not _wait_until(began + round(due.offset / self._settings.rate), is_over):
                    return
                self._publish(due)
        finally:
            ahead.close()

    def _publish(self, due: Due) -> None:
        if due.message is not None:
            self._publishers[due.message.topic, due.message.kind].publish(due.message.data)
            self.sent += 1
        elif self._clock is not None:
            self._clock.publish(Clock(clock=stamp(1e-9 * (self._bag.start + due.offset))))

    def finish(self) -> None:
        """Wait until those who listen reliably have everything."""
        for publisher in self._publishers.values():
            publisher.wait_for_all_acked(Duration(seconds=LAST_WORDS))


def _wait_until(due: int, is_over: Callable[[], bool]) -> bool:
    """Sleep until a moment of the monotonic clock [ns]; False when it is over before."""
    while not is_over():
        left = 1e-9 * (due - time.monotonic_ns())
        if left <= 0.0:
            return True
        time.sleep(min(left, LONGEST_SLEEP))
    return False


def _wait_for_listeners(player: Player, longest: float, is_over: Callable[[], bool]) -> bool:
    """Wait until somebody listens to each topic; False when that is not so in time [s]."""
    end = time.monotonic() + longest
    while player.unheard and not is_over():
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True


def replay(bag: BagFile, settings: ReplaySettings, is_over: Callable[[], bool],
           arguments: list[str], warn: Callable[[str], None] = lambda _: None) -> Player:
    """Replay on a graph of one's own making; return the player, which knows what it sent.

    Parameters
    ----------
    warn : callable
        Is told in words what was not waited for any longer.
    """
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node(NAME, enable_rosout=False, start_parameter_services=False)
        player = Player(node, bag, settings)
        if settings.wait > 0.0 and not _wait_for_listeners(player, settings.wait, is_over):
            warn(f'nobody listens to {player.unheard} after {settings.wait:g} s')
        _wait_until(time.monotonic_ns() + round(1e9 * settings.delay), is_over)
        player.play(is_over)
        while settings.loop and not is_over():
            player.play(is_over)
        player.finish()
        node.destroy_node()
        return player
    finally:
        rclpy.try_shutdown()
