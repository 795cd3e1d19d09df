# SPDX-License-Identifier: Apache-2.0
"""The last word over every command: no predicted motion leaves the region."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray
from psane_reactive.border_index import Segments
from psane_reactive.clearance import Border, outside_distance, segment_distance
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.law import Pose
from psane_reactive.limits import STANDSTILL, Velocity, limited

_SHARES = (1.0, 0.6, 0.3, 0.12)
_SAMPLES = 8
_TOLERANCE = 1e-9


class Verdict(NamedTuple):
    """A command that is safe, and whether and how it was changed."""

    velocity: Velocity
    was_slowed: bool
    was_stopped: bool


@njit(cache=True)  # type: ignore[misc]
def advance(x: float, y: float, yaw: float, linear: float, angular: float, time: float,
             ) -> tuple[float, float, float]:
    """Return the pose after driving a circular arc."""
    turn = angular * time
    if abs(turn) < 1e-9:
        return x + linear * time * math.cos(yaw), y + linear * time * math.sin(yaw), yaw + turn
    radius = linear / angular
    return (x + radius * (math.sin(yaw + turn) - math.sin(yaw)),
            y - radius * (math.cos(yaw + turn) - math.cos(yaw)), yaw + turn)


@njit(cache=True)  # type: ignore[misc]
def _arc_is_safe(segments: Segments, x: float, y: float, yaw: float, linear: float,
                 angular: float, horizon: float, allowed: float) -> bool:
    """Tell whether an arc stays inside, or only approaches the region when it begins outside."""
    begin = outside_distance(segments, x, y)
    if begin < allowed - abs(linear) * horizon:
        return True
    limit = max(allowed, begin) + _TOLERANCE
    last_x, last_y, last = x, y, begin
    for k in range(1, _SAMPLES + 1):
        px, py, _ = advance(x, y, yaw, linear, angular, horizon * k / _SAMPLES)
        last = outside_distance(segments, px, py)
        if last > limit:
            return False
        if begin <= 0.0 and segment_distance(segments, last_x, last_y, px, py, 1e-6) == 0.0:
            return False
        last_x, last_y = px, py
    return begin <= allowed or last < begin


@njit(cache=True)  # type: ignore[misc]
def _is_safe(segments: Segments, start: FloatArray, measured: FloatArray, linear: float,
             angular: float, delay: float, horizon: float, slip: float, margin: float) -> bool:
    """Tell whether a command is safe with all of its speed or yaw rate, or a share lost."""
    allowed = max(-margin, outside_distance(segments, start[0], start[1]))
    x, y, yaw = advance(start[0], start[1], start[2], measured[0], measured[1], delay)
    kept = 1.0 - slip
    return (_arc_is_safe(segments, x, y, yaw, linear, angular, horizon, allowed)
            and _arc_is_safe(segments, x, y, yaw, linear, kept * angular, horizon, allowed)
            and _arc_is_safe(segments, x, y, yaw, kept * linear, angular, horizon, allowed))


class SafetyStop:
    """Slows a command, then keeps only its turn, until the predicted motion stays inside."""

    def __init__(self, configuration: ReactiveConfiguration) -> None:
        self._configuration = configuration

    def is_safe(self, border: Border, pose: Pose, measured: Velocity, wanted: Velocity) -> bool:
        """Tell whether the motion over delay and horizon stays inside the region.

        Notes
        -----
        A robot that is outside already may only come nearer to the region, or turn.
        """
        if wanted.linear == 0.0:
            return True
        settings = self._configuration
        moving = limited(measured, settings)
        return bool(_is_safe(border.segments, np.array(pose), np.array(moving), wanted.linear,
                             wanted.angular, settings.stop_delay, settings.stop_horizon,
                             settings.slip_share, settings.stop_margin))

    def judge(self, border: Border, pose: Pose, measured: Velocity, wanted: Velocity) -> Verdict:
        """Return the wanted command, a slower one, its turn alone, or standstill."""
        wanted = limited(wanted, self._configuration)
        for share in _SHARES:
            # A slower command keeps its yaw rate, so that it turns more tightly.
            slower = Velocity(share * wanted.linear, wanted.angular)
            if self.is_safe(border, pose, measured, slower):
                return Verdict(slower, was_slowed=share < 1.0, was_stopped=False)
        turn = Velocity(0.0, wanted.angular)
        return Verdict(turn if wanted.angular != 0.0 else STANDSTILL, was_slowed=True,
                       was_stopped=True)
