# SPDX-License-Identifier: Apache-2.0
"""Contact sensing: from joints, hip wrenches, attitude and odometry to one record per stance.

Nothing here knows the ground. The robot's motion, as measured, is played through a model of ground
of strength 1; beside what was measured that gives the regression its two columns.
"""

import math
from collections import Counter
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from psane_mapping.contact import LegContact
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.leg import RobotModel

from psane_sim.motion_estimate import MotionEstimate
from psane_sim.sensing import HipWrenchSample, ImuSample, JointSample, OdometrySample
from psane_sim.soil import GranularSoil
from psane_sim.strength_field import StrengthField
from psane_sim.touch_configuration import TouchConfiguration

FORWARD, VERTICAL, MOMENT = 0, 1, 2
"""Columns of the channels."""


class Dropped(Enum):
    """Why a stance was not handed on."""

    TOO_SHORT = 'fewer samples than a regression needs'
    STANDING = 'the leg stood still for longer than a stance may last'
    NO_ODOMETRY = 'no recent odometry, so that nobody knows where it was felt'


@dataclass
class _Stance:
    """Samples of a stance that goes on."""

    began: float
    times: list[float] = field(default_factory=list)
    depth: list[float] = field(default_factory=list)
    measured: list[FloatArray] = field(default_factory=list)
    response: list[FloatArray] = field(default_factory=list)
    points: list[FloatArray] = field(default_factory=list)
    has_velocity: bool = True
    quiet: int = 0


