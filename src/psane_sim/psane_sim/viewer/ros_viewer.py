# SPDX-License-Identifier: Apache-2.0
"""Hears the topics of a run for the live view, and publishes the goals that are clicked."""

import argparse
import math
import signal
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from nav_msgs.msg import Path as PathMessage
from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock as ClockMessage
from sensor_msgs.msg import JointState

from psane_mapping import conversions
from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_mapping.map_cells import slip_of_cells
from psane_mapping.quality_of_service import (
    CONTACTS,
    DEFAULT,
    LATCHED,
    ODOMETRY_INPUT,
    SENSORS,
)
from psane_mapping.running import Diagnostics, Intake
from psane_msgs.msg import (
    FrontierArray,
    HipWrenches,
    MapScale,
    PlannerStatus,
    SafeRegion,
    TerrainSample,
)
from psane_planner.conversions import CERTIFIED
from psane_planner.status import PlannerState
from psane_reactive.conversions import region_of
from psane_sim.conversions import joints_of, odometry_of, wrenches_of
from psane_sim.viewer.data import Situation
from psane_sim.viewer.ground import SLIP, UNCERTAINTY
from psane_sim.viewer.live_view import LiveView
from psane_sim.viewer.server import address_of, open_server

DRAW_PERIOD = 0.05
"""Time on the wall between drawings [s]."""


