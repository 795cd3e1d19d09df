# SPDX-License-Identifier: Apache-2.0
"""The steering as a whole: region, subgoal and odometry in, one safe command out."""

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np
import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.back_out import BackOut
from psane_reactive.balance import Balance, Tilt
from psane_reactive.clearance import Border
from psane_reactive.command import Command, Mode
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.guide import Aim, Counts, Guide
from psane_reactive.holonomic import HolonomicLaw
from psane_reactive.inputs import Inputs
from psane_reactive.law import UnicycleLaw
from psane_reactive.limits import STANDSTILL, Velocity, limited, rate_limited
from psane_reactive.march import March
from psane_reactive.progress import Progress
from psane_reactive.retreat import Retreat
from psane_reactive.safety_stop import SafetyStop
from psane_reactive.steady_direction import SteadyDirection

# A pose that moves faster than this was set anew by a localiser, or is wrong [m/s].
_JUMP_SPEED = 5.0
_LONGEST_STEP = 0.2
UPRIGHT = Tilt()


class ReactiveController:
    """Steers a robot to its subgoal without leaving the region that it may use.

    Parameters
    ----------
    configuration : ReactiveConfiguration
    executor : Executor or None
        Where maps are built; None builds them within the command that first needs them, so that
        the same inputs give the same commands.

    Notes
    -----
    In this order: stop when an input is missing, stale or not finite, or the robot has fallen
    over; come back when outside; march where that is asked for or a subgoal was reached; else
    drive along the way that the map finds. A robot that leans walks straight instead of turning.
    The safety stop judges every command that moves the robot.
    """

    def __init__(self, configuration: ReactiveConfiguration | None = None,
                 executor: Executor | None = None) -> None:
        self._executor = executor
        self.counts = Counts()
        self.inputs = Inputs(configuration or ReactiveConfiguration())
        self._guide: Guide | None = None
        self.reconfigure(configuration or ReactiveConfiguration())
        self._last = STANDSTILL
        self._last_time: float | None = None
        self._odometry_time: float | None = None
        self.aim: Aim | None = None

    def reconfigure(self, configuration: ReactiveConfiguration) -> None:
        """Steer by other parameters from now on; what was heard last is kept."""
        self.configuration = self.inputs.configuration = configuration
        self._safety = SafetyStop(configuration)
        self._law = UnicycleLaw(configuration)
        self._direction = SteadyDirection(configuration)
        self._freely = HolonomicLaw(configuration, self._safety)
        self._march = March(configuration, self._safety)
        self._retreat = Retreat(configuration)
        self._back_out = BackOut(configuration, self._safety)
        self._balance = Balance(configuration, self._safety)
        self._progress = Progress(configuration)
        self._has_arrived = False
        self._guide = None
        self._enter_region()

    def _enter_region(self) -> None:
        """Begin to steer in the region that was heard last."""
        region, old = self.inputs.region, self._guide
        self._guide = None if region is None else Guide(
            region, self.configuration, self.counts, self._executor,
            None if old is None else old.map_within(region))

    def set_region(self, area: Any, now: float) -> None:
        """Take the region, a Polygon or MultiPolygon, map frame [m]; None when there is none.

        A region that cannot be used stops the robot; no later command is steered by an old one.
        """
        if self.inputs.take_region(area, now):
            self._enter_region()

    def set_subgoal(self, point: Any, march: bool, is_goal: bool, now: float) -> None:
        """Take where to go.

        Parameters
        ----------
        point : (2,) float, map frame [m], or None
            None where there is nowhere to go: the robot marches or stands.
        march : bool
            True when the robot is to feel the ground where it is.
        is_goal : bool
            True for the last subgoal, where the robot stands.
        """
        before = self.inputs.subgoal
        self.inputs.take_subgoal(point, march, is_goal, now)
        after = self.inputs.subgoal
        if before is None or after is None or not np.array_equal(before, after):
            self._has_arrived = False
            self._progress.reset()

    def set_odometry(self, pose: Sequence[float], velocity: Sequence[float], now: float,
                     tilt: Tilt = UPRIGHT) -> None:
        """Take pose (x, y, yaw), map frame [m, m, rad], and velocity (v, w), body [m/s, rad/s].

        `tilt` is how the body leans; it stands upright for who does not know.
        """
        self._balance.take(tilt)
        before = self.inputs.pose
        self.inputs.take_odometry(pose, velocity, now)
        after = self.inputs.pose
        step = 0.0 if self._odometry_time is None else max(now - self._odometry_time, 0.0)
        moved = float(np.hypot(after.x - before.x, after.y - before.y))
        if moved > 0.1 + _JUMP_SPEED * step:
            self._back_out.reset()
            self._balance.reset()
            self._law.reset()
            self._direction.reset()
            self._freely.reset()
            self._march.reset()
        self._odometry_time = now
        self._back_out.remember(after)

    def command(self, now: float) -> Command:
        """Return the command for the moment `now` [s]."""
        command = self._decide(now)
        self._last = Velocity(command.linear, command.angular)
        self._last_time = now if np.isfinite(now) else None
        if command.mode is not Mode.MARCH:
            self._march.reset()
        if command.mode is not Mode.DRIVE:
            self._freely.reset()
        return command

    def _decide(self, now: float) -> Command:
        """Go through the reasons for a command, the most urgent first."""
        objection = self.inputs.objection(now)
        if objection is not None:
            return _stopped(objection)
        fallen = self._balance.objection()
        if fallen is not None:
            return _stopped(fallen)
        if self._guide is None:
            return self._without_region(now)
        pose, border = self.inputs.pose, self._guide.border
        outside = border.outside_distance(pose)
        if self._retreat.is_needed(outside):
            wanted = self._retreat.velocity(border, pose)
            self._back_out.demand()
            reason = f'led back, {max(outside, 0.0):.2f} m outside the region'
            return self._judged(border, wanted, Mode.RETREAT, reason, now)
        if self.inputs.march_wanted:
            return self._shuffle(border, 'the planner asks to feel the ground here', now)
        if self.inputs.subgoal is None:
            return _stopped('there is no subgoal')
        return self._go(self._guide, self.inputs.subgoal, now)

    def _without_region(self, now: float) -> Command:
        """March where that is asked for, so that a first region can be certified; else stop."""
        if self.inputs.march_wanted:
            return self._shuffle(None, 'no region is certified yet', now)
        return _stopped('the region is empty')

    def _go(self, guide: Guide, subgoal: FloatArray, now: float) -> Command:
        """Drive to the subgoal; stand or march there."""
        pose = self.inputs.pose
        goal = guide.goal_inside(subgoal, pose.position)
        tolerance = self.configuration.arrival_tolerance
        distance = math.dist(goal, pose.position)
        self._has_arrived = distance <= tolerance * (2.0 if self._has_arrived else 1.0)
        if self._has_arrived:
            self._law.reset()
            missed = math.dist(goal, subgoal)
            if missed > tolerance:
                return self._shuffle(guide.border, f'the subgoal is {missed:.2f} m outside the '
                                     'part of the region that holds the robot', now)
            if self.inputs.subgoal_is_goal:
                return Command(0.0, 0.0, Mode.ARRIVED, 'the goal is reached')
            return self._shuffle(guide.border, 'the subgoal is reached', now)
        stalls = self._progress.watch(pose, now)
        self.aim = aim = guide.aim(pose.position, goal, stalls > 0)
        if aim is None:
            return _stopped('the map of the new region is being built' if guide.is_building
                            else 'no way leads through the region to the subgoal')
        if self.configuration.holonomic:
            return self._go_freely(guide.border, aim, now)
        return self._steered(guide.border, aim, stalls, now)

    def _steered(self, border: Border, aim: Aim, stalls: int, now: float) -> Command:
        """Drive at what is aimed at like a unicycle."""
        pose = self.inputs.pose
        target = self._direction.toward(pose, aim.target, now)
        wanted = self._law.velocity(pose, target, aim.left, border,
                                    may_reverse=self.inputs.subgoal_is_goal)
        turn = 0.0 if self._law.is_reversing else pose.heading_error(target)
        if self._law.is_turning or turn == 0.0:
            back = self._back_out.velocity(border, pose, self.inputs.velocity, turn)
            if back is not None:
                return self._judged(border, back, Mode.BACK_OUT,
                                    'backs out before a turn, the nose is outside', now)
        if stalls > (0 if self.configuration.steering_map == 'field' else 1):
            lost = stalls * self.configuration.stall_time
            return self._judged(border, wanted, Mode.STUCK, f'{aim.found_by}, yet the robot has '
                                f'been getting nowhere for {lost:g} s', now)
        mode = (Mode.TURN if self._law.is_turning
                else Mode.REVERSE if self._law.is_reversing else Mode.DRIVE)
        return self._judged(border, wanted, mode, aim.found_by, now)

    def _go_freely(self, border: Border, aim: Aim, now: float) -> Command:
        """Drive at what is aimed at without turning."""
        velocity, was_held = self._freely.velocity(
            self.inputs.pose, aim.target, aim.left, border, self._step(now))
        reason = f'{aim.found_by}; held by the safety stop' if was_held else aim.found_by
        return Command(float(velocity[0]), 0.0, Mode.DRIVE, reason, float(velocity[1]))

    def _shuffle(self, border: Border | None, reason: str, now: float) -> Command:
        """March in place."""
        self._progress.reset()
        velocity = limited(self._march.velocity(border, self.inputs.pose, self.inputs.velocity,
                                                now), self.configuration)
        return Command(velocity.linear, velocity.angular, Mode.MARCH, reason)

    def _judged(self, border: Border, wanted: Velocity, mode: Mode, reason: str,
                now: float) -> Command:
        """Return a wanted velocity within its rates and as far as the safety stop lets it."""
        out = self._balance.way_out(border, self.inputs.pose, self.inputs.velocity, wanted)
        if out is not None:
            how = 'it walks straight out' if out.linear != 0.0 else 'it does not walk backward'
            wanted, reason = out, f'{reason}; the body leans, so {how}'
        wanted = limited(wanted, self.configuration)
        smooth = rate_limited(wanted, self._last, self._step(now), self.configuration)
        verdict = self._safety.judge(border, self.inputs.pose, self.inputs.velocity, smooth)
        if verdict.was_stopped:
            reason = f'{reason}; the safety stop holds it'
        elif verdict.was_slowed:
            reason = f'{reason}; slowed by the safety stop'
        return Command(*verdict.velocity, mode, reason)

    def _step(self, now: float) -> float:
        """Return the time since the last command, as far as it counts [s]."""
        step = _LONGEST_STEP if self._last_time is None else now - self._last_time
        return min(max(step, 0.0), _LONGEST_STEP)

    def warm_up(self) -> None:
        """Run every compiled function once, so that no later command waits for the compiler."""
        trial = ReactiveController(self.configuration)
        trial.set_region(shapely.box(0, 0, 3, 3) - shapely.box(0.5, 0.5, 2.5, 2.5), 0.0)
        trial.set_subgoal((2.75, 2.75), False, False, 0.0)
        trial.set_odometry((0.25, 0.25, 0.0), (0.0, 0.0), 0.0)
        trial.command(0.0)
        trial.command(0.05)


def _stopped(reason: str) -> Command:
    return Command(0.0, 0.0, Mode.STOPPED, reason)