class ContactSensor:
    """Cuts the stream of measurements into stances, one record for each.

    Parameters
    ----------
    configuration : TouchConfiguration
    robot : RobotModel
        Geometry of the legs that the measurements come from.
    """

    def __init__(self, configuration: TouchConfiguration, robot: RobotModel) -> None:
        self._configuration = configuration
        self._robot = robot
        self._motion = MotionEstimate(configuration.odometry_timeout)
        unit = StrengthField(Grid(origin_x=0.0, origin_y=0.0, resolution=1.0, rows=2, columns=2),
                             np.zeros((2, 2)))
        self._ground = GranularSoil(robot, unit, displacement=configuration.yield_displacement,
                                    damping=configuration.yield_damping)
        self._stances: dict[int, _Stance] = {}
        self._last_time: float | None = None
        self.dropped: Counter[Dropped] = Counter()

    def set_odometry(self, sample: OdometrySample) -> None:
        """Take in where the body is and how it moves."""
        self._motion.set_odometry(sample)

    def update(self, joints: JointSample, wrenches: HipWrenchSample,
               imu: ImuSample) -> list[LegContact]:
        """Take in one set of measurements of the same instant; return the stances that ended.

        Parameters
        ----------
        joints : JointSample
            Angles, speeds and efforts of the six hips.
        wrenches : HipWrenchSample
            Reactions of the six hips, base frame.
        imu : ImuSample
            Attitude, angular velocity and specific force, base frame.
        """
        now = joints.time
        step = now - self._last_time if self._last_time is not None else 0.0
        self._last_time = now
        if not 0.0 < step <= self._configuration.longest_gap:
            self._forget()
            return []
        state = self._motion.state(joints, imu, now)
        if state is None:
            if self._stances:
                self.dropped[Dropped.NO_ODOMETRY] += len(self._stances)
            self._forget()
            return []
        load = self._ground.load(state, step)
        heading = math.atan2(state.rotation[1, 0], state.rotation[0, 0])
        measured = self._measured(joints, wrenches, imu, state.rotation, heading)
        response = self._response(load.force, load.moment, state.rotation, heading)
        ended = []
        for leg in range(len(joints.position)):
            contact = self._follow(leg, now, measured[leg], response[leg],
                                   float(load.depth[leg]), load.foot[leg, :2])
            if contact is not None:
                ended.append(contact)
        return ended

    def _forget(self) -> None:
        self._stances.clear()
        self._ground.reset()

    def _measured(self, joints: JointSample, wrenches: HipWrenchSample, imu: ImuSample,
                  rotation: FloatArray, heading: float) -> FloatArray:
        """Return what the ground does to each leg, (6, 3): forward, up, moment / arm [N].

        The leg's own weight and inertia, as seen by the accelerometer, are taken off.
        """
        on_leg = wrenches.force + self._robot.leg_mass * imu.acceleration
        force = on_leg @ rotation.T
        forward = math.cos(heading) * force[:, 0] + math.sin(heading) * force[:, 1]
        moment = -joints.effort / self._configuration.moment_arm
        return np.column_stack((forward, force[:, 2], moment))

    def _response(self, force: FloatArray, moment: FloatArray, rotation: FloatArray,
                  heading: float) -> FloatArray:
        """Return the same channels for ground of strength 1, (6, 3) [N]."""
        legs = slice(0, len(self._robot.hips))
        forward = (math.cos(heading) * force[legs, 0] + math.sin(heading) * force[legs, 1])
        about_axis = moment[legs] @ rotation[:, 1] / self._configuration.moment_arm
        return np.column_stack((forward, force[legs, 2], about_axis))

    def _follow(self, leg: int, now: float, measured: FloatArray, response: FloatArray,
                depth: float, point: FloatArray) -> LegContact | None:
        """Begin, continue or end the stance of one leg; return it when it ended and is of use."""
        configuration = self._configuration
        stance = self._stances.get(leg)
        is_loaded = measured[VERTICAL] > configuration.touch_down_force
        if stance is None:
            if not (is_loaded and depth > -configuration.touch_down_height):
                return None
            stance = self._stances[leg] = _Stance(began=now)
        stance.quiet = 0 if measured[VERTICAL] > configuration.lift_off_force else stance.quiet + 1
        if stance.quiet >= configuration.lift_off_samples:
            del self._stances[leg]
            return self._finish(leg, stance)
        stance.times.append(now)
        stance.depth.append(depth)
        stance.measured.append(measured.copy())
        stance.response.append(response.copy())
        stance.points.append(np.array(point))
        stance.has_velocity &= self._motion.has_velocity(now)
        return None

    def _finish(self, leg: int, stance: _Stance) -> LegContact | None:
        configuration = self._configuration
        if len(stance.times) < configuration.fewest_samples:
            self.dropped[Dropped.TOO_SHORT] += 1
            return None
        if stance.times[-1] - stance.began > configuration.longest_stance:
            self.dropped[Dropped.STANDING] += 1
            return None
        measured = np.array(stance.measured)
        point, spread = _weighted_point(np.array(stance.points), measured[:, VERTICAL])
        return LegContact(
            leg=leg, touch_down=stance.began, lift_off=stance.times[-1], point=point,
            point_deviation=math.hypot(configuration.position_deviation, spread),
            depth=np.array(stance.depth), measured=measured, response=np.array(stance.response),
            deviation=self._deviation(measured), has_velocity=stance.has_velocity)

    def _deviation(self, measured: FloatArray) -> FloatArray:
        """Return the noise of each measurement, (n, 3) [N]."""
        configuration = self._configuration
        size = np.abs(measured)
        deviation = configuration.force_deviation + configuration.force_deviation_share * size
        deviation[:, MOMENT] = (configuration.torque_deviation / configuration.moment_arm
                                + configuration.torque_deviation_share * size[:, MOMENT])
        return deviation


def _weighted_point(points: FloatArray, load: FloatArray) -> tuple[FloatArray, float]:
    """Return the mean (2,) of points weighted by load, and their deviation along an axis [m]."""
    weight = np.maximum(load, 0.0)
    weight = weight / weight.sum() if weight.sum() > 0.0 else np.full(len(load), 1.0 / len(load))
    mean = weight @ points
    spread = float(np.sqrt(0.5 * (weight @ ((points - mean) ** 2).sum(axis=1))))
    return mean, spread
