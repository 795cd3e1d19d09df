# SPDX-License-Identifier: Apache-2.0
"""A run on a real ROS 2 graph: five nodes, each its own process, on this machine alone."""

import shutil
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rclpy
from rclpy.signals import SignalHandlerOptions

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.grid import Grid
from psane_planner.status import PlannerState
from psane_sim.bags.summary import BAG
from psane_sim.demo.node_parameters import listener_parameters, simulator_parameters
from psane_sim.demo.observer import Observer
from psane_sim.demo.options import Assignment
from psane_sim.errors import GraphError
from psane_sim.processes import (
    Death,
    Processes,
    executable,
    ros_arguments,
    use_private_graph,
)
from psane_sim.progress import Progress
from psane_sim.runs.closed_loop import ENDINGS
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.scoring import Score, Scorer
from psane_sim.runs.summary import Ending, Outcome
from psane_sim.runs.truth_log import read_truth

LISTENERS = {'contact_sensor': 'psane_sim', 'terrain_mapper': 'psane_mapping',
             'safe_planner': 'psane_planner', 'reactive_controller': 'psane_reactive'}
"""Nodes that must be up before the world begins, and their packages."""

SIMULATOR, RECORDER = 'hexapod_sim', 'recorder'
STARTING, SILENCE, STANDING = 180.0, 20.0, 0.05
"""Longest start of the nodes (the very first one compiles) and longest silence of the clock, both
on the wall [s]; a robot slower than the last one stands [m/s]."""


@dataclass(frozen=True, kw_only=True)
class GraphSettings:
    """How the graph is run.

    Parameters
    ----------
    out : Path
        Folder for logs and the truth log.
    pace : float
        Simulated seconds for each second on the wall.
    gui : bool
    record : bool
        Record all topics into a bag in `out`.
    """

    out: Path
    pace: float
    gui: bool
    record: bool = False


