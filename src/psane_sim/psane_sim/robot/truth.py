# SPDX-License-Identifier: Apache-2.0
"""What the simulator knows of itself at one instant; only scoring and sensing may read it."""

import math
from dataclasses import dataclass

from psane_mapping.grid import FloatArray
from psane_sim.robot.feed_forward import Sweep


@dataclass(frozen=True)
class Truth:
    """State of the simulated robot; arrays of six are in the order of `LEG_NAMES`.

    Parameters
    ----------
    time : float
        Since the simulation began [s].
    position : (3,) float
        Origin of the base frame, map frame [m].
    quaternion : (4,) float
        Attitude of the base in the map, x y z w [-].
    rotation : (3, 3) float
        The same as a matrix, base to map.
    velocity, angular_velocity : (3,) float
        Of the base, map frame [m/s], [rad/s].
    specific_force : (3,) float
        What an accelerometer at the origin reads (gravity included, +9.81 up at rest), mean over
        the last 5 ms, base frame [m/s^2].
    joint_angle, joint_speed, joint_torque : (6,) float
        Hip joints [rad], [rad/s], and the motor's torque on the leg, mean over the last 5 ms
        [N m].
    hip_force, hip_moment : (6, 3) float
        What each leg does to the body at the hip, base frame [N], [N m]. Less the leg's weight
        and inertia this is what the ground does to the leg; the moment's second component is
        the reaction of the motor's torque, mean over the last 5 ms too.
    foot_force : (6, 3) float
        The ground's force on each leg, map frame [N].
    foot : (6, 3) float
        Deepest (or lowest) element of each leg, map frame [m].
    foot_depth : (6,) float
        Its depth below the surface [m]; negative above it.
    belly_depth : float
        Deepest point of the belly [m]; negative above the ground.
    belly_force : (3,) float
        The ground's force on the belly, map frame [N].
    sweep : Sweep
        Stance sweeps that are in force.
    """

    time: float
    position: FloatArray
    quaternion: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    angular_velocity: FloatArray
    specific_force: FloatArray
    joint_angle: FloatArray
    joint_speed: FloatArray
    joint_torque: FloatArray
    hip_force: FloatArray
    hip_moment: FloatArray
    foot_force: FloatArray
    foot: FloatArray
    foot_depth: FloatArray
    belly_depth: float
    belly_force: FloatArray
    sweep: Sweep

    @property
    def yaw(self) -> float:
        """Heading of the base in the map [rad]."""
        return math.atan2(self.rotation[1, 0], self.rotation[0, 0])

    @property
    def pose(self) -> tuple[float, float, float]:
        """X [m], y [m] and yaw [rad] in the map."""
        return float(self.position[0]), float(self.position[1]), self.yaw

    @property
    def tilt(self) -> float:
        """Angle between the body's up and the map's up [rad]."""
        return math.acos(max(-1.0, min(1.0, float(self.rotation[2, 2]))))

    @property
    def belly_touches(self) -> bool:
        """True when the belly is in the ground."""
        return self.belly_depth > 0.0
