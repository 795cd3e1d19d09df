# SPDX-License-Identifier: Apache-2.0
"""What the steering was last told, and whether it may still be steered by."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from psane_mapping.grid import FloatArray
from psane_reactive.clearance import Area
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.errors import RegionError
from psane_reactive.law import Pose
from psane_reactive.limits import STANDSTILL, Velocity
from psane_reactive.region import FARTHEST, clean_region

# Clocks of two processes may differ by this much before a message counts as from the future [s].
_CLOCK_TOLERANCE = 1.0


class Inputs:
    """Latest region, subgoal and odometry with their times of arrival [s]."""

    def __init__(self, configuration: ReactiveConfiguration) -> None:
        self.configuration = configuration
        self.region: Area | None = None
        self._heard: Any = None
        self.subgoal: FloatArray | None = None
        self.march_wanted = False
        self.subgoal_is_goal = False
        self.pose = Pose(math.nan, math.nan, math.nan)
        self.velocity = STANDSTILL
        self._flaws: dict[str, str] = {}
        self._stamps: dict[str, float] = {}

    def take_region(self, area: Any, now: float) -> bool:
        """Store a region or None; return whether it differs from the one before."""
        self._stamps['region'] = now
        if area is not None and area is self._heard:
            # Geometries do not change.
            return False
        before, self._heard = self.region, area
        self._flaws.pop('region', None)
        self.region = None
        if area is not None and not getattr(area, 'is_empty', False):
            try:
                self.region = clean_region(area)
            except RegionError as error:
                self._flaws['region'] = str(error)
        if before is None or self.region is None:
            return before is not self.region
        return not before.equals_exact(self.region, 0.0)

    def take_subgoal(self, point: Any, march: bool, is_goal: bool, now: float) -> None:
        """Store a subgoal (2,) [m], or None when there is none."""
        self._stamps['subgoal'] = now
        self._flaws.pop('subgoal', None)
        self.march_wanted, self.subgoal_is_goal = bool(march), bool(is_goal)
        self.subgoal = None if point is None else _point(point)
        if point is not None and self.subgoal is None:
            self._flaws['subgoal'] = (f'subgoal is {point!r}, expected two finite numbers '
                                      f'up to {FARTHEST:g} m')

    def take_odometry(self, pose: Sequence[float], velocity: Sequence[float], now: float) -> None:
        """Store pose (x, y, yaw), map frame, and velocity (linear, angular), body frame."""
        self._stamps['odometry'] = now
        self._flaws.pop('odometry', None)
        numbers = [float(number) for number in (*pose, *velocity)]
        if len(numbers) != 5 or not all(abs(number) <= FARTHEST for number in numbers):
            self._flaws['odometry'] = 'odometry holds a number that is not finite or far too large'
            return
        self.pose, self.velocity = Pose(*numbers[:3]), Velocity(*numbers[3:])

    def objection(self, now: float) -> str | None:
        """Say why nothing may be done now: what is missing, too old or not finite."""
        if not math.isfinite(now):
            return f'time is {now}, expected a finite number'
        settings = self.configuration
        limits = {'odometry': settings.odometry_age_limit, 'region': settings.region_age_limit,
                  'subgoal': settings.subgoal_age_limit}
        for name, limit in limits.items():
            if name not in self._stamps:
                return f'no {name} yet'
            if name in self._flaws:
                return self._flaws[name]
            age = now - self._stamps[name]
            if not -_CLOCK_TOLERANCE <= age <= limit:
                return f'{name} is {age:.1f} s old, at most {limit:g} s is steered by'
        return None


def _point(point: Any) -> FloatArray | None:
    """Return two usable coordinates as an array, None for anything else."""
    try:
        array = np.array(point, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return array if array.shape == (2,) and bool((np.abs(array) <= FARTHEST).all()) else None
