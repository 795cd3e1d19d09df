# SPDX-License-Identifier: Apache-2.0
"""Leads the nodes through time: contacts and odometry, then map, plan and command when due."""

import time
from collections.abc import Sequence

from psane_mapping.bag_file import BagMessage
from psane_sim.bags.lockstep_times import (
    EVENTS,
    INPUTS,
    MAP_RETRY,
    MILLISECOND,
    PLAN_STEP,
    is_plan_time,
)
from psane_sim.bags.ros_lockstep import CONTROLLER, MAPPER, PLANNER, LockstepGraph
from psane_sim.errors import GraphError

REST, PATIENCE = 0.02, 15.0
"""Time given to a mapper that has just published a map before its clock ticks again, and longest
wait for what a node says when its time has moved on [s]."""


class Conductor:
    """Moves a graph on, step by step.

    Parameters
    ----------
    graph : LockstepGraph
    """

    def __init__(self, graph: LockstepGraph) -> None:
        self._graph = graph
        self._unmapped = 0

    def step(self, now: int, inputs: Sequence[BagMessage]) -> list[BagMessage]:
        """Tell the nodes some inputs, let them do what is due, and return what they said.

        Parameters
        ----------
        now : int
            Time of the step [ms].
        inputs : sequence of BagMessage
            In the order of telling.
        """
        graph = self._graph
        graph.now = now * MILLISECOND
        for message in inputs:
            if message.topic == EVENTS:
                self._happen(message.data)
        for topic in INPUTS:
            graph.tell(topic, [message.data for message in inputs if message.topic == topic])
        # The planner takes in odometry and the last command while the others work.
        graph.ask(PLANNER)
        said = self._listen()
        if is_plan_time(now):
            said += self._map(now)
            graph.await_answer(PLANNER)
            graph.tick(PLANNER, now * MILLISECOND)
            said += self._hear('/planner_status')
        graph.tick(CONTROLLER, now * MILLISECOND)
        said += self._hear('/cmd_vel')
        if not is_plan_time(now):
            graph.await_answer(PLANNER)
        return [message._replace(time=now * MILLISECOND) for message in said]

    def _listen(self) -> list[BagMessage]:
        said = self._graph.take()
        self._unmapped += sum(message.topic == '/terrain_samples' for message in said)
        if any(message.topic == '/slip/std' for message in said):
            self._unmapped = 0
        return said

    def _hear(self, topic: str) -> list[BagMessage]:
        """Listen until a topic was spoken on: on a busy machine, that may come after the answer.

        Raises
        ------
        GraphError
            When nothing comes.
        """
        said = self._listen()
        deadline = time.monotonic() + PATIENCE
        while not any(message.topic == topic for message in said):
            if time.monotonic() > deadline:
                raise GraphError(f'nothing came on {topic} at {1e-9 * self._graph.now:.2f} s')
            time.sleep(1e-3)
            said += self._listen()
        return said

    def _map(self, now: int) -> list[BagMessage]:
        """Tick the mapper until what it felt is on the map.

        It spares its time for contacts: having published, it rests for a while on the wall.
        """
        said: list[BagMessage] = []
        for tick in range(now, now + PLAN_STEP, MAP_RETRY):
            self._graph.tick(MAPPER, tick * MILLISECOND)
            said += self._listen()
            if not self._unmapped:
                break
            time.sleep(REST)
        return said

    def _happen(self, event: bytes) -> None:
        """Let happen what the letters of an event say."""
        if b'restart terrain_mapper' not in event:
            raise GraphError(f'unknown event {event!r}')
        self._graph.restart(MAPPER)
        self._unmapped = 0