class GraphRun:
    """Starts the nodes, follows the run to its end and stops what it started.

    Parameters
    ----------
    assignment : Assignment
    settings : GraphSettings
    """

    def __init__(self, assignment: Assignment, settings: GraphSettings) -> None:
        self._assignment = assignment
        self._settings = settings
        self._truth_file = settings.out / 'truth.csv'
        config = MappingConfiguration()
        grid = Grid.over_workspace(config.min_x, config.min_y, config.max_x, config.max_y,
                                   config.resolution)
        task = assignment.task
        start = np.array(task.start)
        self._scorer = Scorer(assignment.terrain, grid, start, task.threshold)
        self.record = RunRecord(grid=grid, start=start,
                                goal=None if task.goal is None else np.array(task.goal))
        self.death: Death | None = None

    def run(self, show: Callable[[Progress], None]) -> tuple[Outcome, Score]:
        """Run until the planner ends, the time is over, a node dies or the user interrupts."""
        use_private_graph()
        self._truth_file.unlink(missing_ok=True)
        processes = Processes(self._settings.out / 'logs')
        for name, package in LISTENERS.items():
            processes.start(name, self._command(name, package))
        if self._settings.record:
            processes.start(RECORDER, self._recording())
        # Its own handlers would shut the context down under the observer before Ctrl-C is noticed.
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        try:
            observer = Observer(self.record, self._scorer)
            began = time.monotonic()
            ending, cause = self._follow(observer, processes, show)
            wall = time.monotonic() - began
        finally:
            # The recorder last, so that it hears what the others say at their end.
            processes.stop(*(name for name in processes.names if name != RECORDER))
            processes.stop()
            rclpy.try_shutdown()
        self._score_truth()
        status = observer.status
        return Outcome(ending=ending, cause=cause, time=observer.time,
                       subgoals=0 if status is None else status.subgoal_count,
                       contacts=len(self.record.contacts), wall=wall), self._scorer.score()

    def _command(self, name: str, package: str) -> list[str]:
        return [sys.executable, str(executable(package, name)),
                *ros_arguments(self._parameters(name))]

    def _recording(self) -> list[str]:
        """Return the command that records, and make room for its bag."""
        bag = self._settings.out / BAG
        shutil.rmtree(bag, ignore_errors=True)
        return [sys.executable, str(executable('psane_sim', 'record')), '--out', str(bag)]

    def _parameters(self, name: str) -> dict[str, object]:
        settings = self._settings
        if name != SIMULATOR:
            return listener_parameters(self._assignment, name)
        return {**simulator_parameters(self._assignment, settings.pace, self._truth_file),
                'gui': settings.gui, 'awaited_listener': RECORDER if settings.record else "''"}

    def _follow(self, observer: Observer, processes: Processes,
                show: Callable[[Progress], None]) -> tuple[Ending, str]:
        """Bring the graph up and watch it until there is a reason to end."""
        try:
            self._wait(observer, processes, show)
            processes.start(SIMULATOR, self._command(SIMULATOR, 'psane_sim'))
            return self._watch(observer, processes, show)
        except KeyboardInterrupt:
            return Ending.INTERRUPTED, ''
        except _NodeDied as error:
            self.death = error.death
            self._halt(observer, processes)
            return Ending.NODE_DIED, error.death.in_words

    def _wait(self, observer: Observer, processes: Processes,
              show: Callable[[Progress], None]) -> None:
        """Wait until all listeners are on the graph, so that they miss nothing.

        Raises
        ------
        GraphError
            When they do not come up in time.
        """
        deadline = time.monotonic() + STARTING
        awaited = {*LISTENERS, *((RECORDER,) if self._settings.record else ())}
        while missing := sorted(awaited - observer.present_nodes()):
            self._spin(observer, processes)
            show(observer.starting(missing))
            if time.monotonic() > deadline:
                raise GraphError(f'{missing} did not come up within {STARTING:g} s; their logs '
                                 f'are in {self._settings.out / "logs"}')

    def _watch(self, observer: Observer, processes: Processes,
               show: Callable[[Progress], None]) -> tuple[Ending, str]:
        goal = self._assignment.task.goal
        heard, clock, patience = time.monotonic(), 0.0, STARTING
        while True:
            self._spin(observer, processes)
            if observer.time != clock:
                heard, clock, patience = time.monotonic(), observer.time, SILENCE
            if time.monotonic() - heard > patience:
                return Ending.NODE_DIED, f'{SIMULATOR} has published no clock for {patience:g} s'
            if clock == 0.0:
                show(observer.starting([SIMULATOR]))
                continue
            show(observer.progress())
            if goal is not None and observer.is_heard():
                observer.send_goal(goal)
                goal = None
            if observer.time >= self._assignment.task.duration:
                return Ending.TIMEOUT, ''
            status = observer.status
            if status is not None and PlannerState(status.state) in ENDINGS:
                ending = ENDINGS[PlannerState(status.state)]
                return ending, '' if ending is Ending.REACHED else status.cause

    def _spin(self, observer: Observer, processes: Processes) -> None:
        """Take in messages for a moment; raise when a node died."""
        deadline = time.monotonic() + 0.05
        while (left := deadline - time.monotonic()) > 0.0:
            rclpy.spin_once(observer, timeout_sec=left)
        death = processes.death()
        if death is not None:
            raise _NodeDied(death)

    def _halt(self, observer: Observer, processes: Processes) -> None:
        """Take the controller's voice away and wait until the robot stands."""
        death = self.death
        if death is None or death.name == SIMULATOR:
            return
        if death.name != 'reactive_controller':
            processes.stop('reactive_controller')
        since, deadline = observer.time, time.monotonic() + SILENCE
        while time.monotonic() < deadline:
            rclpy.spin_once(observer, timeout_sec=0.05)
            if observer.time - since > 1.0 and observer.speed < STANDING:
                return

    def _score_truth(self) -> None:
        """Score the true way, which the simulator left in a file."""
        score_truth(self._truth_file, self._scorer, self.record)


def score_truth(path: Path, scorer: Scorer, record: RunRecord) -> None:
    """Score the way in a truth log, and keep it; a log that is not there says nothing."""
    if not path.is_file():
        return
    last = 0.0
    for entry in read_truth(path):
        scorer.observe(entry.pose[:2], entry.grounded_feet, entry.time - last)
        record.path.append((entry.time, float(entry.pose[0]), float(entry.pose[1])))
        record.truth.append(entry)
        last = entry.time


class _NodeDied(Exception):
    """Carries the death out of the spinning."""

    def __init__(self, death: Death) -> None:
        super().__init__(death.name)
        self.death = death
