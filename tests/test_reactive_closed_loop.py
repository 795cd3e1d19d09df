# SPDX-License-Identifier: Apache-2.0
"""A unicycle under the controller reaches its goals and never leaves its region."""

import math

import numpy as np
import pytest
import shapely

from psane_reactive.clearance import Border
from psane_reactive.command import Mode
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.kinematic_robot import drive_to
from psane_reactive.safety_stop import advance
from psane_reactive.sample_regions import random_points, random_snake, star_world

STEP = 0.05


@pytest.mark.parametrize('seed', range(12))
def test_all_goals_of_certified_like_regions_are_reached_inside(seed):
    random = np.random.default_rng(100 + seed)
    region = random_snake(random, int(random.integers(10, 250)), random.uniform(0.08, 0.35))
    points = random_points(random, region, 4)
    for start, goal in zip(points[::2], points[1::2], strict=True):
        controller = ReactiveController()
        drive = drive_to(controller, region, start, random.uniform(-math.pi, math.pi), goal)
        assert drive.has_arrived
        assert drive.deepest_outside <= 0.0


@pytest.mark.parametrize('seed', range(4))
def test_all_goals_among_star_shaped_holes_are_reached_inside(seed):
    random = np.random.default_rng(200 + seed)
    region = star_world(random, int(random.integers(3, 11)))
    points = random_points(random, region, 4)
    for start, goal in zip(points[::2], points[1::2], strict=True):
        drive = drive_to(ReactiveController(), region, start, 0.0, goal)
        assert drive.has_arrived
        assert drive.deepest_outside <= 0.0


@pytest.mark.parametrize('seed', range(4))
def test_the_field_alone_reaches_all_goals_too(seed):
    random = np.random.default_rng(300 + seed)
    region = random_snake(random, 100, 0.25)
    start, goal = random_points(random, region, 2)
    controller = ReactiveController(ReactiveConfiguration(steering_map='field'))
    drive = drive_to(controller, region, start, 0.0, goal)
    assert drive.has_arrived
    assert drive.deepest_outside <= 0.0
    assert controller.counts.by_map == 0


def test_a_region_that_grows_while_the_robot_moves_is_never_left():
    """The region of each moment holds the robot; the goal comes into it at last."""
    line = shapely.LineString([(1, 1), (4, 1.5), (5, 4), (2, 5), (1, 3)])
    controller = ReactiveController()
    pose, velocity, goal = (1.0, 1.0, 2.0), (0.0, 0.0), np.array((1.0, 3.0))
    turns = []
    for tick in range(3000):
        now = tick * STEP
        if tick % 20 == 0:
            known = shapely.ops.substring(line, 0.0, 1.0 + 0.12 * now)
            region = known.buffer(0.25 + 0.02 * math.sin(now))
            border = Border(region)
            before = controller.command(now)
            controller.set_region(region, now)
            reached = np.array(known.coords[-1])
            is_known = bool(np.hypot(*(reached - goal)) < 0.01)
            controller.set_subgoal(reached, False, is_known, now)
        controller.set_odometry(pose, velocity, now)
        command = controller.command(now)
        if tick % 20 == 0 and before.mode is command.mode is Mode.DRIVE:
            turns.append(abs(command.angular - before.angular))
        if command.mode is Mode.ARRIVED:
            break
        velocity = (command.linear, command.angular)
        pose = advance(*pose, *velocity, STEP)
        # The disk at the growing end may wobble by 2 cm, the robot is led back from there.
        assert border.outside_distance(pose) <= 0.021
    assert command.mode is Mode.ARRIVED
    limit = ReactiveConfiguration().angular_acceleration * STEP
    assert max(turns) <= limit + 1e-9


def test_random_subgoals_jumps_region_swaps_and_nonsense_never_lead_out():
    """The safety stop holds for any subgoal, any jump of odometry, any region."""
    random = np.random.default_rng(9)
    settings = ReactiveConfiguration()
    controller = ReactiveController(settings)
    regions = [random_snake(random, 60, 0.25) for _ in range(6)] + [star_world(random, 5)]
    borders = [Border(region) for region in regions]
    number, pose, velocity = 0, (0.0, 0.0, 0.0), (0.0, 0.0)
    nonsense = (math.nan, math.inf, 1e300, -1e9)
    for tick in range(6000):
        now = tick * STEP
        if tick % 200 == 0:
            number = int(random.integers(len(regions)))
            pose, velocity = (*random_points(random, regions[number], 1)[0],
                              random.uniform(-3.0, 3.0)), (0.0, 0.0)
            controller.set_region(regions[number], now)
        if tick % 25 == 0:
            subgoal = random.uniform(-2.0, 12.0, 2)
            if random.random() < 0.1:
                subgoal = (float(random.choice(nonsense)), 1.0)
            controller.set_subgoal(subgoal, bool(random.random() < 0.1),
                                   bool(random.random() < 0.5), now)
            controller.set_region(regions[number], now)
        if random.random() < 0.03:
            jump = (pose[0], float(random.choice(nonsense)), pose[2])
            controller.set_odometry(jump, velocity, now)
            controller.command(now)
        controller.set_odometry(pose, velocity, now)
        command = controller.command(math.nan if random.random() < 0.01 else now)
        assert abs(command.linear) <= settings.linear_limit
        assert abs(command.angular) <= settings.angular_limit
        velocity = (command.linear, command.angular)
        pose = advance(*pose, *velocity, STEP)
        assert borders[number].outside_distance(pose) <= 0.0


def test_regions_that_are_no_regions_never_raise():
    random = np.random.default_rng(10)
    for _ in range(60):
        corners = random.normal(0.0, random.choice((1e-3, 1.0, 1e3)), (random.integers(3, 30), 2))
        if random.random() < 0.3:
            corners = np.round(corners)
        controller = ReactiveController()
        controller.set_region(shapely.Polygon(corners), 0.0)
        controller.set_subgoal(corners.mean(axis=0), False, True, 0.0)
        controller.set_odometry((*corners[0], 0.0), (0.0, 0.0), 0.0)
        command = controller.command(0.0)
        assert math.isfinite(command.linear)
        assert math.isfinite(command.angular)
