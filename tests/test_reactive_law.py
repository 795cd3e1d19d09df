# SPDX-License-Identifier: Apache-2.0
"""The law: arcs that the gait can walk, backwards only to the goal, a steady direction."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from psane_reactive.clearance import Border
from psane_reactive.command import Mode
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.law import Pose, UnicycleLaw
from psane_reactive.safety_stop import advance
from psane_reactive.sample_regions import star_world
from psane_reactive.steady_direction import SteadyDirection

SETTINGS = ReactiveConfiguration()
ROOM = shapely.box(0.0, 0.0, 6.0, 6.0)
BORDER = Border(ROOM)
STEP = 0.05
STILL = (0.0, 0.0)
inside = st.floats(0.1, 5.9)
angle = st.floats(-3.1, 3.1)


@given(inside, inside, angle, inside, inside)
def test_forward_arcs_are_never_tighter_than_the_gait_walks(x, y, yaw, target_x, target_y):
    law = UnicycleLaw(SETTINGS)
    pose, target = Pose(x, y, yaw), np.array((target_x, target_y))
    left = math.hypot(x - target_x, y - target_y)
    linear, angular = law.velocity(pose, target, left, BORDER, may_reverse=True)
    if linear > 0.0:
        assert abs(angular) <= linear / SETTINGS.arc_radius + 1e-12
    if linear == 0.0:
        assert law.is_turning


def test_a_moderate_heading_error_is_turned_while_driving_where_there_is_room():
    for error, turns in ((0.5, False), (1.1, False), (1.3, True)):
        law = UnicycleLaw(SETTINGS)
        target = np.array((3.0 + math.cos(error), 3.0 + math.sin(error)))
        velocity = law.velocity(Pose(3.0, 3.0, 0.0), target, 1.0, BORDER, False)
        assert law.is_turning == turns
        assert (velocity.linear == 0.0) == turns


def test_the_same_error_is_turned_in_place_before_an_edge():
    target = np.array((5.95 + 0.01, 3.0 + 1.0))
    for x, turns in ((4.0, False), (5.95, True)):
        law = UnicycleLaw(SETTINGS)
        law.velocity(Pose(x, 3.0, 0.6), target + (x - 5.95, 0.0), 1.0, BORDER, False)
        assert law.is_turning == turns


@pytest.mark.parametrize(('may_reverse', 'sign'), [(True, -1.0), (False, 1.0)])
def test_only_the_goal_is_driven_at_backwards_not_a_subgoal(may_reverse, sign):
    controller = ReactiveController()
    controller.set_region(ROOM, 0.0)
    controller.set_subgoal((2.6, 3.0), False, may_reverse, 0.0)
    pose, velocity, speeds = (3.0, 3.0, 0.0), STILL, []
    for tick in range(120):
        controller.set_odometry(pose, velocity, tick * STEP)
        command = controller.command(tick * STEP)
        velocity = (command.linear, command.angular)
        speeds.append(command.linear)
        pose = advance(*pose, *velocity, STEP)
    assert (min(speeds) < -0.05) == may_reverse
    assert controller.inputs.subgoal_is_goal == may_reverse


def test_a_chain_of_subgoals_behind_never_makes_the_robot_walk_backwards():
    controller = ReactiveController()
    controller.set_region(ROOM, 0.0)
    pose, velocity, backwards = (4.0, 3.0, 0.0), STILL, 0
    for tick in range(600):
        now = tick * STEP
        if tick % 4 == 0:
            ahead = (max(pose[0] - 0.35, 0.5), 3.0 + 0.05 * math.sin(now))
            controller.set_subgoal(ahead, False, False, now)
            controller.set_region(ROOM, now)
        controller.set_odometry(pose, velocity, now)
        command = controller.command(now)
        backwards += command.mode in (Mode.DRIVE, Mode.REVERSE) and command.linear < 0.0
        velocity = (command.linear, command.angular)
        pose = advance(*pose, *velocity, STEP)
    assert backwards == 0
    assert pose[0] < 1.2


@given(st.lists(angle, min_size=2, max_size=30))
def test_the_direction_of_travel_never_turns_faster_than_its_rate(directions):
    steady, pose = SteadyDirection(SETTINGS), Pose(1.0, 2.0, 0.3)
    last = None
    for number, wanted in enumerate(directions):
        target = pose.position + 0.7 * np.array((math.cos(wanted), math.sin(wanted)))
        away = steady.toward(pose, target, number * STEP) - pose.position
        assert math.hypot(*away) == pytest.approx(0.7)
        now = math.atan2(away[1], away[0])
        if last is not None:
            turn = abs((now - last + math.pi) % (2.0 * math.pi) - math.pi)
            assert turn <= SETTINGS.direction_rate * STEP + 1e-9
        last = now


def test_the_direction_of_travel_arrives_at_a_target_that_stays():
    steady, pose = SteadyDirection(SETTINGS), Pose(0.0, 0.0, 0.0)
    steady.toward(pose, np.array((1.0, 0.0)), 0.0)
    for tick in range(1, 40):
        found = steady.toward(pose, np.array((0.0, 1.0)), tick * STEP)
    assert found == pytest.approx((0.0, 1.0), abs=1e-3)


def test_after_it_was_led_back_it_makes_room_before_even_a_small_turn():
    settings = ReactiveConfiguration(turn_first_above=0.8, turn_until=0.25)
    pose, velocity = (6.05, 3.0, 0.0), STILL
    controller = ReactiveController(settings)
    modes = []
    for tick in range(160):
        now = tick * STEP
        if tick % 20 == 0:
            controller.set_region(ROOM, now)
            controller.set_subgoal((5.9, 4.5), False, False, now)
        controller.set_odometry(pose, velocity, now)
        command = controller.command(now)
        modes.append(command.mode)
        velocity = (command.linear, command.angular)
        before, pose = pose, advance(*pose, *velocity, STEP)
        if command.mode is Mode.TURN:
            # The nose is over the edge by no more than is allowed for a turn.
            assert before[0] + settings.nose * math.cos(before[2]) <= 6.0 + 0.12 + 1e-6
    assert modes[0] is Mode.RETREAT
    assert Mode.BACK_OUT in modes
    assert Mode.TURN in modes


def test_a_robot_that_gets_nowhere_by_the_field_either_says_so():
    region = shapely.box(0, 0, 5, 1).union(shapely.box(4, 0, 5, 5))
    controller = ReactiveController(ReactiveConfiguration(stall_time=5.0))
    controller.set_subgoal((4.5, 4.5), False, True, 0.0)
    modes = {}
    for tick in range(320):
        now = tick * STEP
        if tick % 50 == 0:
            controller.set_region(region, now)
            controller.set_subgoal((4.5, 4.5), False, True, now)
        controller.set_odometry((0.5, 0.5, 0.0), STILL, now)
        command = controller.command(now)
        modes[now] = command.mode
        if command.mode is Mode.STUCK:
            assert 'getting nowhere' in command.reason
    assert modes[9.0] is Mode.DRIVE
    assert modes[11.0] is Mode.STUCK


@pytest.mark.parametrize('seed', range(4))
def test_a_holonomic_robot_keeps_its_yaw_its_limits_and_its_region(seed):
    random = np.random.default_rng(seed)
    region = star_world(random, 8)
    border = Border(region)
    controller = ReactiveController(ReactiveConfiguration(holonomic=True))
    place, goal = np.array((0.3, 0.3)), np.array((9.7, 9.7))
    last = np.zeros(2)
    for tick in range(2000):
        now = tick * STEP
        if tick % 100 == 0:
            controller.set_region(region, now)
            controller.set_subgoal(goal, False, True, now)
        controller.set_odometry((*place, 1.0), STILL, now)
        command = controller.command(now)
        if command.mode is Mode.ARRIVED:
            break
        assert command.angular == 0.0
        body = np.array((command.linear, command.lateral))
        assert np.hypot(*body) <= SETTINGS.linear_limit + 1e-9
        turned = np.array(((math.cos(1.0), -math.sin(1.0)), (math.sin(1.0), math.cos(1.0)))) @ body
        if np.hypot(*turned) > 0.0:
            assert np.hypot(*(turned - last)) <= SETTINGS.linear_acceleration * 0.2 + 1e-9
        last = turned
        place = place + STEP * turned
        assert border.outside_distance(place) <= 0.0
    assert command.mode is Mode.ARRIVED
