# SPDX-License-Identifier: Apache-2.0
"""The node `reactive_controller`: safe region, subgoal and odometry in, velocity commands out."""

from concurrent.futures import ThreadPoolExecutor

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

from psane_mapping import conversions
from psane_mapping.grid import FloatArray
from psane_mapping.quality_of_service import COMMANDS, LATCHED, ODOMETRY_INPUT
from psane_mapping.ros_parameters import ParameterBridge
from psane_mapping.running import Diagnostics, Intake, run_node
from psane_msgs.msg import PlannerStatus, SafeRegion
from psane_reactive.command import Command
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.conversions import (
    TROUBLES,
    motion_of,
    region_of,
    steering_status_of,
    tilt_of,
    twist_of,
)
from psane_reactive.node_configuration import ReactiveNodeConfiguration


class ReactiveControllerNode(Node):
    """Holds a `ReactiveController` on the graph."""

    def __init__(self) -> None:
        super().__init__('reactive_controller')
        self._settings = ParameterBridge(self, ReactiveNodeConfiguration).configuration
        self._bridge = ParameterBridge(self, ReactiveConfiguration, self._reconfigure)
        self._frame = self._bridge.configuration.map_frame
        # Maps are built beside the control loop, one at a time, unless that is not wanted.
        self._executor = ThreadPoolExecutor(max_workers=1) if self._settings.build_beside else None
        self._controller = ReactiveController(self._bridge.configuration, self._executor)
        self._controller.warm_up()
        self._region: SafeRegion | None = None
        self._subgoal: FloatArray | None = None
        self._command: Command | None = None
        kind = TwistStamped if self._settings.enable_stamped_cmd_vel else Twist
        self._publisher = self.create_publisher(kind, 'cmd_vel', COMMANDS)
        self._status = self.create_publisher(DiagnosticStatus, 'steering_status', LATCHED)
        self._intake = Intake(self)
        take = self._intake.subscribe
        take(SafeRegion, 'safe_region', self._take_region, LATCHED)
        take(PoseStamped, 'subgoal', self._take_subgoal, LATCHED)
        take(PlannerStatus, 'planner_status', self._take_status, LATCHED)
        take(Odometry, 'odom', self._take_odometry, ODOMETRY_INPUT)
        self._diagnostics = Diagnostics(self, self._intake, self._report)
        self.create_timer(1.0 / self._bridge.configuration.rate, self._cycle)

    def _now(self) -> float:
        return conversions.seconds(self.get_clock().now().to_msg())

    def _reconfigure(self, configuration: ReactiveConfiguration) -> None:
        """Steer by other parameters; region and subgoal are those of before."""
        self._controller = ReactiveController(configuration, self._executor)
        if self._region is not None:
            self._take_region(self._region)

    def _take_region(self, message: SafeRegion) -> None:
        self._controller.set_region(region_of(message, self._frame),
                                    conversions.seconds(message.header.stamp))
        self._region = message

    def _take_subgoal(self, message: PoseStamped) -> None:
        self._subgoal = conversions.point_of(message, self._frame)

    def _take_status(self, message: PlannerStatus) -> None:
        conversions.require_frame(message.header, self._frame)
        subgoal = self._subgoal if message.has_subgoal else None
        self._controller.set_subgoal(subgoal, message.march, message.subgoal_is_goal, self._now())

    def _take_odometry(self, message: Odometry) -> None:
        pose, velocity, time = motion_of(message, self._settings.odom_frame)
        self._controller.set_odometry(pose, velocity, time, tilt_of(message))

    def _cycle(self) -> None:
        now = self._now()
        before, self._command = self._command, self._controller.command(now)
        self._publish(self._command, now)
        if before is None or before.mode is not self._command.mode:
            self._status.publish(steering_status_of(
                self._command, self._controller.inputs.subgoal,
                self.get_fully_qualified_name()))
        if self._command.mode in TROUBLES and (
                before is None or before.reason != self._command.reason):
            self.get_logger().info(f'{self._command.mode.value}: {self._command.reason}',
                                   throttle_duration_sec=2.0)

    def _publish(self, command: Command, now: float) -> None:
        twist = twist_of(command)
        if self._settings.enable_stamped_cmd_vel:
            header = conversions.header(now, self._settings.base_frame)
            self._publisher.publish(TwistStamped(header=header, twist=twist))
        else:
            self._publisher.publish(twist)

    def _report(self) -> tuple[bytes, str, dict[str, object]]:
        command = self._command
        if command is None:
            return DiagnosticStatus.WARN, 'no command yet', {}
        level = DiagnosticStatus.WARN if command.mode in TROUBLES else DiagnosticStatus.OK
        return level, f'{command.mode.value}: {command.reason}', vars(self._controller.counts)


def main() -> None:
    """Run the node."""
    run_node(ReactiveControllerNode)
