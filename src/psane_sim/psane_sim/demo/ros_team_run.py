# SPDX-License-Identifier: Apache-2.0
"""Several robots on one ROS 2 graph: a namespace for each, one mapper at the root for all.

Each robot has a simulator of its own on the same terrain; the first one's clock leads, and the
others keep step with it. Contacts between robots are not simulated. A robot is told, on its topic
`keep_out`, to leave room for the robots before it.
"""

import math
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import rclpy
from nav_msgs.msg import OccupancyGrid
from rclpy.executors import SingleThreadedExecutor
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.conversions import occupancy_message
from psane_mapping.grid import Grid
from psane_mapping.quality_of_service import LATCHED
from psane_planner.status import PlannerState
from psane_sim.demo.graph_run import LISTENERS, SILENCE, SIMULATOR, STARTING, score_truth
from psane_sim.demo.node_parameters import listener_parameters, simulator_parameters
from psane_sim.demo.observer import FRAME, Observer, shared_map_arguments
from psane_sim.errors import GraphError
from psane_sim.processes import (
    Processes,
    executable,
    ros_arguments,
    use_private_graph,
)
from psane_sim.progress import Progress
from psane_sim.runs.neighbours import taken_cells
from psane_sim.runs.patience import Patience
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.scoring import Scorer
from psane_sim.runs.summary import Ending, Outcome
from psane_sim.runs.team_loop import Member, MemberRun

MAPPER = 'terrain_mapper'
OWN = tuple(name for name in LISTENERS if name != MAPPER)
"""Nodes that each robot has for itself."""

ROOM_PERIOD = 0.5
"""Simulated time between looks at who is in whose way [s]."""


def namespace_of(index: int) -> str:
    """Return the namespace of a robot, counted from 0."""
    return f'robot{index + 1}'


class TeamRun:
    """Starts all nodes of a team, follows the run to its end and stops what it started.

    Parameters
    ----------
    members : sequence of Member
        Those further back give way.
    out : Path
        Folder for logs and truth logs.
    pace : float
        Simulated seconds for each second on the wall.
    """

    def __init__(self, members: Sequence[Member], out: Path, pace: float) -> None:
        self._members, self._out, self._pace = tuple(members), out, pace
        config = MappingConfiguration()
        self._grid = Grid.over_workspace(config.min_x, config.min_y, config.max_x, config.max_y,
                                         config.resolution)
        self._robots = [namespace_of(index) for index in range(len(members))]
        self._scorers = [self._scorer(member) for member in members]
        self._records = [self._record(member) for member in members]
        self._duration = max(member.assignment.task.duration for member in members)
        self._endings: dict[int, tuple[Ending, str, float]] = {}

    def _scorer(self, member: Member) -> Scorer:
        task = member.assignment.task
        return Scorer(member.assignment.terrain, self._grid, np.array(task.start),
                      task.threshold)

    def _record(self, member: Member) -> RunRecord:
        task = member.assignment.task
        goal = None if task.goal is None else np.array(task.goal)
        return RunRecord(grid=self._grid, start=np.array(task.start), goal=goal)

    def run(self, show: Callable[[Progress], None]) -> list[MemberRun]:
        """Run until every planner ended, the time is over, a node dies or the user interrupts."""
        use_private_graph()
        processes = Processes(self._out / 'logs')
        self._start_listeners(processes)
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        began = time.monotonic()
        graph: _Graph | None = None
        try:
            graph = _Graph(self._robots, self._records, self._scorers, self._grid, processes)
            self._wait(graph, show)
            began = time.monotonic()
            rest, cause = self._watch(graph, processes, show)
        except KeyboardInterrupt:
            rest, cause = Ending.INTERRUPTED, ''
        finally:
            processes.stop()
            rclpy.try_shutdown()
        wall = time.monotonic() - began
        return [self._result(index, rest, cause, graph, wall)
                for index in range(len(self._robots))]

    def _start_listeners(self, processes: Processes) -> None:
        topics = ','.join(f'{robot}/leg_contacts' for robot in self._robots)
        first = self._members[0].assignment
        self._start(processes, MAPPER, '', {**listener_parameters(first, MAPPER),
                                            'contact_topics': topics})
        for robot, member in zip(self._robots, self._members, strict=True):
            for name in OWN:
                self._start(processes, name, robot, listener_parameters(member.assignment, name))

    def _start_simulator(self, processes: Processes, index: int) -> None:
        truth = self._truth_file(index)
        truth.unlink(missing_ok=True)
        self._start(processes, SIMULATOR, self._robots[index], {
            **simulator_parameters(self._members[index].assignment, self._pace, truth),
            'follow_clock': index > 0})

    def _start(self, processes: Processes, name: str, robot: str,
               parameters: dict[str, object]) -> None:
        package = LISTENERS.get(name, 'psane_sim')
        command = [sys.executable, str(executable(package, name)), *ros_arguments(parameters)]
        if robot:
            command += ['-r', f'__ns:=/{robot}', *shared_map_arguments()[1:]]
        processes.start(f'{robot}_{name}'.strip('_'), command)

    def _truth_file(self, index: int) -> Path:
        return self._out / f'truth_{self._robots[index]}.csv'

    def _wait(self, graph: '_Graph', show: Callable[[Progress], None]) -> None:
        """Wait until everybody listens, then start the simulators: the one that leads last."""
        graph.wait_for({f'/{MAPPER}'} | {f'/{robot}/{name}' for robot in self._robots
                                         for name in OWN}, show)
        for index in reversed(range(len(self._robots))):
            self._start_simulator(graph.processes, index)
            graph.wait_for({f'/{self._robots[index]}/{SIMULATOR}'}, show)

    def _watch(self, graph: '_Graph', processes: Processes,
               show: Callable[[Progress], None]) -> tuple[Ending, str]:
        sent: set[int] = set()
        patience = [Patience() for _ in self._robots]
        heard, clock, limit = time.monotonic(), 0.0, STARTING
        while len(self._endings) < len(self._robots):
            graph.spin()
            death = processes.death()
            if death is not None:
                return Ending.NODE_DIED, death.in_words
            now = graph.time
            if now != clock:
                heard, clock, limit = time.monotonic(), now, SILENCE
            if time.monotonic() - heard > limit:
                return Ending.NODE_DIED, f'{SIMULATOR} has published no clock for {limit:g} s'
            if now >= self._duration:
                break
            for index in range(len(self._robots)):
                self._look_after(index, graph.observers[index], sent, patience[index], now)
            show(self._progress(graph))
        return Ending.TIMEOUT, ''

    def _look_after(self, index: int, observer: Observer, sent: set[int], patience: Patience,
                    now: float) -> None:
        """Give a robot its goal when it is time; note how its run ends."""
        member, goal = self._members[index], self._members[index].assignment.task.goal
        if index not in sent:
            if goal is not None and now >= member.departure and observer.is_heard():
                observer.send_goal(goal)
                sent.add(index)
            return
        status = observer.status
        if status is None or index in self._endings or math.isnan(status.distance_to_goal):
            return
        ending = patience.ending(PlannerState(status.state), now)
        if ending is not None:
            cause = '' if ending is Ending.REACHED else status.cause
            self._endings[index] = (ending, cause, now - member.departure)

    def _progress(self, graph: '_Graph') -> Progress:
        """Return what the line shows: the robot that is not there yet, the first of them."""
        waiting = [index for index in range(len(self._robots)) if index not in self._endings]
        index = waiting[0] if waiting else len(self._robots) - 1
        progress = graph.observers[index].progress()
        return Progress(time=graph.time, distance=progress.distance, area=progress.area,
                        contacts=progress.contacts, cause=progress.cause,
                        state=f'{self._robots[index]} {progress.state}')

    def _result(self, index: int, rest: Ending, cause: str, graph: '_Graph | None',
                wall: float) -> MemberRun:
        record, scorer = self._records[index], self._scorers[index]
        score_truth(self._truth_file(index), scorer, record)
        now = 0.0 if graph is None else graph.time
        ending, cause, took = self._endings.get(
            index, (rest, cause, max(0.0, now - self._members[index].departure)))
        status = None if graph is None else graph.observers[index].status
        outcome = Outcome(ending=ending, cause=cause, time=took,
                          subgoals=0 if status is None else status.subgoal_count,
                          contacts=len(record.contacts), wall=wall)
        return MemberRun(record=record, outcome=outcome, score=scorer.score())


