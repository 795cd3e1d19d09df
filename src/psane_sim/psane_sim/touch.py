# SPDX-License-Identifier: Apache-2.0
"""Contact sensing: from joints, hip wrenches, attitude and odometry to one record per stance.

Nothing here knows the ground. At lift-off the motion of the leg, as measured, is played through a
model of ground of strength 1; beside what was measured that gives the regression its two columns.
"""

import math
from collections import Counter, deque
from dataclasses import dataclass
from enum import Enum

import numpy as np

from psane_mapping.contact import LegContact
from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_mapping.leg_response import LegMotion, LegResponse, leg_response
from psane_sim.motion_estimate import BodyMotion, MotionEstimate
from psane_sim.sensing import ImuSample, JointSample, OdometrySample, WrenchSample
from psane_sim.touch_configuration import TouchConfiguration

VERTICAL, MOMENT = 1, 2
"""Columns of the channels."""

LEAD_IN = 4
"""Samples before touch-down that fill the modelled ground's memory."""


class Dropped(Enum):
    """Why a stance was not handed on."""

    TOO_SHORT = 'fewer samples than a regression needs'
    STANDING = 'the leg stood still for longer than a stance may last'
    NO_ODOMETRY = 'no recent odometry, so that nobody knows where it was felt'


@dataclass(frozen=True)
class _Sample:
    """One instant of all legs: motion of the body, joints, and what was felt (6, 3) [N]."""

    body: BodyMotion
    angle: FloatArray
    speed: FloatArray
    measured: FloatArray


