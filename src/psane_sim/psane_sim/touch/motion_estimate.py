# SPDX-License-Identifier: Apache-2.0
"""How body and legs moved over the last seconds, from everything that was measured of it.

Nothing is estimated while the robot moves: when a stance has ended, its whole record is smoothed
at once, with measurements from before and after each instant.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from psane_mapping.grid import FloatArray
from psane_sim.robot.gravity import GRAVITY
from psane_sim.touch.complementary import added_up, corrected, corrected_attitude
from psane_sim.touch.sensing import ImuSample, JointSample, OdometrySample, WrenchSample

VELOCITY_TIMEOUT = 0.1
"""Without odometry for longer than this [s], a body velocity is not trusted."""

ATTITUDE_WIDTH, VELOCITY_WIDTH, POSITION_WIDTH, ANGLE_WIDTH = 0.1, 0.15, 0.1, 0.03
"""Over how long the noisy measurement of each quantity is smoothed [s]: about as long as the quick
one that it corrects (gyroscope, accelerometer, velocity, joint velocity) drifts less."""


@dataclass(frozen=True)
class Instant:
    """What was measured at the same time."""

    joints: JointSample
    wrenches: WrenchSample
    imu: ImuSample

    @property
    def time(self) -> float:
        """Of the measurements [s]."""
        return self.imu.time


@dataclass(frozen=True)
class BodyMotion:
    """The body over some instants, as estimated; map frame.

    Parameters
    ----------
    time : (n,) float [s]
    position : (n, 3) float [m]
    rotation : (n, 3, 3) float
        Base to map.
    velocity, angular_velocity : (n, 3) float [m/s], [rad/s]
    acceleration : (n, 3) float [m/s^2]
    has_velocity : bool
        True when odometry was there all the time.
    """

    time: FloatArray
    position: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    angular_velocity: FloatArray
    acceleration: FloatArray
    has_velocity: bool


class MotionRecord:
    """Remembers measurements for some time.

    Parameters
    ----------
    span : float
        How long [s].
    """

    def __init__(self, span: float) -> None:
        self.span = span
        self._instants: deque[Instant] = deque()
        self._odometry: deque[OdometrySample] = deque()

    @property
    def newest(self) -> float | None:
        """Time of the newest instant [s]."""
        return self._instants[-1].time if self._instants else None

    def odometry_age(self, now: float) -> float:
        """Return how long ago the robot knew where it was [s]; infinite if it never did."""
        return abs(now - self._odometry[-1].time) if self._odometry else np.inf

    def set_odometry(self, sample: OdometrySample) -> None:
        """Take in a new sample; an older one than the last is ignored."""
        if not self._odometry or sample.time > self._odometry[-1].time:
            self._odometry.append(sample)
            while sample.time - self._odometry[0].time > self.span:
                self._odometry.popleft()

    def add(self, instant: Instant) -> None:
        """Take in the measurements of a later instant."""
        self._instants.append(instant)
        while instant.time - self._instants[0].time > self.span:
            self._instants.popleft()

    def forget(self) -> None:
        """Forget all instants, but not where the robot was."""
        self._instants.clear()

    def since(self, begin: float) -> list[Instant]:
        """Return the instants from a time on [s]."""
        return [instant for instant in self._instants if instant.time >= begin]

    def body(self, instants: list[Instant]) -> BodyMotion:
        """Return how the body moved over some instants."""
        time = np.array([instant.time for instant in instants])
        rate = np.array([instant.imu.angular_velocity for instant in instants])
        rotation = corrected_attitude(
            time, rate, np.array([instant.imu.quaternion for instant in instants]),
            ATTITUDE_WIDTH)
        force = np.array([instant.imu.specific_force for instant in instants])
        acceleration = _turned(rotation, force) - (0.0, 0.0, GRAVITY)
        samples = self._odometry_near(float(time[0]), float(time[-1]))
        known = np.array([sample.time for sample in samples])
        measured = _turned(_matrices([sample.quaternion for sample in samples]),
                           np.array([sample.velocity for sample in samples]))
        velocity = corrected(time, added_up(time, acceleration, is_mean=True), known, measured,
                             VELOCITY_WIDTH)
        position = corrected(time, added_up(time, velocity), known,
                             np.array([sample.position for sample in samples]), POSITION_WIDTH)
        nearest = np.abs(time[:, None] - known[None, :]).min(axis=1)
        return BodyMotion(time=time, position=position, rotation=rotation, velocity=velocity,
                          angular_velocity=_turned(rotation, rate), acceleration=acceleration,
                          has_velocity=bool(nearest.max() <= VELOCITY_TIMEOUT))

    def _odometry_near(self, begin: float, end: float) -> list[OdometrySample]:
        """Return the samples within a span, and at least the latest one."""
        found = [sample for sample in self._odometry if begin <= sample.time <= end]
        return found or [self._odometry[-1]]


def joint_angles(instants: list[Instant], leg: int) -> tuple[FloatArray, FloatArray]:
    """Return angle [rad] and velocity [rad/s] of a leg over some instants, each (n,)."""
    time = np.array([instant.time for instant in instants])
    speed = np.array([instant.joints.velocity[leg] for instant in instants])
    noisy = np.unwrap([instant.joints.position[leg] for instant in instants])
    angle = corrected(time, added_up(time, speed[:, None]), time, noisy[:, None], ANGLE_WIDTH)
    return angle[:, 0], speed


def _turned(rotation: FloatArray, vector: FloatArray) -> FloatArray:
    return np.asarray(np.einsum('nij,nj->ni', rotation, vector))


def _matrices(quaternions: list[FloatArray]) -> FloatArray:
    return np.asarray(Rotation.from_quat(quaternions).as_matrix())
