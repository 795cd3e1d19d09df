# SPDX-License-Identifier: Apache-2.0
"""What a leg felt over a stance, beside what ground of strength 1 would have made it feel."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_mapping.leg_response import LegMotion, LegResponse, leg_response
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.height_bias import HeightOffset, offset_of
from psane_sim.touch.motion_estimate import BodyMotion, Instant, joint_angles

BoolArray = NDArray[np.bool_]

_OFFSET_STEP = 0.002

FORWARD, VERTICAL, MOMENT = 0, 1, 2
"""Columns of the channels."""


@dataclass(frozen=True)
class StanceReading:
    """One leg over some instants.

    Parameters
    ----------
    depth : (n,) float [m]
    measured, response, deviation : (n, 3) float [N]
        Channels as in `LegContact`.
    place : (n, 3) float, map frame [m]
        Where the ground was felt.
    has_velocity : bool
        True when the body's velocity was known all the time.
    """

    depth: FloatArray
    measured: FloatArray
    response: FloatArray
    deviation: FloatArray
    place: FloatArray
    has_velocity: bool


class StanceReader:
    """Turns measurements of a robot's legs into channels.

    Parameters
    ----------
    robot : RobotModel
    """

    def __init__(self, robot: RobotModel) -> None:
        self._robot = robot

    def vertical_load(self, instant: Instant) -> FloatArray:
        """Return the ground's upward force on each leg, (6,) [N]."""
        x, y, z, w = instant.imu.quaternion
        up = np.array([2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)])
        return np.asarray(self._force_on_leg(instant) @ up)

    def read(self, leg: int, instants: list[Instant], body: BodyMotion,
             configuration: TouchConfiguration, offset: float = 0.0) -> StanceReading:
        """Return what one leg felt over some instants.

        Parameters
        ----------
        offset : float
            How much deeper the leg is taken to be than odometry says [m].
        """
        angle, speed = joint_angles(instants, leg)
        response = self._response(leg, body, angle, speed, configuration, offset)
        measured = self._measured(leg, instants, body, speed, configuration.moment_arm)
        return StanceReading(
            depth=response.depth, measured=measured,
            response=_channels(response, configuration.moment_arm),
            deviation=_deviation(measured, response.speed, configuration),
            place=body.position + response.place, has_velocity=body.has_velocity)

    def height_offset(self, leg: int, instants: list[Instant], body: BodyMotion, felt: BoolArray,
                      configuration: TouchConfiguration) -> HeightOffset | None:
        """Return how much deeper the leg was than odometry says; None if it cannot be told."""
        higher, lower = (self.read(leg, instants, body, configuration, offset)
                         for offset in (0.0, _OFFSET_STEP))
        if higher.depth[~felt][:1].max(initial=0.0) > 0.0:
            return None  # it stood in the ground before, and nobody knows for how long
        used = felt & (lower.depth > 0.0)
        if used.sum() < configuration.fewest_samples:
            return None
        return offset_of(higher.measured[used], higher.response[used], lower.response[used],
                         higher.deviation[used], _OFFSET_STEP)

    def _response(self, leg: int, body: BodyMotion, angle: FloatArray, speed: FloatArray,
                  configuration: TouchConfiguration, offset: float) -> LegResponse:
        motion = LegMotion(time=body.time, angle=angle, speed=speed,
                           height=body.position[:, 2] - offset, rotation=body.rotation,
                           velocity=body.velocity, angular_velocity=body.angular_velocity)
        return leg_response(self._robot, leg, motion,
                            displacement=configuration.yield_displacement,
                            damping=configuration.yield_damping)

    def _force_on_leg(self, instant: Instant) -> FloatArray:
        """Return the ground's force on each leg, (6, 3) [N], base frame.

        The leg's own weight and inertia, as seen by the accelerometer, are taken off.
        """
        return np.asarray(instant.wrenches.force
                          + self._robot.leg_mass * instant.imu.specific_force)

    def _measured(self, leg: int, instants: list[Instant], body: BodyMotion, speed: FloatArray,
                  moment_arm: float) -> FloatArray:
        """Return the ground's action on a leg, (n, 3): forward, up, moment / arm [N].

        The moment is a mean since the instant before, as the measured effort is: what the motor
        gave, less what sped the leg up.
        """
        on_leg = np.array([self._force_on_leg(instant)[leg] for instant in instants])
        force = np.einsum('nij,nj->ni', body.rotation, on_leg)
        ahead = body.rotation[:, :2, 0]
        ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
        forward = (ahead * force[:, :2]).sum(axis=1)
        effort = np.array([instant.joints.effort[leg] for instant in instants])
        turning = np.diff(speed, prepend=speed[0]) / np.diff(body.time, prepend=-np.inf)
        moment = self._robot.leg_inertia * turning - effort
        return np.column_stack((forward, force[:, 2], moment / moment_arm))


def _channels(response: LegResponse, moment_arm: float) -> FloatArray:
    """Return the modelled response in the channels of the measurement, (n, 3) [N]."""
    return np.column_stack((response.force[:, 0], response.force[:, 2],
                            response.mean_moment / moment_arm))


def _deviation(measured: FloatArray, speed: FloatArray,
               configuration: TouchConfiguration) -> FloatArray:
    """Return how far measured and modelled forces may differ for noise alone, (n, 3) [N].

    The ground pushes against the motion. So a leg that moves so slowly that the direction of its
    motion is not known leaves the direction of the force open.
    """
    size = np.abs(measured)
    deviation = configuration.force_deviation + configuration.force_deviation_share * size
    deviation[:, MOMENT] = (
        configuration.torque_deviation / configuration.moment_arm
        + configuration.torque_deviation_share * size[:, MOMENT])
    noise = configuration.velocity_deviation
    open_share = noise / np.maximum(np.hypot(speed, noise), 1e-9)
    total = np.linalg.norm(measured, axis=1)
    return np.asarray(np.hypot(deviation, (open_share * total)[:, None]))