@dataclass
class _Stance:
    """A stance that goes on: its samples, the first of them from before touch-down."""

    samples: list[_Sample]
    lead_in: int
    quiet: int = 0
    is_standing: bool = False


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
        self._recent: deque[_Sample] = deque(maxlen=LEAD_IN)
        self._stances: dict[int, _Stance] = {}
        self.dropped: Counter[Dropped] = Counter()

    def reconfigure(self, configuration: TouchConfiguration) -> None:
        """Go on with other parameters; stances under way are judged by the new ones."""
        self._configuration = configuration

    def warm_up(self) -> None:
        """Run the compiled function once, so that no stance waits for the compiler."""
        still = LegMotion(
            time=np.array([0.0, 0.005]), angle=np.zeros(2), speed=np.zeros(2),
            height=np.full(2, 0.1), rotation=np.tile(np.eye(3), (2, 1, 1)),
            velocity=np.zeros((2, 3)), angular_velocity=np.zeros((2, 3)))
        leg_response(self._robot, 0, still)

    def set_odometry(self, sample: OdometrySample) -> None:
        """Take in where the body is and how it moves."""
        self._motion.set_odometry(sample)

    def update(self, joints: JointSample, wrenches: WrenchSample,
               imu: ImuSample) -> list[LegContact]:
        """Take in one set of measurements of the same instant; return the stances that ended.

        Parameters
        ----------
        joints : JointSample
            Angles, speeds and efforts of the six hips.
        wrenches : WrenchSample
            What each leg does to the body at its hip, base frame.
        imu : ImuSample
            Attitude, angular velocity and specific force.
        """
        body = self._motion.at(imu)
        if body is None:
            self.dropped[Dropped.NO_ODOMETRY] += len(self._stances)
            self._forget()
            return []
        if self._recent:
            step = body.time - self._recent[-1].body.time
            if step <= 0.0:
                return []
            if step > self._configuration.longest_gap:
                self._forget()
        sample = _Sample(body, joints.position, joints.velocity,
                         self._measured(joints, wrenches, imu, body.rotation))
        contacts = [self._follow(leg, sample) for leg in range(len(joints.position))]
        self._recent.append(sample)
        return [contact for contact in contacts if contact is not None]

    def _forget(self) -> None:
        self._stances.clear()
        self._recent.clear()

    def _measured(self, joints: JointSample, wrenches: WrenchSample, imu: ImuSample,
                  rotation: FloatArray) -> FloatArray:
        """Return what the ground does to each leg, (6, 3): forward, up, moment / arm [N].

        The leg's own weight and inertia, as seen by the accelerometer, are taken off.
        """
        on_leg = wrenches.force + self._robot.leg_mass * imu.specific_force
        force = on_leg @ rotation.T
        heading = math.atan2(rotation[1, 0], rotation[0, 0])
        forward = math.cos(heading) * force[:, 0] + math.sin(heading) * force[:, 1]
        moment = -joints.effort / self._configuration.moment_arm
        return np.column_stack((forward, force[:, 2], moment))

    def _follow(self, leg: int, sample: _Sample) -> LegContact | None:
        """Begin, continue or end the stance of one leg; return it when it ended and is of use."""
        configuration = self._configuration
        load = float(sample.measured[leg, VERTICAL])
        stance = self._stances.get(leg)
        if stance is None:
            if load > configuration.touch_down_force:
                lead_in = list(self._recent)
                self._stances[leg] = _Stance([*lead_in, sample], len(lead_in))
            return None
        stance.quiet = 0 if load > configuration.lift_off_force else stance.quiet + 1
        if stance.quiet >= configuration.lift_off_samples:
            del self._stances[leg]
            return self._finish(leg, stance)
        if sample.body.time - stance.samples[0].body.time > configuration.longest_stance:
            stance.is_standing = True
            stance.samples = stance.samples[:1]
        stance.samples.append(sample)
        return None

    def _finish(self, leg: int, stance: _Stance) -> LegContact | None:
        configuration = self._configuration
        samples = stance.samples
        if stance.is_standing:
            self.dropped[Dropped.STANDING] += 1
            return None
        if len(samples) - stance.lead_in < configuration.fewest_samples:
            self.dropped[Dropped.TOO_SHORT] += 1
            return None
        motion = _motion_of(leg, samples)
        response = leg_response(self._robot, leg, motion,
                                displacement=configuration.yield_displacement,
                                damping=configuration.yield_damping)
        felt = slice(stance.lead_in, None)
        measured = np.array([sample.measured[leg] for sample in samples])[felt]
        places = np.array([sample.body.position for sample in samples]) + response.place
        point, spread = _weighted_point(places[felt, :2], measured[:, VERTICAL])
        return LegContact(
            leg=leg, touch_down=float(motion.time[stance.lead_in]),
            lift_off=float(motion.time[-1]), point=point,
            point_deviation=math.hypot(configuration.position_deviation, spread),
            depth=response.depth[felt], measured=measured,
            response=self._channels(response)[felt], deviation=self._deviation(measured),
            has_velocity=all(sample.body.has_velocity for sample in samples))

    def _channels(self, response: LegResponse) -> FloatArray:
        """Return the modelled response in the channels of the measurement, (n, 3) [N]."""
        return np.column_stack((response.force[:, 0], response.force[:, 2],
                                response.moment / self._configuration.moment_arm))

    def _deviation(self, measured: FloatArray) -> FloatArray:
        """Return the noise of each measurement, (n, 3) [N]."""
        configuration = self._configuration
        size = np.abs(measured)
        deviation = configuration.force_deviation + configuration.force_deviation_share * size
        deviation[:, MOMENT] = (configuration.torque_deviation / configuration.moment_arm
                                + configuration.torque_deviation_share * size[:, MOMENT])
        return np.asarray(deviation)


def _motion_of(leg: int, samples: list[_Sample]) -> LegMotion:
    """Return the motion of one leg over a stance."""
    bodies = [sample.body for sample in samples]
    return LegMotion(
        time=np.array([body.time for body in bodies]),
        angle=np.array([sample.angle[leg] for sample in samples]),
        speed=np.array([sample.speed[leg] for sample in samples]),
        height=np.array([body.position[2] for body in bodies]),
        rotation=np.array([body.rotation for body in bodies]),
        velocity=np.array([body.velocity for body in bodies]),
        angular_velocity=np.array([body.angular_velocity for body in bodies]))


def _weighted_point(points: FloatArray, load: FloatArray) -> tuple[FloatArray, float]:
    """Return the mean (2,) of points weighted by load, and their deviation along an axis [m]."""
    weight = np.maximum(load, 0.0)
    weight = weight / weight.sum() if weight.sum() > 0.0 else np.full(len(load), 1.0 / len(load))
    mean = weight @ points
    spread = float(np.sqrt(0.5 * (weight @ ((points - mean) ** 2).sum(axis=1))))
    return mean, spread
