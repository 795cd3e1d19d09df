# SPDX-License-Identifier: Apache-2.0
"""Lead a leaning robot straight out of soft ground, before it digs itself in or falls over."""

import math
from typing import NamedTuple

from psane_mapping.grid import FloatArray
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
    in deeper, and walking backward with a turn lets the other side climb over them until the
    robot falls on its back; walking straight brings all legs onto new ground. A body that leans
    even more is levered over by legs that turn backward, so it goes forward or turns. A straight
    way out ends after `lean_way`; if the robot leans there too, it turns all the same.
    """

    def __init__(self, configuration: ReactiveConfiguration, safety: SafetyStop) -> None:
        self._configuration = configuration
        self._safety = safety
        self._tilt = Tilt()
        self._sense = 0.0
        self._from: FloatArray | None = None
        self._spent_at: FloatArray | None = None

    def reset(self) -> None:
        """Forget where a way out began, after a jump of the pose."""
        self._from = self._spent_at = None

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
        settings, lean = self._configuration, self._tilt.lean
        if lean <= settings.lean_limit:
            self.reset()
            return None
        if wanted.linear < 0.0:
            return self._not_levered_over(border, pose, measured, wanted)
        if wanted.linear > 0.0 or wanted.angular == 0.0:
            return None
        return self._straight_before_turn(border, pose, measured)

    def _not_levered_over(self, border: Border, pose: Pose, measured: Velocity,
                          wanted: Velocity) -> Velocity | None:
        """Walk backward straight; leaning far, forward, and where that is barred turn or stand."""
        if self._tilt.lean <= self._configuration.backward_limit:
            straight = Velocity(-self._configuration.retreat_speed, 0.0)
            is_arc = wanted.angular != 0.0
            return straight if is_arc and self._safety.is_safe(
                border, pose, measured, straight) else None
        forward = Velocity(self._configuration.retreat_speed, 0.0)
        is_free = self._safety.is_safe(border, pose, measured, forward)
        return forward if is_free else Velocity(0.0, wanted.angular)

    def _straight_before_turn(self, border: Border, pose: Pose,
                              measured: Velocity) -> Velocity | None:
        """Leave straight, away from the low end if that is safe, then the other way."""
        settings, here = self._configuration, pose.position
        if self._spent_at is not None:
            if math.dist(here, self._spent_at) < settings.lean_way:
                return None
            self._spent_at = None
        if self._from is not None and math.dist(here, self._from) < settings.lean_way:
            senses = [self._sense]
        elif self._from is not None:
            senses = []
        else:
            away = -1.0 if self._tilt.pitch > 0.0 else 1.0
            senses = [away, -away]
        for sense in senses:
            straight = Velocity(sense * settings.retreat_speed, 0.0)
            is_levered = sense < 0.0 and self._tilt.lean > settings.backward_limit
            if not is_levered and self._safety.is_safe(border, pose, measured, straight):
                if self._from is None:
                    self._from, self._sense = here, sense
                return straight
        self._from, self._spent_at = None, here
        return None
