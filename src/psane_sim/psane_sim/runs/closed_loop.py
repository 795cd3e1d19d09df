# SPDX-License-Identifier: Apache-2.0
"""The whole stack in one process, without ROS: deterministic from its seed, faster than real time.

The objects are those that the nodes hold, the rates those of the topics, and the maps pass through
the cells of an OccupancyGrid as they do between nodes.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_mapping.map_cells import SLIP_MEAN, SLIP_STD, MapSteps, cells_of_maps, slip_of_cells
from psane_mapping.mapper import TerrainMapper, TerrainSample
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import Mask
from psane_planner.planner import SafePlanner
from psane_planner.status import Plan, PlannerState
from psane_reactive.balance import Tilt
from psane_reactive.command import Mode
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.progress import Progress
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.robot.truth import Truth
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.run_watch import Watch
from psane_sim.runs.scoring import Score, Scorer
from psane_sim.runs.summary import Ending, Outcome, Task
from psane_sim.runs.truth_log import TruthEntry
from psane_sim.terrains.terrain import Terrain
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.contact_sensing import ContactSensor
from psane_sim.touch.method import TouchMethod, felt_by
from psane_sim.touch.sensing import Sensors

SENSOR_PERIOD = 5
"""Milliseconds between readings of joints, wrenches and the inertial unit."""

ODOMETRY_PERIOD, COMMAND_PERIOD, PLAN_PERIOD, SCORE_PERIOD = 20, 50, 200, 50
"""Milliseconds between odometry, commands, plans and looks at the truth."""

ENDINGS = {PlannerState.REACHED: Ending.REACHED, PlannerState.EXPLORED: Ending.EXPLORED,
           PlannerState.STALLED: Ending.STALLED}


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Configurations of all parts."""

    simulator: SimulatorConfiguration = field(default_factory=SimulatorConfiguration)
    touch: TouchConfiguration = field(default_factory=TouchConfiguration)
    mapping: MappingConfiguration = field(default_factory=MappingConfiguration)
    planner: PlannerConfiguration = field(default_factory=PlannerConfiguration)
    reactive: ReactiveConfiguration = field(default_factory=ReactiveConfiguration)
    robot: RobotModel = field(default_factory=RobotModel)
    touch_method: TouchMethod = TouchMethod.FORCE_AND_TORQUE


