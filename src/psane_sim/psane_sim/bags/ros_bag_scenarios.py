# SPDX-License-Identifier: Apache-2.0
"""The runs that the tests replay: one that goes well, and one in which much goes wrong."""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from geometry_msgs.msg import Twist
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String

from psane_mapping.bag_file import BagMessage
from psane_mapping.conversions import pose_message
from psane_mapping.quality_of_service import CONTACTS, DEFAULT, ODOMETRY
from psane_msgs.msg import LegContact
from psane_sim.bags.lockstep_times import (
    EVENT_KIND,
    EVENTS,
    INPUTS,
    MILLISECOND,
    OUTPUTS,
    STEP,
)
from psane_sim.bags.ros_conductor import Conductor
from psane_sim.bags.ros_lockstep import LockstepGraph
from psane_sim.bags.ros_message_types import type_of
from psane_sim.bags.ros_quality import quality_of
from psane_sim.bags.ros_stepped_robot import SteppedRobot
from psane_sim.bags.writer import BagWriter

GOAL_TIME = 200
"""When the goal is given [ms]."""

GIVEN = {'/leg_contacts': CONTACTS, '/odom': ODOMETRY, '/goal_pose': DEFAULT}
"""With what quality of service a robot and a user speak."""

Spoil = Callable[[int, list[BagMessage]], list[BagMessage]]


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """One run.

    Parameters
    ----------
    name, terrain : str
    goal : (x, y), map frame [m]
    seed : int
    duration : float
        Simulated time [s].
    spoil : callable
        Makes of the time [ms] and what the robot says what the nodes are told.
    """

    name: str
    terrain: str
    goal: tuple[float, float]
    seed: int
    duration: float
    spoil: Spoil


def _unspoiled(now: int, messages: list[BagMessage]) -> list[BagMessage]:
    return messages


def _faulty(now: int, messages: list[BagMessage]) -> list[BagMessage]:
    """Spoil contacts, lose odometry for a while, restart the mapper."""
    kept = list(messages)
    if 6000 < now <= 7500:
        # The planner may not plan from, nor the controller steer by, what is too old.
        kept = [message for message in kept if message.topic != '/odom']
    if 8500 < now <= 10_500:
        kept = [_spoiled_contact(now, message) for message in kept]
    if now == 12_000:
        words = serialize_message(String(data='restart terrain_mapper'))
        kept.append(BagMessage(EVENTS, EVENT_KIND, now * MILLISECOND, words))
    return kept


def _spoiled_contact(now: int, message: BagMessage) -> BagMessage:
    """Put a contact into a wrong frame, or a number into it that is none, turn by turn."""
    if message.topic == '/odom':
        return message
    contact = deserialize_message(message.data, LegContact)
    if contact.leg % 2:
        contact.header.frame_id = 'odom'
    else:
        contact.measured_vertical[len(contact.measured_vertical) // 2] = math.nan
    return message._replace(data=serialize_message(contact))


SCENARIOS = {scenario.name: scenario for scenario in (
    Scenario(name='env1', terrain='env1', goal=(2.4, 3.2), seed=0, duration=17.0,
             spoil=_unspoiled),
    Scenario(name='faults', terrain='env1', goal=(7.0, 1.5), seed=1, duration=16.0,
             spoil=_faulty))}
"""By name."""


def run(scenario: Scenario, graph: LockstepGraph,
        show: Callable[[int], None] = lambda now: None) -> list[BagMessage]:
    """Let the nodes lead a robot through a scenario; return what they were told and said."""
    conductor = Conductor(graph)
    robot = SteppedRobot(scenario.terrain, scenario.goal, scenario.seed)
    messages: list[BagMessage] = []
    try:
        for now in range(STEP, round(1000 * scenario.duration) + 1, STEP):
            inputs = scenario.spoil(now, robot.step())
            if now == GOAL_TIME:
                inputs.append(_goal(scenario.goal, now))
            said = conductor.step(now, inputs)
            messages += [message._replace(time=now * MILLISECOND) for message in inputs] + said
            robot.command(*_command(said))
            show(now)
    finally:
        robot.close()
    return messages


def record(scenario: Scenario, folder: Path, logs: Path) -> int:
    """Run a scenario and write what was told and said into a bag; return how many messages.

    The time of the bag is simulated time, so that a replay paces it rightly.
    """
    graph = LockstepGraph(logs, GIVEN)
    try:
        messages = run(scenario, graph)
        offers = graph.offers()
    finally:
        graph.close()
    writer = BagWriter(folder)
    numbers = {topic: writer.add_topic(topic, type_of(kind), [quality_of(offers[topic])])
               for topic, kind in {**INPUTS, **OUTPUTS}.items()}
    if any(message.topic == EVENTS for message in messages):
        numbers[EVENTS] = writer.add_topic(EVENTS, type_of(EVENT_KIND), [quality_of(DEFAULT)])
    order: Counter[int] = Counter()
    sequence: Counter[str] = Counter()
    for message in messages:
        # Messages of one step are a nanosecond apart, so that their order is kept.
        moment = message.time + order[message.time]
        order[message.time] += 1
        sequence[message.topic] += 1
        writer.write(numbers[message.topic], message.data, moment, message.time,
                     sequence[message.topic])
    writer.close({})
    return len(messages)


def _goal(goal: tuple[float, float], now: int) -> BagMessage:
    message = pose_message(np.array(goal), 0.0, 1e-3 * now, 'map')
    return BagMessage('/goal_pose', INPUTS['/goal_pose'], now * MILLISECOND,
                      serialize_message(message))


def _command(said: Sequence[BagMessage]) -> tuple[float, float]:
    """Return the last command among messages."""
    raw = next(message.data for message in reversed(said) if message.topic == '/cmd_vel')
    twist = deserialize_message(raw, Twist)
    return twist.linear.x, twist.angular.z


def feed(recorded: Sequence[BagMessage], graph: LockstepGraph) -> list[BagMessage]:
    """Tell the nodes what they were told in a recording; return what they say to it now."""
    conductor = Conductor(graph)
    told = [message for message in recorded if message.topic in (*INPUTS, EVENTS)]
    said: list[BagMessage] = []
    position = 0
    for now in range(STEP, recorded[-1].time // MILLISECOND + 1, STEP):
        first = position
        while position < len(told) and told[position].time <= now * MILLISECOND + MILLISECOND // 2:
            position += 1
        said += conductor.step(now, told[first:position])
    return said
