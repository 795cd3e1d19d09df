# SPDX-License-Identifier: Apache-2.0
"""The node `safe_planner`: slip maps, odometry and a goal in; subgoal and safe region out."""

from dataclasses import replace

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rclpy.node import Node
from visualization_msgs.msg import MarkerArray

from psane_mapping import conversions
from psane_mapping.errors import MessageError
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.quality_of_service import COMMANDS, DEFAULT, LATCHED, ODOMETRY_INPUT
from psane_mapping.ros_parameters import ParameterBridge
from psane_mapping.running import Diagnostics, Intake, run_node
from psane_msgs.action import NavigateSafely
from psane_msgs.msg import FrontierArray, MapScale, PlannerStatus, SafeRegion
from psane_planner.configuration import PlannerConfiguration
from psane_planner.conversions import (
    frontier_message,
    is_other_point,
    is_other_region,
    region_message,
    safe_map_cells,
    status_message,
    stuck_at_of,
)
from psane_planner.given_maps import GivenMaps
from psane_planner.map_pair import MapPair
from psane_planner.markers import plan_markers
from psane_planner.navigation import End, ErrorCode
from psane_planner.node_configuration import PlannerNodeConfiguration
from psane_planner.planner import SafePlanner
from psane_planner.ros_navigate_action import NavigateAction
from psane_planner.status import Plan, PlannerState
from psane_planner.strategies import AVAILABLE
from psane_planner.trail import Trail

WARM_UP_GRID = Grid.over_workspace(0.0, 0.0, 4.0, 4.0, 0.1)


