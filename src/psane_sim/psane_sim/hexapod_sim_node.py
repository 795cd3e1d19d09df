# SPDX-License-Identifier: Apache-2.0
"""The node `hexapod_sim`: velocity commands in; clock, odometry, joints, wrenches and imu out."""

import time
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage
from sensor_msgs.msg import Imu, JointState

from psane_mapping.conversions import seconds, stamp
from psane_mapping.errors import ParameterError
from psane_mapping.leg import RobotModel
from psane_mapping.quality_of_service import COMMANDS, DEFAULT, ODOMETRY, SENSORS
from psane_mapping.ros_parameters import ParameterBridge
from psane_mapping.running import Diagnostics, Intake, run_node
from psane_msgs.msg import HipWrenches
from psane_sim import conversions
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.errors import SimulationError
from psane_sim.node_configuration import SimulatorNodeConfiguration
from psane_sim.pacing import Follower, Pacer
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.robot.truth import Truth
from psane_sim.runs.truth_log import TruthEntry, TruthLog
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.terrains.endpoints import SAFE_SLIP
from psane_sim.terrains.terrain_sense import nonsense_of
from psane_sim.touch.sensing import Sensors
from psane_sim.transforms import TransformPublisher
from psane_sim.watchdog import CommandWatchdog

SENSOR_PERIOD, ODOMETRY_PERIOD, TRUTH_PERIOD = 5, 20, 50
"""Milliseconds between sensor readings, odometry messages and entries of the truth log."""


class HexapodSimNode(Node):
    """Holds a `HexapodSimulator` and its `Sensors` on the graph."""

    def __init__(self) -> None:
        super().__init__('hexapod_sim')
        self._settings = ParameterBridge(self, SimulatorNodeConfiguration,
                                         self._reconfigure).configuration
        simulator = ParameterBridge(self, SimulatorConfiguration).configuration
        robot = ParameterBridge(self, RobotModel).configuration
        self._simulator = self._make_simulator(simulator, robot)
        self._sensors = Sensors(simulator, self._settings.seed)
        self._watchdog = CommandWatchdog(self._settings.command_timeout)
        truth_file = self._settings.truth_file
        self._log = TruthLog(Path(truth_file)) if truth_file else None
        self._advertise()
        self._intake = Intake(self)
        self._intake.subscribe(Twist, 'cmd_vel', self._take_command, COMMANDS)
        self._diagnostics = Diagnostics(self, self._intake, self._report)
        self._pacer = self._make_pacer()
        self._ticks = 0
        self._has_begun = not self._settings.awaited_listener
        self.create_timer(2e-3, self._catch_up, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _make_simulator(self, configuration: SimulatorConfiguration,
                        robot: RobotModel) -> HexapodSimulator:
        settings = self._settings
        try:
            terrain = load_terrain(settings.terrain).scaled(settings.strength_factor)
            start = terrain.start_pose
            if settings.use_start:
                start = (settings.start_x, settings.start_y, settings.start_yaw)
            goal = None if settings.use_start else terrain.goal
            for problem in nonsense_of(terrain, start[:2], goal, SAFE_SLIP):
                self.get_logger().warning(f'{settings.terrain}: {problem}')
            return HexapodSimulator(configuration, terrain, start, robot=robot)
        except SimulationError as error:
            raise ParameterError('terrain', settings.terrain, f'a usable world ({error})'
                                 ) from error

    def _make_pacer(self) -> Pacer | Follower:
        if not self._settings.follow_clock:
            return Pacer(self._settings.pace, time.monotonic())
        follower = Follower(time.monotonic())
        self._intake.subscribe(ClockMessage, '/clock',
                               lambda message: follower.hear(seconds(message.clock)), DEFAULT)
        return follower

    def _advertise(self) -> None:
        self._clock_publisher = (None if self._settings.follow_clock else
                                 self.create_publisher(ClockMessage, '/clock', DEFAULT))
        self._odometry = self.create_publisher(Odometry, 'odom', ODOMETRY)
        self._joints = self.create_publisher(JointState, 'joint_states', SENSORS)
        self._wrenches = self.create_publisher(HipWrenches, 'hip_wrenches', SENSORS)
        self._imu = self.create_publisher(Imu, 'imu', SENSORS)
        self._transforms = TransformPublisher(self, self._settings.map_frame)

    def _reconfigure(self, settings: SimulatorNodeConfiguration) -> None:
        self._settings = settings
        self._watchdog.timeout = settings.command_timeout

    def _take_command(self, message: Twist) -> None:
        self._watchdog.take(*conversions.velocity_of(message), self._simulator.time)

    def _catch_up(self) -> None:
        """Simulate what the wall clock asks for, a few sensor periods at most."""
        if not self._has_begun:
            self._has_begun = self._is_heard_by(self._settings.awaited_listener)
            return
        wall = time.monotonic()
        for _ in range(self._pacer.due(wall, self._simulator.time, SENSOR_PERIOD * 1e-3)):
            self._advance()

    def _is_heard_by(self, listener: str) -> bool:
        """Tell whether a node listens to all that is published here at a steady rate."""
        return all(
            any(info.node_name == listener
                for info in self.get_subscriptions_info_by_topic(publisher.topic_name))
            for publisher in (self._clock_publisher, self._odometry, self._joints,
                              self._wrenches, self._imu) if publisher is not None)

    def _advance(self) -> None:
        """Simulate one sensor period and publish what was measured at its end."""
        self._simulator.command(*self._watchdog.command(self._simulator.time))
        self._simulator.step(SENSOR_PERIOD)
        self._ticks += SENSOR_PERIOD
        truth = self._simulator.truth()
        if self._clock_publisher is not None:
            self._clock_publisher.publish(ClockMessage(clock=stamp(truth.time)))
        self._publish(truth)
        if self._log is not None and self._ticks % TRUTH_PERIOD == 0:
            self._log.write(TruthEntry.of(truth))

    def _publish(self, truth: Truth) -> None:
        """Publish odometry first, so that the measurements of its instant find it."""
        settings, sensors = self._settings, self._sensors
        if self._ticks % ODOMETRY_PERIOD == 0:
            odometry = conversions.odometry_message(sensors.odometry(truth), settings.odom_frame,
                                                    settings.base_frame)
            self._odometry.publish(odometry)
            self._transforms.publish(odometry)
        self._joints.publish(conversions.joint_message(sensors.joints(truth),
                                                       settings.base_frame))
        self._wrenches.publish(conversions.wrench_message(sensors.wrenches(truth),
                                                          settings.base_frame))
        self._imu.publish(conversions.imu_message(sensors.imu(truth), settings.base_frame))

    def _report(self) -> tuple[bytes, str, dict[str, object]]:
        now = self._simulator.time
        silent = self._watchdog.is_silent(now)
        message = 'no recent command: the robot stands' if silent else 'obeys cmd_vel'
        level = DiagnosticStatus.WARN if silent else DiagnosticStatus.OK
        factor = self._pacer.factor(time.monotonic(), now)
        return level, message, {'time [s]': round(now, 2),
                                'real-time factor': round(factor, 2)}


def main() -> None:
    """Run the node."""
    run_node(HexapodSimNode)
