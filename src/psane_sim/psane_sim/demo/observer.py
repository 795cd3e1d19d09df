# SPDX-License-Identifier: Apache-2.0
"""Listens to the graph for the demo: for the record, the score and the progress line."""

import math

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from psane_mapping import conversions
from psane_mapping.grid import FloatArray
from psane_mapping.map_cells import slip_of_cells
from psane_mapping.quality_of_service import CONTACTS, DEFAULT, LATCHED, ODOMETRY_INPUT
from psane_mapping.running import Intake
from psane_msgs.msg import FrontierArray, MapScale, PlannerStatus, SafeRegion, TerrainSample
from psane_planner.conversions import CERTIFIED
from psane_planner.status import PlannerState
from psane_reactive.conversions import region_of
from psane_sim.progress import Progress
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.scoring import Scorer

FRAME, PLANNER = 'map', 'safe_planner'
REFUSALS = ('rejected', 'stances dropped')
"""How values of diagnostics begin that count stances that were not used, for a reason."""

SHARED = ('slip/mean', 'slip/std', 'map_scale', 'terrain_samples')
"""Topics of the one mapper of several robots."""


def shared_map_arguments() -> list[str]:
    """Return the ROS arguments by which a node in a namespace hears the map of the root."""
    return ['--ros-args', *(word for topic in SHARED for word in ('-r', f'{topic}:=/{topic}'))]


class Observer(Node):
    """Keeps a run's record up to date.

    Parameters
    ----------
    record : RunRecord
    scorer : Scorer
        Is told each new safe map.
    robot : str
        Namespace of the robot that is listened to; the maps are then those of the root.
    """

    def __init__(self, record: RunRecord, scorer: Scorer, robot: str = '') -> None:
        super().__init__('demo', namespace=robot,
                         cli_args=shared_map_arguments() if robot else None)
        self._record = record
        self._scorer = scorer
        self._std_scale = math.nan
        self.status: PlannerStatus | None = None
        self.time = 0.0
        self.speed = math.nan
        self.position: FloatArray | None = None
        self._goal = self.create_publisher(PoseStamped, 'goal_pose', DEFAULT)
        intake = Intake(self)
        intake.subscribe(Clock, '/clock', self._take_clock, DEFAULT)
        intake.subscribe(Odometry, 'odom', self._take_odometry, ODOMETRY_INPUT)
        intake.subscribe(PlannerStatus, 'planner_status', self._take_status, LATCHED)
        intake.subscribe(OccupancyGrid, 'safe_map', self._take_safe_map, LATCHED)
        intake.subscribe(MapScale, 'map_scale', self._take_scale, LATCHED)
        intake.subscribe(OccupancyGrid, 'slip/mean', self._take_mean, LATCHED)
        intake.subscribe(OccupancyGrid, 'slip/std', self._take_std, LATCHED)
        intake.subscribe(TerrainSample, 'terrain_samples', self._take_sample, CONTACTS)
        intake.subscribe(FrontierArray, 'frontiers', self._take_frontier, LATCHED)
        intake.subscribe(SafeRegion, 'safe_region', self._take_region, LATCHED)
        intake.subscribe(PoseStamped, 'subgoal', self._take_subgoal, LATCHED)
        intake.subscribe(DiagnosticArray, '/diagnostics', self._take_diagnostics, DEFAULT)

    def is_heard(self) -> bool:
        """Tell whether the planner listens for goals; others may, such as a recorder."""
        return any(info.node_name == PLANNER
                   for info in self.get_subscriptions_info_by_topic(self._goal.topic_name))

    def send_goal(self, goal: tuple[float, float]) -> None:
        """Publish the goal (x, y), map frame [m]."""
        self._goal.publish(conversions.pose_message(np.array(goal), 0.0, self.time, FRAME))

    def present_nodes(self) -> set[str]:
        """Return the names of the nodes on the graph."""
        return set(self.get_node_names())

    def starting(self, missing: list[str]) -> Progress:
        """Return what the progress line shows while nodes are still missing."""
        return Progress(time=0.0, distance=None, area=0.0, contacts=0, state='STARTING',
                        cause=f'waiting for {", ".join(missing)}')

    def progress(self) -> Progress:
        """Return what the progress line shows."""
        status, contacts = self.status, len(self._record.contacts)
        if status is None:
            return Progress(time=self.time, distance=None, area=0.0, contacts=contacts,
                            state='WAITING')
        distance = None if math.isnan(status.distance_to_goal) else status.distance_to_goal
        return Progress(time=self.time, distance=distance, area=status.certified_area,
                        contacts=contacts, state=PlannerState(status.state).name,
                        cause=status.cause)

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            for entry in status.values:
                kind, _, reason = entry.key.partition(': ')
                if kind in REFUSALS and entry.value.isdecimal():
                    self._record.refused[reason] = int(entry.value)

    def _take_clock(self, message: Clock) -> None:
        self.time = conversions.seconds(message.clock)

    def _take_odometry(self, message: Odometry) -> None:
        velocity = message.twist.twist.linear
        pose = message.pose.pose.position
        self.position = np.array([pose.x, pose.y])
        self.speed = math.hypot(velocity.x, velocity.y)

    def _take_status(self, message: PlannerStatus) -> None:
        self.status = message
        self._record.progress.append((conversions.seconds(message.header.stamp),
                                      message.distance_to_goal, message.certified_area))

    def _take_safe_map(self, message: OccupancyGrid) -> None:
        _, cells = conversions.cells_of(message, FRAME)
        self._record.certified = cells == CERTIFIED
        self._scorer.certified(self._record.certified)

    def _take_scale(self, message: MapScale) -> None:
        self._std_scale = conversions.std_scale_of(message, FRAME)

    def _take_mean(self, message: OccupancyGrid) -> None:
        _, cells = conversions.cells_of(message, FRAME)
        self._record.slip_mean, _ = slip_of_cells(cells, cells, 1.0)

    def _take_std(self, message: OccupancyGrid) -> None:
        _, cells = conversions.cells_of(message, FRAME)
        _, self._record.slip_std = slip_of_cells(cells, cells, self._std_scale)

    def _take_sample(self, message: TerrainSample) -> None:
        self._record.contacts.append((conversions.seconds(message.header.stamp), message.point.x,
                                      message.point.y, message.slip))

    def _take_frontier(self, message: FrontierArray) -> None:
        if message.points:
            self._record.frontier = np.array([(point.x, point.y) for point in message.points])

    def _take_region(self, message: SafeRegion) -> None:
        self._record.region = region_of(message, FRAME)

    def _take_subgoal(self, message: PoseStamped) -> None:
        self._record.note_subgoal(conversions.seconds(message.header.stamp),
                                  conversions.point_of(message, FRAME))
