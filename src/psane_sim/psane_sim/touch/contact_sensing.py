# SPDX-License-Identifier: Apache-2.0
"""Contact sensing: from joints, hip wrenches, attitude and odometry to one record per stance.

Nothing here knows the ground. Some time after lift-off the motion of the leg, as measured, is
played through a model of ground of strength 1; beside what was measured that gives the regression
its two columns.
"""

import math
from collections import Counter
from dataclasses import dataclass
from enum import Enum

import numpy as np

from psane_mapping.contact import LegContact
from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_mapping.leg_response import LegMotion, leg_response
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.height_bias import HeightBias
from psane_sim.touch.motion_estimate import BodyMotion, Instant, MotionRecord
from psane_sim.touch.sensing import ImuSample, JointSample, OdometrySample, WrenchSample
from psane_sim.touch.stance_record import BoolArray, StanceReader

LEAD_IN = 0.1
"""Time before touch-down that is read too: it fills the modelled ground's memory [s]."""


class Dropped(Enum):
    """Why a stance was not handed on."""

    TOO_SHORT = 'fewer samples than a regression needs'
    STANDING = 'the leg stood still for longer than a stance may last'
    NO_ODOMETRY = 'no recent odometry, so that nobody knows where it was felt'


@dataclass
class _Stance:
    """A stance that goes on: when it began, and when the leg was last under load [s]."""

    touch_down: float
    loaded: float


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
        self._reader = StanceReader(robot)
        self._motion = MotionRecord(configuration.longest_stance + 0.5)
        self._height_bias = HeightBias(
            configuration.height_deviation, configuration.tilt_deviation,
            configuration.stance_height_deviation, configuration.height_drift)
        self._stances: dict[int, _Stance] = {}
        self.dropped: Counter[Dropped] = Counter()

    def reconfigure(self, configuration: TouchConfiguration) -> None:
        """Go on with other parameters; stances under way are judged by the new ones."""
        self._configuration = configuration
        self._motion.span = configuration.longest_stance + 0.5

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
        instant = Instant(joints, wrenches, imu)
        if self._motion.odometry_age(instant.time) > self._configuration.odometry_timeout:
            self.dropped[Dropped.NO_ODOMETRY] += len(self._stances)
            self._forget()
            return []
        newest = self._motion.newest
        if newest is not None:
            if instant.time <= newest:
                return []
            if instant.time - newest > self._configuration.longest_gap:
                self._forget()
        self._motion.add(instant)
        load = self._reader.vertical_load(instant)
        contacts = [self._follow(leg, instant.time, float(load[leg])) for leg in range(len(load))]
        return [contact for contact in contacts if contact is not None]

    def _forget(self) -> None:
        self._stances.clear()
        self._motion.forget()

    def _follow(self, leg: int, now: float, load: float) -> LegContact | None:
        """Begin, continue or end the stance of one leg; return it when it ended and is of use."""
        configuration = self._configuration
        stance = self._stances.get(leg)
        if stance is None:
            if load > configuration.touch_down_force:
                self._stances[leg] = _Stance(now, now)
        elif load > configuration.lift_off_force:
            stance.loaded = now
        elif now - stance.loaded >= configuration.lift_off_time:
            del self._stances[leg]
            return self._finish(leg, stance)
        return None

    def _finish(self, leg: int, stance: _Stance) -> LegContact | None:
        configuration = self._configuration
        if stance.loaded - stance.touch_down > configuration.longest_stance:
            self.dropped[Dropped.STANDING] += 1
            return None
        instants = self._motion.since(stance.touch_down - LEAD_IN)
        time = np.array([instant.time for instant in instants])
        felt = (time >= stance.touch_down) & (time <= stance.loaded)
        if felt.sum() < configuration.fewest_samples:
            self.dropped[Dropped.TOO_SHORT] += 1
            return None
        body = self._motion.body(instants)
        offset = self._height_offset(leg, instants, body, felt)
        reading = self._reader.read(leg, instants, body, configuration, offset)
        point, spread = _weighted_point(reading.place[felt, :2], reading.measured[felt, 1])
        return LegContact(
            leg=leg, touch_down=stance.touch_down, lift_off=stance.loaded, point=point,
            point_deviation=math.hypot(configuration.position_deviation, spread),
            depth=reading.depth[felt], measured=reading.measured[felt],
            response=reading.response[felt], deviation=reading.deviation[felt],
            has_velocity=reading.has_velocity)

    def _height_offset(self, leg: int, instants: list[Instant], body: BodyMotion,
                       felt: BoolArray) -> float:
        """Learn from a stance how far off the height is, and return it for its leg [m]."""
        configuration, hip = self._configuration, self._robot.hips[leg]
        if not configuration.learn_height:
            return 0.0
        if body.has_velocity:
            found = self._reader.height_offset(leg, instants, body, felt, configuration)
            if found is not None:
                self._height_bias.learn(found, hip, float(body.time[-1]))
        return self._height_bias.at(hip)


def _weighted_point(points: FloatArray, load: FloatArray) -> tuple[FloatArray, float]:
    """Return the mean (2,) of points weighted by load, and their deviation along an axis [m]."""
    weight = np.maximum(load, 0.0)
    weight = weight / weight.sum() if weight.sum() > 0.0 else np.full(len(load), 1.0 / len(load))
    mean = weight @ points
    spread = float(np.sqrt(0.5 * (weight @ ((points - mean) ** 2).sum(axis=1))))
    return mean, spread