class _Graph:
    """The demo's own ears and voice on the graph: an observer for each robot."""

    def __init__(self, robots: Sequence[str], records: Sequence[RunRecord],
                 scorers: Sequence[Scorer], grid: Grid, processes: Processes) -> None:
        self.processes = processes
        self.observers = [Observer(record, scorer, robot) for robot, record, scorer
                          in zip(robots, records, scorers, strict=True)]
        self._grid = grid
        self._keep_out: list[Publisher] = [
            observer.create_publisher(OccupancyGrid, 'keep_out', LATCHED)
            for observer in self.observers]
        self._executor = SingleThreadedExecutor()
        for observer in self.observers:
            self._executor.add_node(observer)
        self._looked = -np.inf

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return max(observer.time for observer in self.observers)

    def spin(self) -> None:
        """Take in messages for a moment, and make room where robots meet."""
        end = time.monotonic() + 0.05
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)
        if self.time - self._looked >= ROOM_PERIOD:
            self._looked = self.time
            self._make_room()

    def _make_room(self) -> None:
        for index in range(1, len(self.observers)):
            others = [position for observer in self.observers[:index]
                      if (position := observer.position) is not None]
            cells = np.where(taken_cells(self._grid, others), 100, 0).astype(np.int8)
            self._keep_out[index].publish(
                occupancy_message(self._grid, cells, self.time, FRAME))

    def wait_for(self, names: set[str], show: Callable[[Progress], None]) -> None:
        """Wait until nodes are on the graph.

        Raises
        ------
        GraphError
            When they do not come up in time, or one of them dies.
        """
        first, deadline = self.observers[0], time.monotonic() + STARTING
        while missing := sorted(names - set(first.get_fully_qualified_node_names())):
            self.spin()
            show(first.starting(missing))
            death = self.processes.death()
            if death is not None:
                raise GraphError(death.in_words)
            if time.monotonic() > deadline:
                raise GraphError(f'{missing} did not come up within {STARTING:g} s')
