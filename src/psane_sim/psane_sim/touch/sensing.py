# SPDX-License-Identifier: Apache-2.0
"""What the robot's sensors publish: the truth with noise and constant errors.

Joints, hip wrenches and the inertial unit are read at 200 Hz, odometry at 50 Hz.
"""

import math
from dataclasses import dataclass

import numpy as np

from psane_mapping.grid import FloatArray
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.truth import Truth

TOUCH_RATE = 200.0
"""Rate of joints, wrenches and the inertial unit [1/s]."""

ODOMETRY_RATE = 50.0
"""Rate of odometry [1/s]."""


@dataclass(frozen=True)
class JointSample:
    """Six hip joints, in the order of `LEG_NAMES`.

    Parameters
    ----------
    time : float [s]
    position : (6,) float [rad]
        0 when the leg points straight down; it grows as the foot goes to the rear.
    velocity : (6,) float [rad/s]
    effort : (6,) float [N m]
        Torque of the motor on the leg.
    """

    time: float
    position: FloatArray
    velocity: FloatArray
    effort: FloatArray


@dataclass(frozen=True)
class WrenchSample:
    """What each leg does to the body at its hip, base frame.

    Parameters
    ----------
    time : float [s]
    force : (6, 3) float [N]
        A leg that carries the body has a positive third component.
    moment : (6, 3) float [N m]
        The second component is the reaction of the motor's torque.
    """

    time: float
    force: FloatArray
    moment: FloatArray


@dataclass(frozen=True)
class ImuSample:
    """Inertial unit at the base's origin.

    Parameters
    ----------
    time : float [s]
    quaternion : (4,) float [-]
        Attitude of the base in the map, x y z w.
    angular_velocity : (3,) float [rad/s]
        Base frame.
    specific_force : (3,) float [m/s^2]
        Base frame; (0, 0, 9.81) at rest on level ground.
    """

    time: float
    quaternion: FloatArray
    angular_velocity: FloatArray
    specific_force: FloatArray


@dataclass(frozen=True)
class OdometrySample:
    """Pose and twist of the base.

    Parameters
    ----------
    time : float [s]
    position : (3,) float [m]
        Map frame.
    quaternion : (4,) float [-]
        Attitude of the base in the map, x y z w.
    velocity, angular_velocity : (3,) float [m/s], [rad/s]
        Base frame, as `nav_msgs/Odometry` has its twist.
    """

    time: float
    position: FloatArray
    quaternion: FloatArray
    velocity: FloatArray
    angular_velocity: FloatArray

    @property
    def yaw(self) -> float:
        """Heading of the base in the map [rad]."""
        x, y, z, w = self.quaternion
        return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


class Sensors:
    """Makes samples from the simulator's truth; each sensor has its own stream of noise.

    Parameters
    ----------
    config : SimulatorConfiguration
        `noise_scale` multiplies everything; at 0 the samples are exact.
    seed : int
    """

    def __init__(self, config: SimulatorConfiguration, seed: int) -> None:
        self._config = config
        streams = [np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(5)]
        constant, self._joint, self._wrench, self._imu, self._odometry = streams
        scale = config.noise_scale
        self._attitude_bias = scale * config.attitude_bias * constant.standard_normal(2)
        self._height_bias = scale * config.height_bias * float(constant.standard_normal())

    def joints(self, truth: Truth) -> JointSample:
        """Read the hip joints."""
        config, noise = self._config, self._joint
        return JointSample(
            truth.time, self._white(noise, truth.joint_angle, config.joint_angle_noise),
            self._white(noise, truth.joint_speed, config.joint_velocity_noise),
            self._white(noise, truth.joint_torque, config.torque_noise,
                        config.torque_noise_share))

    def wrenches(self, truth: Truth) -> WrenchSample:
        """Read the force and moment sensors of the hips."""
        config, noise = self._config, self._wrench
        return WrenchSample(
            truth.time,
            self._white(noise, truth.hip_force, config.force_noise, config.force_noise_share),
            self._white(noise, truth.hip_moment, config.torque_noise, config.torque_noise_share))

    def imu(self, truth: Truth) -> ImuSample:
        """Read the inertial unit."""
        config, noise = self._config, self._imu
        angular = truth.angular_velocity @ truth.rotation
        return ImuSample(
            truth.time, self._attitude(noise, truth),
            self._white(noise, angular, config.angular_velocity_noise),
            self._white(noise, truth.specific_force, config.acceleration_noise))

    def odometry(self, truth: Truth) -> OdometrySample:
        """Read the odometry."""
        config, noise = self._config, self._odometry
        level = self._white(noise, truth.position[:2], config.position_noise)
        height = self._white(noise, truth.position[2:] + self._height_bias, config.height_noise)
        angular = truth.angular_velocity @ truth.rotation
        return OdometrySample(
            truth.time, np.concatenate((level, height)), self._attitude(noise, truth),
            self._white(noise, truth.velocity @ truth.rotation, config.velocity_noise,
                        config.velocity_noise_share),
            self._white(noise, angular, config.angular_velocity_noise))

    def _white(self, noise: np.random.Generator, value: FloatArray, deviation: float,
               share: float = 0.0) -> FloatArray:
        """Add noise whose deviation is a constant plus a share of the value."""
        scale = self._config.noise_scale * (deviation + share * np.abs(value))
        return np.asarray(value + scale * noise.standard_normal(np.shape(value)))

    def _attitude(self, noise: np.random.Generator, truth: Truth) -> FloatArray:
        """Turn the true attitude by a small random angle, and by the constant error of tilt."""
        error = (self._config.noise_scale * self._config.attitude_noise
                 * noise.standard_normal(3))
        error[:2] += self._attitude_bias
        turned = _product(truth.quaternion, np.array([*(0.5 * error), 1.0]))
        return turned / float(np.linalg.norm(turned))


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the product of two quaternions x y z w."""
    (ax, ay, az, aw), (bx, by, bz, bw) = a, b
    return np.array([aw * bx + ax * bw + ay * bz - az * by,
                     aw * by - ax * bz + ay * bw + az * bx,
                     aw * bz + ax * by - ay * bx + az * bw,
                     aw * bw - ax * bx - ay * by - az * bz])
