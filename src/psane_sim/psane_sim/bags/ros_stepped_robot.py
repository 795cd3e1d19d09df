# SPDX-License-Identifier: Apache-2.0
"""The simulated robot as a source of contacts and odometry, step by step, as on the wire."""

import numpy as np
from rclpy.serialization import serialize_message

from psane_mapping.bag_file import BagMessage
from psane_mapping.conversions import contact_message
from psane_mapping.leg import RobotModel
from psane_sim.bags.lockstep_times import INPUTS, MILLISECOND, STEP
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.conversions import odometry_message
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.contact_sensing import ContactSensor
from psane_sim.touch.sensing import Sensors

SENSOR_PERIOD, ODOMETRY_PERIOD = 5, 10
"""Milliseconds between sensor readings, and between odometry for the sense of touch."""


class SteppedRobot:
    """A robot on a terrain that walks as it is told.

    Parameters
    ----------
    terrain : str
    goal : (x, y), map frame [m]
        Where it looks at first.
    seed : int
    """

    def __init__(self, terrain: str, goal: tuple[float, float], seed: int) -> None:
        world = load_terrain(terrain)
        x, y = world.start
        configuration = SimulatorConfiguration()
        self._simulator = HexapodSimulator(
            configuration, world, (x, y, float(np.arctan2(goal[1] - y, goal[0] - x))),
            robot=RobotModel())
        self._sensors = Sensors(configuration, seed)
        self._touch = ContactSensor(TouchConfiguration(), RobotModel())
        self._now = 0

    def command(self, linear: float, angular: float) -> None:
        """Walk at a speed [m/s] and a yaw rate [rad/s] from now on."""
        self._simulator.command(linear, angular)

    def step(self) -> list[BagMessage]:
        """Walk for one step; return what was felt, and the latest odometry."""
        messages = []
        for _ in range(STEP // SENSOR_PERIOD):
            self._simulator.step(SENSOR_PERIOD)
            self._now += SENSOR_PERIOD
            truth = self._simulator.truth()
            if self._now % ODOMETRY_PERIOD == 0:
                latest = self._sensors.odometry(truth)
                self._touch.set_odometry(latest)
            for contact in self._touch.update(self._sensors.joints(truth),
                                              self._sensors.wrenches(truth),
                                              self._sensors.imu(truth)):
                messages.append(self._message('/leg_contacts', contact_message(contact, 'map')))
        odometry = odometry_message(latest, 'odom', 'base_link')
        return [*messages, self._message('/odom', odometry)]

    def _message(self, topic: str, message: object) -> BagMessage:
        return BagMessage(topic, INPUTS[topic], self._now * MILLISECOND,
                          serialize_message(message))

    def close(self) -> None:
        """End the simulation."""
        self._simulator.close()
