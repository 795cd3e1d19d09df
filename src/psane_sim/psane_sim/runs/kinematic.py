# SPDX-License-Identifier: Apache-2.0
"""A fast stand-in for the hexapod: a unicycle that slips, with legs that step where its own do.

Notes
-----
Each side drives like a track whose speed the ground under its three feet cuts down by their mean
slip, so that soft ground on one side turns the body into it. What comes out is calibrated on the
multibody simulation's mean behaviour and says nothing of strides, sinking or pitching.
"""

import math
from dataclasses import dataclass

import numpy as np

from psane_mapping.grid import FloatArray
from psane_mapping.parameters import Configuration, parameter
from psane_sim.terrains.terrain import Terrain

FEET = np.array([[0.19, 0.15], [-0.03, 0.18], [-0.22, 0.15],
                 [0.19, -0.15], [-0.03, -0.18], [-0.22, -0.15]])
"""Mean points of the stances of each leg, base frame, measured on the multibody simulation [m]."""

_CENTRE_AND_FEET = np.vstack((np.zeros(2), FEET))

TRIPODS = ((0, 2, 4), (1, 3, 5))
"""Legs that stand together."""

FIRM_SLIP = 0.081
"""Slip on firm ground, which the gait's feed-forward already makes up for [-]."""


@dataclass(frozen=True, kw_only=True)
class KinematicConfiguration(Configuration):
    """How the stand-in moves."""

    stride_frequency: float = parameter(0.75, 'turns of each leg', unit='1/s', low=0.1, high=3.0)
    speed_limit: float = parameter(
        0.3, 'largest speed that is obeyed', unit='m/s', low=0.0, high=5.0)
    turn_limit: float = parameter(
        0.4, 'largest yaw rate that is obeyed', unit='rad/s', low=0.0, high=5.0)
    response_time: float = parameter(
        0.2, 'time constant with which the body follows', unit='s', low=0.01, high=2.0)
    half_track: float = parameter(
        0.29, 'half the effective width between the sides', unit='m', low=0.05, high=2.0)
    turning_slip: float = parameter(
        0.16, 'slip that turning at the limit adds', low=0.0, high=1.0)
    sway: float = parameter(
        0.004, 'deviation of a step aside, for each stride', unit='m', low=0.0, high=0.1)
    stride_allowance: float = parameter(
        0.02, 'slip of its strides above that of the ground under the feet, for the planner',
        low=0.0, high=1.0)
    stride_deviation: float = parameter(
        0.05, 'noise of the slip of its strides, for the planner', low=0.005, high=2.0)


class KinematicRobot:
    """The body's pose, moved by commands and cut down by the ground.

    Parameters
    ----------
    configuration : KinematicConfiguration
    terrain : Terrain
    pose : (x, y, yaw), map frame [m, m, rad]
    seed : int or sequence of int
        Of the sway.
    """

    def __init__(self, configuration: KinematicConfiguration, terrain: Terrain,
                 pose: tuple[float, float, float], seed: int | tuple[int, ...]) -> None:
        self._configuration = configuration
        self._terrain = terrain
        self._generator = np.random.default_rng(seed)
        self._asked = (0.0, 0.0)
        self._moving = (0.0, 0.0)
        self._phase = 0.0
        self.pose: FloatArray = np.array(pose, dtype=np.float64)
        self.time = 0.0
        self.velocity = (0.0, 0.0)
        self.forward_slip = 0.0
        self._arrive()

    def command(self, linear: float, angular: float) -> None:
        """Take a speed [m/s] and a yaw rate [rad/s]; what exceeds the limits is cut."""
        limit = self._configuration
        self._asked = (min(max(linear, -limit.speed_limit), limit.speed_limit),
                       min(max(angular, -limit.turn_limit), limit.turn_limit))

    def places(self) -> FloatArray:
        """Return the centre and where the six feet press, (7, 2), map frame [m]."""
        return self._places

    def slip_under(self) -> FloatArray:
        """Return the true slip at those places, (7,) [-]."""
        return self._slip_under

    def _arrive(self) -> None:
        """Work out what is under the robot where it is now."""
        x, y, yaw = self.pose.tolist()
        cosine, sine = math.cos(yaw), math.sin(yaw)
        self._places = _CENTRE_AND_FEET @ np.array(((cosine, sine), (-sine, cosine)))
        self._places += (x, y)
        self._slip_under = self._terrain.true_slip(self._places)

    def step(self, duration: float) -> tuple[int, ...]:
        """Move on by `duration` [s]; return the legs whose stance ended meanwhile."""
        config = self._configuration
        share = 1.0 - math.exp(-duration / config.response_time)
        linear, angular = (now + share * (asked - now)
                           for now, asked in zip(self._moving, self._asked, strict=True))
        self._moving = (linear, angular)
        added = config.turning_slip * abs(angular) / max(config.turn_limit, 1e-9)
        # Turning costs nothing where the ground is firm, and all that is added where it is soft.
        slip = [min(1.0, own + added * min(1.0, 2.0 * own))
                for own in self._slip_under.tolist()[1:]]
        firm = 3.0 * (1.0 - FIRM_SLIP)
        left = (linear - angular * config.half_track) * (3.0 - sum(slip[:3])) / firm
        right = (linear + angular * config.half_track) * (3.0 - sum(slip[3:])) / firm
        self.forward_slip = sum(slip) / 6.0
        self.velocity = (0.5 * (left + right), 0.5 * (right - left) / config.half_track)
        self._move(duration)
        return self._stances_ended(duration)

    def _move(self, duration: float) -> None:
        speed, rate = self.velocity
        heading = self.pose[2] + 0.5 * rate * duration
        aside = self._configuration.sway * math.sqrt(duration) * self._generator.normal()
        aside *= min(1.0, abs(speed) / 0.05)
        self.pose[0] += speed * duration * math.cos(heading) - aside * math.sin(heading)
        self.pose[1] += speed * duration * math.sin(heading) + aside * math.cos(heading)
        self.pose[2] = math.remainder(self.pose[2] + rate * duration, 2.0 * math.pi)
        self.time += duration
        self._arrive()

    def _stances_ended(self, duration: float) -> tuple[int, ...]:
        """Let the legs cycle, at the stride frequency, as long as the body is to move."""
        if max(abs(self._moving[0]), 0.3 * abs(self._moving[1])) < 0.02:
            return ()
        before = math.floor(2.0 * self._phase)
        self._phase += self._configuration.stride_frequency * duration
        after = math.floor(2.0 * self._phase)
        return TRIPODS[after % 2] if after != before else ()
