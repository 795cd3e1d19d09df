# SPDX-License-Identifier: Apache-2.0
"""What a robot's topics are judged by."""

from dataclasses import dataclass

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.leg import RobotModel
from psane_mapping.parameters import Configuration, parameter

PROFILES = ('auto', 'sensors', 'contacts')

_ROBOT = RobotModel()


@dataclass(frozen=True, kw_only=True)
class CheckSettings(Configuration):
    """Names, and what is known of the robot; defaults are those of the simulated one."""

    profile: str = parameter(
        'auto', 'whether the robot publishes sensors for contact_sensor, or contacts of its own',
        choices=PROFILES)
    map_frame: str = parameter(MappingConfiguration.map_frame, 'frame of contacts')
    odom_frame: str = parameter('odom', 'frame of odometry')
    base_frame: str = parameter('base_link', 'frame of the body')
    mass: float = parameter(_ROBOT.mass, 'mass of the whole robot', unit='kg', low=0.01,
                            high=10000.0)
    torque_limit: float = parameter(_ROBOT.motor_torque_limit, 'largest torque of a hip motor',
                                    unit='N m', low=0.01, high=10000.0)
    lowest: float = parameter(
        -0.05, "lowest height of the body's origin over the ground", unit='m', low=-10.0,
        high=10.0)
    highest: float = parameter(
        2.0 * _ROBOT.leg_radius + 0.1, "greatest height of the body's origin over the ground",
        unit='m', low=-10.0, high=10.0)
