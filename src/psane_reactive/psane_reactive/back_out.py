# SPDX-License-Identifier: Apache-2.0
"""Back out before a large turn while the nose is over ground that is not certified."""

import math
from collections import deque

import numpy as np

from psane_mapping.grid import FloatArray
from psane_reactive.clearance import Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.law import Pose
from psane_reactive.limits import Velocity, clip, walkable, wrap
from psane_reactive.safety_stop import SafetyStop

_SPACING = 0.05
_TRAIL = 20
_AIM = 0.2


class BackOut:
    """Drives backwards along the robot's own trail before a turn that would drag the nose.

    Notes
    -----
    Turning with the nose in soft ground drags the body in: the rear grips, the front does not.
    """

    def __init__(self, configuration: ReactiveConfiguration, safety: SafetyStop) -> None:
        self._configuration = configuration
        self._safety = safety
        self._trail: deque[FloatArray] = deque(maxlen=_TRAIL)
        self._from: FloatArray | None = None
        self._is_spent = False
        self._is_demanded = False

    def reset(self) -> None:
        """Forget trail and state, after a jump of the pose."""
        self._trail.clear()
        self._from = None
        self._is_spent = False
        self._is_demanded = False

    def demand(self) -> None:
        """Ask for room before the next turn, however small: the robot was just outside."""
        self._is_demanded = True
        self._is_spent = False

    def remember(self, pose: Pose) -> None:
        """Note where the robot has been."""
        here = pose.position
        if not self._trail or math.dist(here, self._trail[-1]) >= _SPACING:
            self._trail.append(here)

    def velocity(self, border: Border, pose: Pose, measured: Velocity,
                 turn: float) -> Velocity | None:
        """Return the velocity backwards, or None when the turn may go on.

        Parameters
        ----------
        turn : float
            Heading change that is about to be made in place [rad].
        """
        settings = self._configuration
        least = settings.turn_until if self._is_demanded else settings.back_out_above
        if abs(turn) < 0.5 * least:
            self._from, self._is_spent = None, False
            return None
        if self._is_spent or (self._from is None and abs(turn) < least):
            return None
        if border.outside_distance(pose.ahead(settings.nose)) <= settings.nose_allowance:
            return self._finish()
        if self._from is None:
            self._from = pose.position
        if np.hypot(*(pose.position - self._from)) >= settings.back_out_length:
            return self._finish()
        back = self._backwards(pose)
        for wanted in (back, Velocity(back.linear, 0.0)):
            if self._safety.is_safe(border, pose, measured, wanted):
                return wanted
        return self._finish()

    def _finish(self) -> Velocity | None:
        """End the backing out until the turn is done."""
        self._from, self._is_spent, self._is_demanded = None, True, False
        return None

    def _backwards(self, pose: Pose) -> Velocity:
        """Return the velocity along the trail, tail first."""
        settings = self._configuration
        angular = 0.0
        for place in reversed(self._trail):
            error = wrap(pose.heading_error(place) + np.pi)
            if np.hypot(*(place - pose.position)) >= _AIM and abs(error) < 0.8:
                angular = clip(settings.heading_gain * error, 0.5 * settings.angular_limit)
                break
        return walkable(Velocity(-settings.retreat_speed, angular), settings)