class Viewer(Node):
    """Tells a `LiveView` what it hears.

    Parameters
    ----------
    view : LiveView
    robots : list of str
        Namespaces of the robots.
    frame : str
        Frame of maps and goals.
    arguments : list of str
        ROS arguments: remappings and a namespace.
    """

    def __init__(self, view: LiveView, robots: list[str], frame: str,
                 arguments: list[str]) -> None:
        super().__init__('viewer', cli_args=arguments, use_global_arguments=False)
        self._view, self._frame = view, frame
        self._std_scale = math.nan
        self._time = 0.0
        self._goals = 0
        self._intake = Intake(self)
        take = self._intake.subscribe
        take(ClockMessage, '/clock', self._take_clock, DEFAULT)
        take(MapScale, 'map_scale', self._take_scale, LATCHED)
        take(OccupancyGrid, 'slip/mean', self._take_mean, LATCHED)
        take(OccupancyGrid, 'slip/std', self._take_std, LATCHED)
        take(TerrainSample, 'terrain_samples', self._take_sample, CONTACTS)
        self._goal_topics = {robot: self._follow(robot) for robot in robots}
        self._diagnostics = Diagnostics(self, self._intake, self._report)
        self.create_timer(DRAW_PERIOD, self._draw, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _follow(self, robot: str) -> Publisher:
        """Subscribe to the topics of a robot; return the publisher of its goals."""
        hears = _RobotEars(self._view, robot, self._frame, self._note_time)
        start = f'{robot}/' if robot else ''
        for kind, topic, callback, quality in (
                (Odometry, 'odom', hears.take_odometry, ODOMETRY_INPUT),
                (JointState, 'joint_states', hears.take_joints, SENSORS),
                (HipWrenches, 'hip_wrenches', hears.take_wrenches, SENSORS),
                (SafeRegion, 'safe_region', hears.take_region, LATCHED),
                (OccupancyGrid, 'safe_map', hears.take_safe_map, LATCHED),
                (FrontierArray, 'frontiers', hears.take_frontier, LATCHED),
                (PoseStamped, 'subgoal', hears.take_subgoal, LATCHED),
                (PoseStamped, 'goal_pose', hears.take_goal, DEFAULT),
                (PathMessage, 'path', hears.take_path, LATCHED),
                (PlannerStatus, 'planner_status', hears.take_status, LATCHED)):
            self._intake.subscribe(kind, f'{start}{topic}', callback, quality)
        return self.create_publisher(PoseStamped, f'{start}goal_pose', DEFAULT)

    def _note_time(self, time_of_message: float) -> None:
        """Take a message's time where there is no clock to go by."""
        if self.count_publishers('/clock') == 0:
            self._tick(time_of_message)

    def _tick(self, now: float) -> None:
        self._time = now
        self._view.take_time(time.monotonic(), now)

    def _take_clock(self, message: ClockMessage) -> None:
        self._tick(conversions.seconds(message.clock))

    def _take_scale(self, message: MapScale) -> None:
        self._std_scale = conversions.std_scale_of(message, self._frame)

    def _take_mean(self, message: OccupancyGrid) -> None:
        grid, cells = conversions.cells_of(message, self._frame)
        self._view.take_map(SLIP, grid, slip_of_cells(cells, cells, 1.0)[0])

    def _take_std(self, message: OccupancyGrid) -> None:
        grid, cells = conversions.cells_of(message, self._frame)
        self._view.take_map(UNCERTAINTY, grid, slip_of_cells(cells, cells, self._std_scale)[1])

    def _take_sample(self, message: TerrainSample) -> None:
        conversions.require_frame(message.header, self._frame)
        self._view.take_contact(np.array([message.point.x, message.point.y]), message.slip)

    def _draw(self) -> None:
        self._view.draw(time.monotonic())
        for click in self._view.clicks():
            self._goal_topics[click.robot].publish(
                conversions.pose_message(click.point, 0.0, self._time, self._frame))
            self._goals += 1
            x, y = click.point
            self.get_logger().info(f'goal ({x:.2f}, {y:.2f}) m'
                                   + (f' for {click.robot}' if click.robot else ''))

    def _report(self) -> tuple[bytes, str, dict[str, object]]:
        return DiagnosticStatus.OK, 'shows the run', {'goals set': self._goals}


class _RobotEars:
    """Turns the messages of one robot into what the view takes."""

    def __init__(self, view: LiveView, robot: str, frame: str,
                 note_time: Callable[[float], None]) -> None:
        self._view, self._robot, self._frame = view, robot, frame
        self._scene = view.robot(robot)
        self._note_time = note_time
        self._subgoal: FloatArray | None = None

    def take_odometry(self, message: Odometry) -> None:
        sample = odometry_of(message, message.header.frame_id)
        self._note_time(sample.time)
        self._scene.take_pose(sample.position, sample.quaternion)

    def take_joints(self, message: JointState) -> None:
        self._scene.take_joints(joints_of(message).position)

    def take_wrenches(self, message: HipWrenches) -> None:
        self._scene.take_forces(wrenches_of(message, message.header.frame_id).force)

    def take_region(self, message: SafeRegion) -> None:
        self._scene.take_region(region_of(message, self._frame))

    def take_safe_map(self, message: OccupancyGrid) -> None:
        grid, cells = conversions.cells_of(message, self._frame)
        self._view.take_certified(grid, cells == CERTIFIED)

    def take_frontier(self, message: FrontierArray) -> None:
        conversions.require_frame(message.header, self._frame)
        points = np.array([(point.x, point.y) for point in message.points]).reshape(-1, 2)
        self._scene.take_frontier(points, np.array(message.score))

    def take_subgoal(self, message: PoseStamped) -> None:
        self._subgoal = conversions.point_of(message, self._frame)

    def take_goal(self, message: PoseStamped) -> None:
        self._scene.take_goal(conversions.point_of(message, self._frame))

    def take_path(self, message: PathMessage) -> None:
        conversions.require_frame(message.header, self._frame)
        points = [(pose.pose.position.x, pose.pose.position.y) for pose in message.poses]
        self._scene.take_path(np.array(points).reshape(-1, 2))

    def take_status(self, message: PlannerStatus) -> None:
        self._scene.take_subgoal(self._subgoal if message.has_subgoal else None)
        self._view.take_situation(
            self._robot, conversions.seconds(message.header.stamp),
            Situation(state=PlannerState(message.state).name, cause=message.cause,
                      remedy=message.remedy, strategy=message.strategy,
                      distance=message.distance_to_goal, area=message.certified_area,
                      subgoals=message.subgoal_count, march=message.march))


def _interrupt(number: int, frame: FrameType | None) -> None:
    """End like Ctrl-C, so that a page that was asked for is written."""
    raise KeyboardInterrupt


def serve(options: argparse.Namespace, model: RobotModel, arguments: list[str]) -> None:
    """Serve the view until the user or the system ends it; then write the page, if there is one.

    Parameters
    ----------
    options : argparse.Namespace
        `host`, `port`, `export`, `robots` and `frame` of the command line.
    model : RobotModel
    arguments : list of str
        ROS arguments.
    """
    server = open_server(options.host, options.port)
    export: Path | None = options.export
    view = LiveView(server, options.robots, model, record=export is not None)
    # Its own handlers would shut the context down before Ctrl-C is noticed.
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, _interrupt)
    node = Viewer(view, options.robots, options.frame, arguments)
    print(f'psane viewer: {address_of(server)}', flush=True)
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        # Whoever asked for the end may ask again; the page is written first.
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        if export is not None:
            view.write(export)
            print(f'psane viewer: wrote {export}', flush=True)
        node.destroy_node()
        rclpy.try_shutdown()
        server.stop()