class ClosedLoop:
    """One robot on one terrain with one task.

    Parameters
    ----------
    task : Task
    terrain : Terrain
        The true ground; only the simulator and the scorer see it.
    start_pose : (x, y, yaw), map frame [m], [rad]
    settings : Settings
    mapper : TerrainMapper, optional
        A map that other robots share; one of its own if there is none.
    controller : ReactiveController, optional
        One that somebody watches; one of its own if there is none.

    Attributes
    ----------
    is_waiting : bool
        The robot has no task yet.
    keep_out : (rows, columns) bool or None
        Ground that is not to be certified now.
    """

    def __init__(self, task: Task, terrain: Terrain, start_pose: tuple[float, float, float],
                 settings: Settings, mapper: TerrainMapper | None = None,
                 controller: ReactiveController | None = None) -> None:
        self._task = task
        self._goal = None if task.goal is None else np.array(task.goal)
        self.settings = settings
        self._simulator = HexapodSimulator(settings.simulator, terrain, start_pose,
                                           robot=settings.robot)
        self._sensors = Sensors(settings.simulator, task.seed)
        self._contact_sensor = ContactSensor(settings.touch, settings.robot)
        self._contact_sensor.warm_up()
        self._felt = felt_by(settings.touch_method, terrain)
        self._mapper = mapper or TerrainMapper(settings.mapping)
        self._mapper.warm_up()
        self._planner = SafePlanner(settings.planner, self._mapper.grid)
        self._planner.warm_up()
        self._controller = controller or ReactiveController(settings.reactive)
        self._controller.warm_up()
        self._scorer = Scorer(terrain, self._mapper.grid, np.array(start_pose[:2]),
                              task.threshold)
        self.record = RunRecord(grid=self._mapper.grid, start=np.array(start_pose[:2]),
                                goal=self._goal)
        self._pose = np.array(start_pose)
        self._asked = (0.0, 0.0)
        self._planned: tuple[FloatArray, FloatArray] | None = None
        self._planned_version = -1
        self.plan: Plan | None = None
        self.is_waiting = False
        self.keep_out: Mask | None = None

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""
        return self._simulator.time

    def run(self, show: Callable[[Progress], None] | None = None,
            watch: Watch | None = None) -> tuple[Outcome, Score]:
        """Run until the planner ends, the time is over, `watch` says so or the user interrupts.

        `watch` is called after each plan; what it returns, if anything, ends the run.
        """
        began = time.monotonic()
        ending, tick = Ending.TIMEOUT, 0
        try:
            for tick in range(0, round(1000.0 * self._task.duration), SENSOR_PERIOD):
                self.advance(tick)
                if self.plan is not None and tick % PLAN_PERIOD == 0:
                    if show is not None:
                        show(self.progress())
                    seen = None if watch is None else watch(self)
                    if self.plan.state in ENDINGS or seen is not None:
                        ending = seen or ENDINGS[self.plan.state]
                        break
        except KeyboardInterrupt:
            ending = Ending.INTERRUPTED
        finally:
            self.close()
        return self.outcome(ending, time.monotonic() - began), self.score()

    def close(self) -> None:
        """Close the simulator."""
        self._simulator.close()

    @property
    def position(self) -> tuple[float, float]:
        """Where odometry says that the robot is, map frame [m]."""
        return float(self._pose[0]), float(self._pose[1])

    @property
    def unsafe_time(self) -> float:
        """Time on unsafe ground so far [s]."""
        return self._scorer.unsafe_time

    def score(self) -> Score:
        """Return the score so far."""
        return self._scorer.score()

    def outcome(self, ending: Ending, wall: float) -> Outcome:
        """Return how the run ended."""
        plan = self.plan
        refused = (*self._mapper.rejected.items(), *self._contact_sensor.dropped.items())
        self.record.refused = {reason.value: count for reason, count in refused}
        cause = '' if plan is None or ending is Ending.REACHED else plan.cause
        return Outcome(ending=ending, cause=cause, time=self._simulator.time,
                       subgoals=0 if plan is None else plan.subgoal_count,
                       contacts=len(self.record.contacts), wall=wall)

    def advance(self, tick: int) -> None:
        """Move on by one sensor period: sense, map, plan, steer, each at its own rate."""
        self._simulator.step(SENSOR_PERIOD)
        truth = self._simulator.truth()
        if tick % ODOMETRY_PERIOD == 0:
            self._take_odometry(truth)
        contacts = self._contact_sensor.update(
            self._sensors.joints(truth), self._sensors.wrenches(truth), self._sensors.imu(truth))
        for contact in contacts:
            sample = self._mapper.add(self._felt(contact))
            if isinstance(sample, TerrainSample):
                self.record.note_sample(sample)
        now = self._simulator.time
        if tick % PLAN_PERIOD == 0:
            self._plan(now)
            self.record.postures.append((now, *truth.position, *truth.quaternion,
                                         *truth.joint_angle))
        if tick % COMMAND_PERIOD == 0:
            command = self._controller.command(now)
            subgoal = self._controller.inputs.subgoal
            if command.mode is Mode.STUCK and subgoal is not None:
                self._planner.note_stuck(subgoal, now)
            self._simulator.command(command.linear, command.angular)
            self._asked = (command.linear, command.angular)
        if tick % SCORE_PERIOD == 0:
            entry = TruthEntry.of(truth)
            self.record.truth.append(entry)
            self._scorer.observe(entry.pose[:2], entry.grounded_feet, 1e-3 * SCORE_PERIOD)
            self.record.path.append((now, float(entry.pose[0]), float(entry.pose[1])))

    def _take_odometry(self, truth: Truth) -> None:
        sample = self._sensors.odometry(truth)
        self._contact_sensor.set_odometry(sample)
        self._pose = np.array([sample.position[0], sample.position[1], sample.yaw])
        self._controller.set_odometry(
            tuple(self._pose), (float(sample.velocity[0]), float(sample.angular_velocity[2])),
            sample.time, Tilt.of_quaternion(*sample.quaternion))
        self._planner.note_motion(self._pose, *self._asked, sample.time)

    def _plan(self, now: float) -> None:
        """Plan on the newest maps, and hand region and subgoal to the controller."""
        maps = self._published_maps()
        plan = (self._planner.idle(now) if self.is_waiting else
                self._planner.update(*maps, self._pose, self._goal, now, self.keep_out))
        self.plan = plan
        self._controller.set_region(plan.region, now)
        self._controller.set_subgoal(plan.subgoal, plan.march, plan.subgoal_is_goal, now)
        self._scorer.certified(plan.certified)
        self.record.note_plan(plan, now, maps)

    def _published_maps(self) -> tuple[FloatArray, FloatArray]:
        """Return slip mean and std as another node would read them off the topics."""
        if self._planned is None or self._mapper.version != self._planned_version:
            steps = MapSteps.of(self.settings.mapping)
            cells = cells_of_maps(self._mapper.maps(), steps)
            self._planned = slip_of_cells(cells[SLIP_MEAN], cells[SLIP_STD], steps.std_scale)
            self._planned_version = self._mapper.version
        return self._planned

    def progress(self) -> Progress:
        """Return what the progress line shows."""
        plan, contacts = self.plan, len(self.record.contacts)
        if plan is None:
            return Progress(time=self._simulator.time, distance=None, area=0.0,
                            contacts=contacts, state='WAITING')
        return Progress(
            time=self._simulator.time,
            distance=None if plan.goal is None else plan.distance_to_goal,
            area=plan.certified_area, contacts=contacts, state=plan.state.name, cause=plan.cause)
