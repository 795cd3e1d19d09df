# SPDX-License-Identifier: Apache-2.0
"""How the body moves between two odometry messages."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from psane_mapping.grid import FloatArray
from psane_sim.sensing import ImuSample, OdometrySample

VELOCITY_TIMEOUT = 0.1
"""A body velocity older than this [s] is not trusted for the response of the ground."""

HEIGHT_GAIN = 0.3
"""Share of a new height that is taken over at once; the rest follows the vertical speed."""


@dataclass(frozen=True)
class BodyMotion:
    """The body at one instant, as estimated.

    Parameters
    ----------
    time : float [s]
    position : (3,) float, map frame [m]
    rotation : (3, 3) float
        Base to map.
    velocity, angular_velocity : (3,) float, map frame [m/s], [rad/s]
    has_velocity : bool
        True when the velocity is recent enough to be trusted.
    """

    time: float
    position: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    angular_velocity: FloatArray
    has_velocity: bool


class MotionEstimate:
    """Carries odometry on to the instant of a measurement, attitude from the inertial unit.

    Parameters
    ----------
    timeout : float
        Age at which odometry is of no use [s].
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._odometry: OdometrySample | None = None
        self._height = 0.0
        self._climb = 0.0

    def set_odometry(self, sample: OdometrySample) -> None:
        """Take in a new sample; an older one than the last is ignored."""
        height = float(sample.position[2])
        if self._odometry is not None:
            step = sample.time - self._odometry.time
            if step <= 0.0:
                return
            if step <= self._timeout:
                predicted = self._height + self._climb * step
                height = predicted + HEIGHT_GAIN * (height - predicted)
        self._height = height
        self._climb = float((_rotation(sample.quaternion) @ sample.velocity)[2])
        self._odometry = sample

    def at(self, imu: ImuSample) -> BodyMotion | None:
        """Return the body's motion at the time of an inertial sample; None without odometry."""
        odometry, now = self._odometry, imu.time
        if odometry is None or abs(now - odometry.time) > self._timeout:
            return None
        rotation = _rotation(imu.quaternion)
        velocity = rotation @ odometry.velocity
        age = now - odometry.time
        position = odometry.position + velocity * age
        position[2] = self._height + self._climb * age
        return BodyMotion(time=now, position=position, rotation=rotation, velocity=velocity,
                          angular_velocity=rotation @ imu.angular_velocity,
                          has_velocity=abs(age) <= VELOCITY_TIMEOUT)


def _rotation(quaternion: FloatArray) -> FloatArray:
    return np.asarray(Rotation.from_quat(quaternion).as_matrix())
