# SPDX-License-Identifier: Apache-2.0
"""Unicycle law: from a point to drive at to forward speed and yaw rate."""

import math
from typing import NamedTuple

import numpy as np

from psane_mapping.grid import FloatArray
from psane_reactive.clearance import Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.limits import Velocity, clip, walkable, wrap


class Pose(NamedTuple):
    """Planar pose in the map frame: position [m] and yaw [rad]."""

    x: float
    y: float
    yaw: float

    @property
    def position(self) -> FloatArray:
        """Position, (2,) [m]."""
        return np.array((self.x, self.y))

    def ahead(self, distance: float) -> FloatArray:
        """Return the point `distance` metres ahead, (2,) [m]."""
        return np.array((self.x + distance * math.cos(self.yaw),
                         self.y + distance * math.sin(self.yaw)))

    def heading_error(self, point: FloatArray) -> float:
        """Return the turn that would face a point (2,) [m], (-pi, pi] [rad]."""
        return wrap(math.atan2(float(point[1]) - self.y, float(point[0]) - self.x) - self.yaw)


class UnicycleLaw:
    """Turns first when it looks far aside, else drives and turns; backwards to what is behind."""

    def __init__(self, configuration: ReactiveConfiguration) -> None:
        self._configuration = configuration
        self.is_turning = False
        self.is_reversing = False

    def reset(self) -> None:
        """Forget what was being done."""
        self.is_turning = False
        self.is_reversing = False

    def velocity(self, pose: Pose, target: FloatArray, left: float, border: Border,
                 may_reverse: bool) -> Velocity:
        """Return the velocity towards a target.

        Parameters
        ----------
        target : (2,) float, map frame [m]
            Point that can be driven at straight.
        left : float
            Way left to the subgoal, at least [m].
        may_reverse : bool
            Whether a near target behind may be driven at backwards, which is blind: the front
            feet feel what is ahead.
        """
        settings = self._configuration
        error = pose.heading_error(target)
        self._choose_direction(error, left if may_reverse else math.inf)
        if self.is_reversing:
            error = wrap(error + math.pi)
        heading = pose.yaw + (math.pi if self.is_reversing else 0.0)
        free = border.ray(pose, heading, settings.linear_limit * settings.edge_time + 1.0)
        self._choose_turn(error, free)
        angular = clip(settings.heading_gain * error, settings.angular_limit)
        if self.is_turning:
            return Velocity(0.0, angular)
        speed = self._speed(error, left, free)
        return walkable(Velocity(-speed if self.is_reversing else speed, angular), settings)

    def _choose_turn(self, error: float, free: float) -> None:
        """Turn in place to what is far aside, or where an arc has no room ahead."""
        settings = self._configuration
        size = abs(error)
        if size < settings.turn_until:
            self.is_turning = False
        elif size > settings.turn_first_above:
            self.is_turning = True
        else:
            room = settings.arc_room * settings.arc_radius * size
            self.is_turning |= not self.is_reversing and room > free

    def _choose_direction(self, error: float, left: float) -> None:
        """Reverse towards a near target behind, until it is clearly ahead."""
        settings = self._configuration
        if left > settings.reverse_reach * (1.5 if self.is_reversing else 1.0):
            self.is_reversing = False
        elif abs(error) > settings.reverse_above:
            self.is_reversing = True
        elif abs(error) < math.pi - settings.reverse_above:
            self.is_reversing = False

    def _speed(self, error: float, left: float, free: float) -> float:
        """Return the speed: less when looking aside, near the subgoal and towards an edge."""
        settings = self._configuration
        aside = max(0.0, 1.0 - (error / settings.turn_first_above) ** 2)
        speed = min(settings.linear_limit * aside, settings.approach_gain * left,
                    free / settings.edge_time)
        return max(speed, settings.slowest)
