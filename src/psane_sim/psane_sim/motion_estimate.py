# SPDX-License-Identifier: Apache-2.0
"""How the body moves between two odometry messages."""

import numpy as np
from psane_mapping.grid import FloatArray
from scipy.spatial.transform import Rotation

from psane_sim.sensing import ImuSample, JointSample, OdometrySample
from psane_sim.soil import RobotState

VELOCITY_TIMEOUT = 0.1
"""A body velocity older than this [s] is not trusted for the response of the ground."""

HEIGHT_GAIN = 0.3
"""Share of a new height that is taken over at once; the rest follows the vertical speed."""


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
        self._height: float | None = None
        self._height_time = 0.0
        self._state = RobotState.zeros()

    def set_odometry(self, sample: OdometrySample) -> None:
        """Take in a new sample; an older one than the last is ignored."""
        if self._odometry is not None and sample.time <= self._odometry.time:
            return
        height = float(sample.position[2])
        if self._height is not None and self._odometry is not None:
            predicted = self._carried_height(sample.time)
            height = predicted + HEIGHT_GAIN * (height - predicted)
        self._height, self._height_time = height, sample.time
        self._odometry = sample

    def has_velocity(self, now: float) -> bool:
        """Tell whether the body's velocity is recent enough."""
        return self._odometry is not None and abs(now - self._odometry.time) <= VELOCITY_TIMEOUT

    def _carried_height(self, now: float) -> float:
        if self._odometry is None or self._height is None:
            return 0.0
        vertical = float((_rotation(self._odometry.quaternion) @ self._odometry.velocity)[2])
        return self._height + vertical * (now - self._height_time)

    def state(self, joints: JointSample, imu: ImuSample, now: float) -> RobotState | None:
        """Return the robot's state at `now` [s]; None without recent odometry.

        The arrays of the state are reused by the next call.
        """
        odometry = self._odometry
        if odometry is None or abs(now - odometry.time) > self._timeout:
            return None
        rotation = _rotation(imu.quaternion)
        state = self._state
        state.rotation[:] = rotation
        state.velocity[:] = rotation @ odometry.velocity
        state.angular_velocity[:] = rotation @ imu.angular_velocity
        state.position[:] = odometry.position + state.velocity * (now - odometry.time)
        state.position[2] = self._carried_height(now)
        state.angle[:] = joints.position
        state.speed[:] = joints.velocity
        return state


def _rotation(quaternion: FloatArray) -> FloatArray:
    return np.asarray(Rotation.from_quat(quaternion).as_matrix())
