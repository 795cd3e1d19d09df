# SPDX-License-Identifier: Apache-2.0
"""Drive in any direction without turning, for a robot that can."""

import math

import numpy as np

from psane_mapping.grid import FloatArray
from psane_reactive.clearance import Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.law import Pose
from psane_reactive.limits import STANDSTILL, Velocity
from psane_reactive.safety_stop import SafetyStop

# Halvings of the speed before the robot stands.
_HALVINGS = 4


class HolonomicLaw:
    """Straight at the target, slower near the goal and towards an edge; judged like the rest."""

    def __init__(self, configuration: ReactiveConfiguration, safety: SafetyStop) -> None:
        self._configuration = configuration
        self._safety = safety
        self._last = np.zeros(2)

    def reset(self) -> None:
        """Forget the last velocity."""
        self._last = np.zeros(2)

    def velocity(self, pose: Pose, target: FloatArray, left: float, border: Border,
                 step: float) -> tuple[FloatArray, bool]:
        """Return the velocity in the body frame, (2,) [m/s], and whether it was held back.

        Parameters
        ----------
        target : (2,) float, map frame [m]
        left : float
            Way left to the subgoal, at least [m].
        step : float
            Time since the last command [s].
        """
        settings = self._configuration
        away = target - pose.position
        heading = math.atan2(away[1], away[0])
        free = border.ray(pose, heading, settings.linear_limit * settings.edge_time)
        speed = max(min(settings.linear_limit, settings.approach_gain * left,
                        free / settings.edge_time), settings.slowest)
        wanted = speed * np.array((math.cos(heading), math.sin(heading)))
        change = wanted - self._last
        size = float(np.hypot(*change))
        largest = settings.linear_acceleration * step
        smooth = wanted if size <= largest else self._last + change * (largest / size)
        chosen, was_held = self._safe(pose, border, smooth)
        self._last = chosen
        cosine, sine = math.cos(pose.yaw), math.sin(pose.yaw)
        return np.array(((cosine, sine), (-sine, cosine))) @ chosen, was_held

    def _safe(self, pose: Pose, border: Border, wanted: FloatArray) -> tuple[FloatArray, bool]:
        """Return a velocity, map frame [m/s], of which the safety stop has nothing to say."""
        heading = math.atan2(wanted[1], wanted[0])
        # Until the command takes effect the robot goes on as before, or else obeys at once.
        coasted = pose.position + self._configuration.stop_delay * self._last
        if border.segment_distance(pose, coasted, 1e-6) == 0.0:
            return np.zeros(2), True
        starts = (Pose(pose.x, pose.y, heading), Pose(coasted[0], coasted[1], heading))
        for halving in range(_HALVINGS):
            share = 0.5 ** halving
            ahead = Velocity(share * float(np.hypot(*wanted)), 0.0)
            if all(self._safety.is_safe(border, start, STANDSTILL, ahead) for start in starts):
                return share * wanted, halving > 0
        return np.zeros(2), True
