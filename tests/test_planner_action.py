# SPDX-License-Identifier: Apache-2.0
"""The action `navigate_safely` on a real graph: feedback, success, refusal, preemption, cancel."""

import math
import time

import numpy as np
import pytest
import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.action import ActionClient

from psane_mapping import conversions
from psane_mapping.grid import Grid
from psane_mapping.quality_of_service import LATCHED, ODOMETRY
from psane_msgs.action import NavigateSafely
from psane_msgs.msg import MapScale
from psane_planner.navigation import ErrorCode
from psane_sim import conversions as sim_conversions
from psane_sim.touch.sensing import OdometrySample

GRID = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1)


class Client:
    """A scripted robot on firm ground around (3, 3), and a client of the action."""

    def __init__(self, probe):
        self.probe = probe
        node = probe.node
        self.pose = (3.0, 3.0)
        self.feedback = []
        self._maps = {name: node.create_publisher(OccupancyGrid, name, LATCHED)
                      for name in ('slip/mean', 'slip/std')}
        self._scale = node.create_publisher(MapScale, 'map_scale', LATCHED)
        self._odometry = node.create_publisher(Odometry, 'odom', ODOMETRY)
        self._timer = node.create_timer(0.05, self._tick)
        self.client = ActionClient(node, NavigateSafely, 'navigate_safely')
        self._publish_maps()

    def _publish_maps(self):
        away = np.hypot(*(GRID.points - (3.0, 3.0)).T).reshape(GRID.shape)
        now = time.time()
        scale = 0.005
        cells = {'slip/mean': np.where(away < 1.5, 10, 0),
                 'slip/std': np.where(away < 1.5, 0.03 / scale, 0.5 / scale)}
        for name, values in cells.items():
            self._maps[name].publish(conversions.occupancy_message(
                GRID, values.astype(np.int8), now, 'map'))
        message = MapScale(std_scale=scale)
        message.header.frame_id = 'map'
        self._scale.publish(message)

    def _tick(self):
        sample = OdometrySample(time.time(), np.array([*self.pose, 0.1]),
                                np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3))
        self._odometry.publish(sim_conversions.odometry_message(sample, 'odom', 'base_link'))

    def send(self, x=0.0, y=0.0, frame='map', **details):
        goal = NavigateSafely.Goal(**details)
        goal.goal = PoseStamped()
        goal.goal.header.frame_id = frame
        goal.goal.pose.position.x, goal.goal.pose.position.y = x, y
        goal.goal.pose.orientation.w = 1.0
        future = self.client.send_goal_async(
            goal, feedback_callback=lambda message: self.feedback.append(message.feedback))
        self.wait(future)
        handle = future.result()
        assert handle.accepted
        return handle, handle.get_result_async()

    def wait(self, future):
        self.probe.until(future.done)
        return future.result()


@pytest.fixture
def client(probe, start_node):
    start_node('psane_planner', 'safe_planner')
    made = Client(probe)
    probe.until(made.client.server_is_ready)
    return made


def test_an_errand_has_feedback_and_ends_when_the_goal_is_reached(client):
    _, result = client.send(4.0, 3.0)
    client.probe.until(lambda: len(client.feedback) >= 2)
    last = client.feedback[-1]
    assert last.distance_to_goal == pytest.approx(1.0, abs=1e-6) and last.certified_area > 3.0
    assert 0.0 < last.coverage < 0.5 and last.subgoal.header.frame_id == 'map'
    client.pose = (3.9, 3.0)
    answer = client.wait(result)
    assert answer.status == GoalStatus.STATUS_SUCCEEDED
    assert answer.result.error_code == ErrorCode.NONE and answer.result.time_s > 0.0
    assert answer.result.path_length == pytest.approx(0.9, abs=0.15)


@pytest.mark.parametrize(('request_', 'code', 'word'), [
    ({'x': 20.0, 'y': 3.0}, ErrorCode.INVALID_GOAL, 'nearest'),
    ({'x': 4.0, 'y': 3.0, 'frame': 'moon'}, ErrorCode.INVALID_FRAME, 'moon'),
    ({'x': 4.0, 'y': 3.0, 'strategy': 'luck'}, ErrorCode.INVALID_STRATEGY, 'psane_geodesic')])
def test_an_errand_that_cannot_be_done_is_aborted_with_a_code_and_words(client, request_, code,
                                                                       word):
    answer = client.wait(client.send(**request_)[1])
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert answer.result.error_code == code and word in answer.result.message


def test_a_newer_errand_takes_the_place_of_the_older_and_can_be_cancelled(client):
    _, first = client.send(4.0, 3.0)
    handle, second = client.send(3.0, 4.0)
    answer = client.wait(first)
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert answer.result.error_code == ErrorCode.PREEMPTED
    client.feedback.clear()
    client.probe.until(lambda: client.feedback)
    assert client.feedback[-1].distance_to_goal == pytest.approx(1.0, abs=1e-6)
    client.wait(handle.cancel_goal_async())
    assert client.wait(second).status == GoalStatus.STATUS_CANCELED


def test_exploring_has_no_distance_and_another_strategy_can_be_asked_for(client):
    handle, result = client.send(explore=True, strategy='psane')
    client.probe.until(lambda: len(client.feedback) >= 2)
    assert math.isnan(client.feedback[-1].distance_to_goal)
    client.wait(handle.cancel_goal_async())
    assert client.wait(result).status == GoalStatus.STATUS_CANCELED
    assert rclpy.ok()
