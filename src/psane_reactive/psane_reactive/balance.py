# SPDX-License-Identifier: Apache-2.0
"""Lead a leaning robot straight out of soft ground, before it digs itself in or falls over."""

import math
from typing import NamedTuple

from psane_reactive.clearance import Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.law import Pose
from psane_reactive.limits import Velocity
from psane_reactive.safety_stop import SafetyStop


class Tilt(NamedTuple):
    """How the body leans: nose down and right side down are positive [rad]."""

    pitch: float = 0.0
    roll: float = 0.0

    @classmethod
    def of_quaternion(cls, x: float, y: float, z: float, w: float) -> 'Tilt':
        """Return the tilt of an attitude x y z w of the body in the map; yaw does not matter."""
        square = x * x + y * y + z * z + w * w
        if not 0.0 < square < math.inf:
            return cls(math.nan, math.nan)
        pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - x * z) / square)))
        roll = math.atan2(2.0 * (w * x + y * z), square - 2.0 * (x * x + y * y))
        return cls(pitch, roll)

    @property
    def lean(self) -> float:
        """Angle between the body's upward axis and the vertical, 0..pi [rad]."""
        return math.acos(max(-1.0, min(1.0, math.cos(self.pitch) * math.cos(self.roll))))


class Balance:
    """Replaces turns of a robot that leans by straight ways out, where those are safe.

    Notes
    -----
    A body leans when legs of one side or end stand in soft ground. Turning on the spot digs these
    in deeper, and walking backwards with a turn lets the other side climb over them until the
    robot falls on its back; walking straight brings all legs onto new ground.
    """

    def __init__(self, configuration: ReactiveConfiguration, safety: SafetyStop) -> None:
        self._configuration = configuration
        self._safety = safety
        self._tilt = Tilt()

    def take(self, tilt: Tilt) -> None:
        """Take how the body leans; numbers that are not finite count as upright."""
        self._tilt = tilt if math.isfinite(tilt.pitch + tilt.roll) else Tilt()

    def objection(self) -> str | None:
        """Say why a robot that has fallen over must not move its legs; None while it stands."""
        lean = self._tilt.lean
        if lean <= self._configuration.fallen_above:
            return None
        return (f'the robot has fallen over: it leans by {lean:.1f} rad; '
                'set it upright and it goes on')

    def way_out(self, border: Border, pose: Pose, measured: Velocity,
                wanted: Velocity) -> Velocity | None:
        """Return what a leaning robot does instead, None where nothing is to be changed."""
        settings = self._configuration
        is_turn = wanted.linear == 0.0 and wanted.angular != 0.0
        is_backward_arc = wanted.linear < 0.0 and wanted.angular != 0.0
        if self._tilt.lean <= settings.lean_limit or not (is_turn or is_backward_arc):
            return None
        away = -1.0 if is_backward_arc or self._tilt.pitch > 0.0 else 1.0
        for sense in (away,) if is_backward_arc else (away, -away):
            straight = Velocity(sense * settings.retreat_speed, 0.0)
            if self._safety.is_safe(border, pose, measured, straight):
                return straight
        return None