class SafePlannerNode(Node):
    """Holds a `SafePlanner` on the graph."""

    def __init__(self) -> None:
        super().__init__('safe_planner')
        self._node_bridge = ParameterBridge(self, PlannerNodeConfiguration)
        self._bridge = ParameterBridge(self, PlannerConfiguration, self._reconfigure)
        settings = self._node_bridge.configuration
        self._frame = settings.map_frame
        # Every compiled function runs once here, so that no plan waits for the compiler.
        SafePlanner(self._bridge.configuration, WARM_UP_GRID).warm_up()
        self._maps = MapPair()
        self._planner: SafePlanner | None = None
        self._grid: Grid | None = None
        self._pose: FloatArray | None = None
        self._pose_time = -np.inf
        self._goal: FloatArray | None = None
        self._is_exploring = settings.explore
        self._asked = (0.0, 0.0)
        self._given = GivenMaps()
        self._trail = Trail()
        self._plan: Plan | None = None
        self._sequence = 0
        self._advertise()
        self._subscribe()
        self._action = NavigateAction(self, self._begin_errand, self._drop_goal)
        self._diagnostics = Diagnostics(self, self._intake, self._report)
        self.create_timer(1.0 / settings.plan_rate, self._cycle)
        self.create_timer(settings.republish_period, self._republish)

    def _advertise(self) -> None:
        self._subgoal = self.create_publisher(PoseStamped, 'subgoal', LATCHED)
        self._region = self.create_publisher(SafeRegion, 'safe_region', LATCHED)
        self._safe_map = self.create_publisher(OccupancyGrid, 'safe_map', LATCHED)
        self._frontiers = self.create_publisher(FrontierArray, 'frontiers', LATCHED)
        self._status = self.create_publisher(PlannerStatus, 'planner_status', LATCHED)
        self._markers = self.create_publisher(MarkerArray, 'markers', LATCHED)
        self._path = self.create_publisher(Path, 'path', LATCHED)

    def _subscribe(self) -> None:
        self._intake = Intake(self)
        take = self._intake.subscribe
        take(OccupancyGrid, 'slip/mean', self._take_mean, LATCHED)
        take(OccupancyGrid, 'slip/std', self._take_std, LATCHED)
        take(MapScale, 'map_scale', self._take_scale, LATCHED)
        take(Odometry, 'odom', self._take_odometry, ODOMETRY_INPUT)
        take(Twist, 'cmd_vel', self._take_command, COMMANDS)
        take(DiagnosticStatus, 'steering_status', self._take_steering, LATCHED)
        take(OccupancyGrid, 'keep_out', self._take_keep_out, LATCHED)
        take(OccupancyGrid, 'known_safe', self._take_known_safe, LATCHED)
        take(PoseStamped, 'goal_pose', self._take_goal, DEFAULT)

    def _now(self) -> float:
        return conversions.seconds(self.get_clock().now().to_msg())

    def _reconfigure(self, configuration: PlannerConfiguration) -> None:
        if self._planner is not None:
            self._planner.reconfigure(configuration)

    def _take_mean(self, message: OccupancyGrid) -> None:
        grid, cells = conversions.cells_of(message, self._frame)
        self._maps.take_mean(grid, conversions.seconds(message.header.stamp), cells)

    def _take_std(self, message: OccupancyGrid) -> None:
        grid, cells = conversions.cells_of(message, self._frame)
        self._maps.take_std(grid, conversions.seconds(message.header.stamp), cells)

    def _take_scale(self, message: MapScale) -> None:
        self._maps.take_scale(conversions.std_scale_of(message, self._frame))

    def _take_odometry(self, message: Odometry) -> None:
        self._pose, self._pose_time = conversions.pose_of(
            message, self._node_bridge.configuration.odom_frame)
        if self._planner is not None:
            self._planner.note_motion(self._pose, *self._asked, self._pose_time)
        if self._trail.add(self._pose[:2]):
            self._path.publish(self._trail.message(self._pose_time, self._frame))

    def _take_command(self, message: Twist) -> None:
        self._asked = (message.linear.x, message.angular.z)

    def _take_steering(self, message: DiagnosticStatus) -> None:
        stuck_at = stuck_at_of(message)
        if stuck_at is not None and self._planner is not None and self._planner.note_stuck(
                stuck_at, self._now()):
            self.get_logger().info(f'subgoal set aside, {message.message}')

    def _take_keep_out(self, message: OccupancyGrid) -> None:
        self._given.take_keep_out(*conversions.cells_of(message, self._frame))

    def _take_known_safe(self, message: OccupancyGrid) -> None:
        self._given.take_known_safe(*conversions.cells_of(message, self._frame))

    def _take_goal(self, message: PoseStamped) -> None:
        goal = conversions.point_of(message, self._frame)
        self._action.preempt()
        self._set_goal(goal)

    def _set_goal(self, goal: FloatArray | None) -> None:
        self._goal = goal
        self._is_exploring = goal is None
        words = 'explore' if goal is None else f'new goal ({goal[0]:.2f}, {goal[1]:.2f}) m'
        self.get_logger().info(words)

    def _drop_goal(self) -> None:
        """Have no task any more, unless the node explores by itself."""
        self._goal = None
        self._is_exploring = self._node_bridge.configuration.explore

    def _begin_errand(self, request: NavigateSafely.Goal) -> End | None:
        """Take an errand of the action; return why it cannot be taken."""
        strategy = request.strategy or self._bridge.configuration.strategy
        if strategy not in AVAILABLE:
            return End(ErrorCode.INVALID_STRATEGY,
                       f'unknown strategy {strategy!r}; available: {sorted(AVAILABLE)}')
        try:
            goal = None if request.explore else conversions.point_of(request.goal, self._frame)
        except MessageError as problem:
            return End(ErrorCode.INVALID_FRAME, str(problem))
        if self._planner is not None:
            self._planner.reconfigure(
                replace(self._bridge.configuration, strategy=strategy))
        self._set_goal(goal)
        return None

    def _cycle(self) -> None:
        """Plan on the newest map that is whole, and publish what came out."""
        newest = self._maps.pair()
        now = self._now()
        if newest is not None and newest.grid != self._grid:
            self._grid = newest.grid
            # A map that has grown is no reason to forget; one with other cells is.
            if self._planner is None or not self._planner.move(newest.grid):
                self._planner = SafePlanner(self._bridge.configuration, newest.grid)
        if newest is None or self._planner is None:
            return
        settings = self._node_bridge.configuration
        is_stale = now - self._pose_time > settings.odometry_age_limit
        if self._goal is None and not self._is_exploring:
            plan = self._planner.idle(now)
        else:
            plan = self._planner.update(newest.mean, newest.std,
                                        None if is_stale else self._pose, self._goal, now,
                                        *self._given.masks_on(newest.grid))
        self._publish(plan, now)
        self._action.take(plan, self._trail.length, self._frame)

    def _publish(self, plan: Plan, now: float) -> None:
        """Publish the subgoal first: who reads the status then has the subgoal that it means."""
        before, self._plan = self._plan, plan
        if before is None or is_other_point(before.subgoal, plan.subgoal):
            self._publish_subgoal(plan, now)
        if before is None or is_other_region(before.region, plan.region):
            self._publish_region(plan, now)
        if before is None or not np.array_equal(before.certified, plan.certified):
            self._publish_safe_map(plan, now)
        self._frontiers.publish(frontier_message(plan, now, self._frame))
        self._markers.publish(plan_markers(plan, now, self._frame))
        self._status.publish(status_message(plan, now, self._frame))

    def _publish_subgoal(self, plan: Plan, now: float) -> None:
        if plan.subgoal is not None:
            self._subgoal.publish(conversions.pose_message(plan.subgoal, 0.0, now, self._frame))

    def _publish_region(self, plan: Plan, now: float) -> None:
        self._sequence += 1
        clearance = self._bridge.configuration.region_clearance
        self._region.publish(region_message(plan.region, clearance, self._sequence, now,
                                            self._frame))

    def _publish_safe_map(self, plan: Plan, now: float) -> None:
        if self._grid is not None:
            cells = safe_map_cells(plan, self._bridge.configuration.slip_threshold)
            self._safe_map.publish(
                conversions.occupancy_message(self._grid, cells, now, self._frame))

    def _republish(self) -> None:
        if self._plan is not None:
            now = self._now()
            self._publish_subgoal(self._plan, now)
            self._publish_region(self._plan, now)
            self._publish_safe_map(self._plan, now)

    def _report(self) -> tuple[bytes, str, dict[str, object]]:
        plan = self._plan
        if plan is None:
            return DiagnosticStatus.WARN, 'no map arrived yet', {}
        troubled = plan.state in (PlannerState.STALLED, PlannerState.LOST, PlannerState.WAITING)
        level = DiagnosticStatus.WARN if troubled else DiagnosticStatus.OK
        message = f'{plan.state.name}: {plan.cause}' if plan.cause else plan.state.name
        return level, message, {'certified area [m^2]': round(plan.certified_area, 2),
                                'frontier cells': plan.frontier_count,
                                'interval resets': plan.total_interval_resets,
                                'subgoals': plan.subgoal_count}


def main() -> None:
    """Run the node."""
    run_node(SafePlannerNode)
