# SPDX-License-Identifier: Apache-2.0
"""The stack in one process with the kinematic stand-in for the robot: for statistics.

Map, planner and steering are the very objects that the nodes hold; only the robot, its legs and
what they feel are simple.
"""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.map_cells import MapSteps, cells_of_slip, slip_of_cells
from psane_mapping.mapper import TerrainMapper, TerrainSample
from psane_planner.configuration import PlannerConfiguration
from psane_planner.planner import SafePlanner
from psane_planner.status import Plan
from psane_reactive.command import Mode
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_sim.runs.closed_loop import ENDINGS
from psane_sim.runs.kinematic import KinematicConfiguration, KinematicRobot
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.run_watch import Watch
from psane_sim.runs.scoring import Score, Scorer
from psane_sim.runs.simulated_touch import SimulatedTouch, SimulatedTouchConfiguration
from psane_sim.runs.summary import Ending, Outcome, Task
from psane_sim.terrains.terrain import Terrain

TICK = 0.1
"""Period of motion, commands and scoring [s]."""

ODOMETRY_DEVIATION = 0.005
"""Of the position that map, planner and steering are told [m]."""


@dataclass(frozen=True, kw_only=True)
class KinematicSettings:
    """Configurations of all parts, and the time between plans [s]."""

    robot: KinematicConfiguration = field(default_factory=KinematicConfiguration)
    touch: SimulatedTouchConfiguration = field(default_factory=SimulatedTouchConfiguration)
    mapping: MappingConfiguration = field(default_factory=MappingConfiguration)
    planner: PlannerConfiguration = field(default_factory=PlannerConfiguration)
    reactive: ReactiveConfiguration = field(default_factory=ReactiveConfiguration)
    plan_period: float = 0.2

    @property
    def planner_of_robot(self) -> PlannerConfiguration:
        """The planner's, told how much the strides of this robot are to be believed."""
        return replace(self.planner, stride_allowance=self.robot.stride_allowance,
                       stride_deviation=self.robot.stride_deviation)


class KinematicLoop:
    """One stand-in robot on one terrain with one task.

    Parameters
    ----------
    task : Task
    terrain : Terrain
        The true ground; only robot, touch and scorer see it.
    start_pose : (x, y, yaw), map frame [m], [rad]
    settings : KinematicSettings
    """

    def __init__(self, task: Task, terrain: Terrain, start_pose: tuple[float, float, float],
                 settings: KinematicSettings) -> None:
        self._task = task
        self.settings = settings
        self._goal = None if task.goal is None else np.array(task.goal)
        self._steps = MapSteps.of(settings.mapping)
        self._generator = np.random.default_rng((task.seed, 2))
        self._robot = KinematicRobot(settings.robot, terrain, start_pose, (task.seed, 0))
        self._touch = SimulatedTouch(settings.touch, terrain, (task.seed, 1))
        self._mapper = TerrainMapper(settings.mapping, has_strength_map=False)
        self._planner = SafePlanner(settings.planner_of_robot, self._mapper.grid)
        self._controller = ReactiveController(settings.reactive)
        self._scorer = Scorer(terrain, self._mapper.grid, np.array(start_pose[:2]),
                              task.threshold)
        self.record = RunRecord(grid=self._mapper.grid, start=np.array(start_pose[:2]),
                                goal=self._goal)
        self._maps: tuple[FloatArray, FloatArray] | None = None
        self._maps_version = -1
        self.plan: Plan | None = None
        self.plans = 0

    @property
    def grid(self) -> Grid:
        """Cells of map and plan."""
        return self._mapper.grid

    @property
    def maps(self) -> tuple[FloatArray, FloatArray]:
        """Slip mean and standard deviation (rows, columns) as last published [-]."""
        return self._published_maps()

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""
        return self._robot.time

    @property
    def unsafe_time(self) -> float:
        """Time on unsafe ground so far [s]."""
        return self._scorer.unsafe_time

    def score(self) -> Score:
        """Return the score so far."""
        return self._scorer.score()

    def run(self, watch: Watch | None = None) -> tuple[Outcome, Score]:
        """Run until the planner ends, the time is over or `watch` says so; return the score."""
        began = time.monotonic()
        ending = Ending.TIMEOUT
        plan_ticks = max(1, round(self.settings.plan_period / TICK))
        for tick in range(round(self._task.duration / TICK)):
            if tick % plan_ticks == 0:
                plan = self._replan()
                seen = None if watch is None else watch(self)
                if plan.state in ENDINGS or seen is not None:
                    ending = seen or ENDINGS[plan.state]
                    break
            self._advance()
        last = self.plan
        cause = '' if last is None or ending is Ending.REACHED else last.cause
        outcome = Outcome(ending=ending, cause=cause, time=self._robot.time,
                          subgoals=0 if last is None else last.subgoal_count,
                          contacts=self._mapper.accepted, wall=time.monotonic() - began)
        return outcome, self._scorer.score()

    def _advance(self) -> None:
        """Steer, move, feel and score for one tick."""
        robot = self._robot
        pose = self._believed()
        self._controller.set_odometry(tuple(pose), robot.velocity, robot.time)
        command = self._controller.command(robot.time)
        subgoal = self._controller.inputs.subgoal
        if command.mode is Mode.STUCK and subgoal is not None:
            self._planner.note_stuck(subgoal, robot.time)
        robot.command(command.linear, command.angular)
        self._planner.note_motion(pose, command.linear, command.angular, robot.time)
        ended = robot.step(TICK)
        centre, feet = robot.places()[0], robot.places()[1:]
        for leg in ended:
            sample = self._mapper.add(self._touch.feel(leg, feet[leg], robot.time))
            if isinstance(sample, TerrainSample):
                self.record.note_sample(sample)
        self._scorer.observe(centre, feet, TICK, robot.slip_under())
        self.record.path.append((robot.time, float(robot.pose[0]), float(robot.pose[1])))

    def _believed(self) -> FloatArray:
        noise = ODOMETRY_DEVIATION * self._generator.normal(size=2)
        x, y, yaw = self._robot.pose
        return np.array((x + noise[0], y + noise[1], yaw))

    def _replan(self) -> Plan:
        now = self._robot.time
        mean, std = self._published_maps()
        plan = self._planner.update(mean, std, self._believed(), self._goal, now)
        self.plan = plan
        self.plans += 1
        self._controller.set_region(plan.region, now)
        self._controller.set_subgoal(plan.subgoal, plan.march, plan.subgoal_is_goal, now)
        self._scorer.certified(plan.certified)
        self.record.note_plan(plan, now, (mean, std))
        return plan

    def _published_maps(self) -> tuple[FloatArray, FloatArray]:
        """Return slip mean and std as another node would read them off the topics."""
        if self._maps is None or self._mapper.version != self._maps_version:
            cells = cells_of_slip(self._mapper.maps(), self._steps)
            self._maps = slip_of_cells(*cells, self._steps.std_scale)
            self._maps_version = self._mapper.version
        return self._maps
