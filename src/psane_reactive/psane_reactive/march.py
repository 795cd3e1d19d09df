# SPDX-License-Identifier: Apache-2.0
"""March in place: a robot that stands feels nothing, so it shuffles where it is."""

from psane_reactive.clearance import Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.law import Pose
from psane_reactive.limits import Velocity
from psane_reactive.safety_stop import SafetyStop

_TURN = 0.1


class March:
    """Drives gently forward and back around the place where it began."""

    def __init__(self, configuration: ReactiveConfiguration, safety: SafetyStop) -> None:
        self._configuration = configuration
        self._safety = safety
        self._anchor: Pose | None = None
        self._began = 0.0
        self._direction = 1.0

    def reset(self) -> None:
        """Begin anew at the next call."""
        self._anchor = None

    def velocity(self, border: Border | None, pose: Pose, measured: Velocity,
                 now: float) -> Velocity:
        """Return the shuffle's velocity, never zero.

        Parameters
        ----------
        border : Border or None
            Edge of the region; None while nothing is certified yet, then only the distance from
            where the shuffle began limits it.
        """
        settings = self._configuration
        away = 0.0 if self._anchor is None else float(
            (pose.position - self._anchor.position) @ (pose.ahead(1.0) - pose.position))
        if self._anchor is None or abs(away) > 3.0 * settings.march_reach:
            self._anchor, self._began, away = pose, now, 0.0
        phase = int((now - self._began) / settings.march_period)
        direction = 1.0 if phase % 2 == 0 else -1.0
        if abs(away) > settings.march_reach:
            direction = -1.0 if away > 0.0 else 1.0
        for sign in (direction, -direction):
            for share in (1.0, 0.4):
                wanted = Velocity(sign * share * settings.march_speed, 0.0)
                if border is None or self._safety.is_safe(border, pose, measured, wanted):
                    return wanted
        return Velocity(0.0, _TURN * direction)
