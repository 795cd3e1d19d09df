# SPDX-License-Identifier: Apache-2.0
"""Recorded runs told again to the real nodes, and how what they say now differs."""

import os
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from rclpy.serialization import deserialize_message

from psane_mapping.bag_file import BagFile
from psane_mapping.conversions import cells_of
from psane_reactive.conversions import region_of
from psane_sim.bags.lockstep_times import EVENTS, INPUTS, MILLISECOND, OUTPUTS, PLAN_STEP
from psane_sim.bags.ros_bag_scenarios import feed
from psane_sim.bags.ros_lockstep import LockstepGraph
from psane_sim.bags.ros_message_types import class_of
from psane_sim.bags.ros_quality import replaying

BAGS = Path(__file__).resolve().parent / 'data' / 'bags'
SECONDS = float(os.environ.get('PSANE_BAG_SECONDS', 'inf'))
"""How much of a bag is told [s]."""


@dataclass(frozen=True)
class Said:
    """What the nodes said, message by message: topic -> list of (time [ms], message)."""

    topics: dict
    end: int

    @staticmethod
    def of(messages):
        """Decode messages as they came over the wire."""
        topics = defaultdict(list)
        for message in messages:
            decoded = deserialize_message(message.data, class_of(message.kind))
            topics[message.topic].append((round(message.time / MILLISECOND), decoded))
        return Said(topics, round(messages[-1].time / MILLISECOND))

    def all(self, topic):
        """Return the messages on a topic."""
        return [message for _, message in self.topics[topic]]

    def at_plans(self, topic):
        """Return what held on a topic after each plan: the last message until then, or None."""
        held, position, messages = [], 0, self.topics[topic]
        latest = None
        for now in range(PLAN_STEP, self.end + 1, PLAN_STEP):
            while position < len(messages) and messages[position][0] <= now:
                latest = messages[position][1]
                position += 1
            held.append(latest)
        return held

    def cells(self, topic):
        """Return the cells (rows, columns) that held after each plan, where there were any."""
        return [None if message is None else cells_of(message, 'map')[1]
                for message in self.at_plans(topic)]

    def regions(self):
        """Return the region that held after each plan; an empty one where there was none."""
        found = [None if message is None else region_of(message, 'map')
                 for message in self.at_plans('/safe_region')]
        return [shapely.MultiPolygon() if region is None else region for region in found]

    def subgoals(self):
        """Return the subgoal (2,) after each plan, NaN where the planner offered none."""
        pairs = zip(self.at_plans('/subgoal'), self.at_plans('/planner_status'), strict=True)
        return np.array([(subgoal.pose.position.x, subgoal.pose.position.y)
                         if subgoal is not None and status is not None and status.has_subgoal
                         else (np.nan, np.nan) for subgoal, status in pairs])

    def commands(self):
        """Return the commands (n, 2) [m/s, rad/s]."""
        return np.array([(message.linear.x, message.angular.z)
                         for message in self.all('/cmd_vel')])


@dataclass(frozen=True)
class Replayed:
    """A bag, what it says that was said, what is said now, and the offers then and now."""

    recorded: Said
    now: Said
    offers_then: dict
    offers_now: dict


def replayed(name, logs):
    """Tell the nodes what a bag says that they were told."""
    with BagFile(BAGS / name) as bag:
        messages = [message for message in bag.messages()
                    if message.time <= 1e9 * SECONDS + MILLISECOND]
        topics = {topic.name: topic for topic in bag.topics}
    graph = LockstepGraph(logs, {topic: replaying(topics[topic]) for topic in INPUTS})
    try:
        said = feed(messages, graph)
        offers = graph.offers()
    finally:
        graph.close()
    then = {name: (topics[name].is_reliable, topics[name].is_latched) for name in OUTPUTS}
    now = {name: (offers[name].reliability.name == 'RELIABLE',
                  offers[name].durability.name == 'TRANSIENT_LOCAL') for name in OUTPUTS}
    recorded = [message for message in messages if message.topic not in (*INPUTS, EVENTS)]
    return Replayed(Said.of(recorded), Said.of(said), then, now)
