# SPDX-License-Identifier: Apache-2.0
"""The ground under the robot: what its legs and belly are pushed with.

A soil is asked once per tick with the state of the robot and answers with one wrench for each leg
and one for the body.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from psane_mapping.grid import FloatArray

BODY = 6
"""Row of the body in the arrays of seven (rows 0 to 5: legs)."""


@dataclass(frozen=True)
class RobotState:
    """What the soil needs to know; a simulator fills the same arrays anew each tick.

    Parameters
    ----------
    position : (3,) float
        Origin of the base frame, map frame [m].
    rotation : (3, 3) float
        Base to map.
    velocity, angular_velocity : (3,) float
        Of the base, map frame [m/s], [rad/s].
    angle, speed : (6,) float
        Hip joints [rad], [rad/s].
    """

    position: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    angular_velocity: FloatArray
    angle: FloatArray
    speed: FloatArray

    @classmethod
    def zeros(cls) -> 'RobotState':
        """Return a state at the origin, at rest."""
        return cls(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3), np.zeros(6), np.zeros(6))


@dataclass(frozen=True)
class GroundLoad:
    """What the ground does to the robot; the arrays are reused from tick to tick.

    Parameters
    ----------
    force : (7, 3) float
        On each leg and (last row) on the body, map frame [N].
    moment : (7, 3) float
        About the leg's hip, and about the base's origin for the body, map frame [N m].
    depth : (7,) float
        Deepest element of each leg and of the belly [m]; negative above the ground.
    foot : (7, 3) float
        That element's place, map frame [m].
    place : (7, 3) float
        Where the force and moment act: each leg's hip and the base's origin, map frame [m].
    """

    force: FloatArray
    moment: FloatArray
    depth: FloatArray
    foot: FloatArray
    place: FloatArray

    @classmethod
    def zeros(cls) -> 'GroundLoad':
        """Return no load."""
        return cls(np.zeros((7, 3)), np.zeros((7, 3)), np.zeros(7), np.zeros((7, 3)),
                   np.zeros((7, 3)))


class Soil(Protocol):
    """State and velocity of the robot's surfaces in, forces out."""

    def load(self, state: RobotState, dt: float) -> GroundLoad:
        """Return the ground's forces and move the soil's own state on by `dt` [s]."""
        ...

    def reset(self) -> None:
        """Forget every displacement."""
        ...
