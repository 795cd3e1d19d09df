# SPDX-License-Identifier: Apache-2.0
"""What the steering hands out: a velocity, what it is for, and why."""

from dataclasses import dataclass
from enum import Enum


class Mode(Enum):
    """What a command is for."""

    STOPPED = 'stopped'
    ARRIVED = 'arrived'
    DRIVE = 'drive'
    REVERSE = 'reverse'
    TURN = 'turn'
    BACK_OUT = 'back_out'
    MARCH = 'march'
    RETREAT = 'retreat'
    STUCK = 'stuck'


@dataclass(frozen=True)
class Command:
    """Velocity in the body frame.

    Parameters
    ----------
    linear : float
        Forward speed [m/s].
    angular : float
        Yaw rate, counter-clockwise [rad/s].
    mode : Mode
        What the command is for.
    reason : str
        In words: why the robot stops, marches or is led back, and what steers it otherwise.
    lateral : float
        Speed to the left, of a holonomic robot only [m/s].
    """

    linear: float
    angular: float
    mode: Mode
    reason: str
    lateral: float = 0.0
