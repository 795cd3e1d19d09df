# SPDX-License-Identifier: Apache-2.0
"""What the controller decides: when it stops, marches, backs out, comes back and arrives."""

import math

import numpy as np
import pytest
import shapely

from psane_reactive.clearance import Border
from psane_reactive.command import Mode
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.safety_stop import advance

ROOM = shapely.box(0.0, 0.0, 5.0, 5.0)
STILL = (0.0, 0.0)
STEP = 0.05


def steered(region=ROOM, subgoal=(4.0, 2.0), pose=(1.0, 2.0, 0.0), march=False, is_goal=True,
            now=0.0, settings=None):
    controller = ReactiveController(settings)
    controller.set_region(region, now)
    controller.set_subgoal(subgoal, march, is_goal, now)
    controller.set_odometry(pose, STILL, now)
    return controller


def run(controller, pose, seconds, now=0.0):
    """Drive a kinematic robot; return its poses and the commands."""
    poses, commands = [pose], []
    velocity = STILL
    for tick in range(round(seconds / STEP)):
        if tick % 100 == 99:
            inputs = controller.inputs
            controller.set_region(inputs.region, now)
            controller.set_subgoal(inputs.subgoal, inputs.march_wanted, inputs.subgoal_is_goal,
                                   now)
        controller.set_odometry(pose, velocity, now)
        commands.append(controller.command(now))
        velocity = (commands[-1].linear, commands[-1].angular)
        pose = advance(*pose, *velocity, STEP)
        poses.append(pose)
        now += STEP
    return np.array(poses), commands


def test_it_drives_straight_at_a_visible_subgoal():
    controller = steered(subgoal=(3.0, 2.0))
    poses, commands = run(controller, (1.0, 2.0, 0.0), 5.0)
    assert commands[20].mode is Mode.DRIVE
    assert commands[20].reason == 'straight'
    assert commands[20].linear == pytest.approx(0.3)
    assert np.abs(poses[:, 1] - 2.0).max() < 1e-6


def test_without_odometry_region_or_subgoal_it_stops_and_says_which():
    controller = ReactiveController()
    for name, give in (
            ('odometry', lambda: controller.set_odometry((1.0, 1.0, 0.0), STILL, 0.0)),
            ('region', lambda: controller.set_region(ROOM, 0.0)),
            ('subgoal', lambda: controller.set_subgoal((2.0, 1.0), False, True, 0.0))):
        command = controller.command(0.0)
        assert command.mode is Mode.STOPPED
        assert (command.linear, command.angular) == (0.0, 0.0)
        assert command.reason == f'no {name} yet'
        give()
    assert controller.command(0.0).mode is not Mode.STOPPED


@pytest.mark.parametrize(('name', 'limit'), [('odometry', 0.5), ('region', 12.0),
                                             ('subgoal', 12.0)])
def test_each_input_may_be_as_old_as_its_limit_and_no_older(name, limit):
    for age, is_old in ((limit - 0.01, False), (limit + 0.01, True)):
        controller = steered()
        if name != 'region':
            controller.set_region(ROOM, age)
        if name != 'subgoal':
            controller.set_subgoal((4.0, 2.0), False, True, age)
        if name != 'odometry':
            controller.set_odometry((1.0, 2.0, 0.0), STILL, age)
        command = controller.command(age)
        assert (command.mode is Mode.STOPPED) == is_old
        if is_old:
            assert command.linear == command.angular == 0.0
            assert name in command.reason


def test_inputs_from_far_in_the_future_are_not_steered_by():
    controller = steered(now=100.0)
    assert controller.command(1.0).mode is Mode.STOPPED
    assert controller.command(100.0).mode is not Mode.STOPPED


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_stop_it_until_good_ones_come(bad):
    controller = steered()
    controller.set_odometry((bad, 2.0, 0.0), STILL, 0.0)
    assert 'odometry' in controller.command(0.0).reason
    controller.set_odometry((1.0, 2.0, 0.0), (0.0, bad), 0.0)
    assert controller.command(0.0).mode is Mode.STOPPED
    controller.set_odometry((1.0, 2.0, 0.0), STILL, 0.0)
    controller.set_subgoal((bad, 2.0), False, True, 0.0)
    assert 'subgoal' in controller.command(0.0).reason
    controller.set_subgoal((4.0, 2.0), False, True, 0.0)
    assert 'time' in controller.command(bad).reason
    assert controller.command(0.0).mode is Mode.DRIVE


@pytest.mark.parametrize('nothing', [None, shapely.Polygon()])
def test_an_empty_region_stops_it(nothing):
    controller = steered()
    controller.set_region(nothing, 0.0)
    command = controller.command(0.0)
    assert command.mode is Mode.STOPPED
    assert 'region is empty' in command.reason


def test_a_region_that_cannot_be_used_stops_it_rather_than_leave_the_old_one():
    controller = steered()
    useless = shapely.Polygon([(0, 0), (1, 1), (2, 2)])
    for now in (0.0, 0.2):
        # Heard again, it is as useless.
        controller.set_region(useless, now)
        assert controller.command(now).mode is Mode.STOPPED


def test_at_the_goal_it_stands():
    controller = steered(subgoal=(1.05, 2.0))
    command = controller.command(0.0)
    assert command.mode is Mode.ARRIVED
    assert (command.linear, command.angular) == (0.0, 0.0)


@pytest.mark.parametrize(('distance', 'has_arrived'), [(0.099, True), (0.101, False)])
def test_arrival_is_at_the_tolerance(distance, has_arrived):
    command = steered(subgoal=(1.0 + distance, 2.0)).command(0.0)
    assert (command.mode is Mode.ARRIVED) == has_arrived


def test_arrived_it_does_not_dither_over_the_tolerance():
    controller = steered(subgoal=(1.09, 2.0))
    assert controller.command(0.0).mode is Mode.ARRIVED
    controller.set_odometry((0.97, 2.0, 0.0), STILL, 0.05)
    assert controller.command(0.05).mode is Mode.ARRIVED
    controller.set_odometry((0.85, 2.0, 0.0), STILL, 0.1)
    assert controller.command(0.1).mode is not Mode.ARRIVED


@pytest.mark.parametrize(('march', 'is_goal'), [(False, False), (True, False), (True, True)])
def test_at_a_subgoal_it_marches_in_place_and_never_stands(march, is_goal):
    controller = steered(subgoal=(1.0, 2.0), march=march, is_goal=is_goal)
    poses, commands = run(controller, (1.0, 2.0, 0.7), 8.0)
    assert all(command.mode is Mode.MARCH for command in commands)
    assert all(command.linear != 0.0 or command.angular != 0.0 for command in commands)
    assert {math.copysign(1.0, command.linear) for command in commands} == {1.0, -1.0}
    assert np.hypot(*(poses[:, :2] - poses[0, :2]).T).max() < 0.1


def test_it_marches_without_a_region_when_nothing_is_certified_yet():
    controller = steered(region=None, subgoal=None, march=True)
    poses, commands = run(controller, (1.0, 2.0, 0.7), 8.0)
    assert all(command.mode is Mode.MARCH for command in commands)
    assert np.hypot(*(poses[:, :2] - poses[0, :2]).T).max() < 0.1


def test_the_march_stays_inside_a_tiny_region():
    region = shapely.box(0.0, 0.0, 0.05, 0.05)
    controller = steered(region=region, subgoal=(0.025, 0.025), march=True)
    poses, commands = run(controller, (0.025, 0.025, 0.3), 6.0)
    assert all(region.covers(shapely.Point(pose[:2])) for pose in poses)
    assert all(command.linear != 0.0 or command.angular != 0.0 for command in commands)


def test_march_is_held_near_its_place_when_the_robot_is_pushed():
    controller = steered(march=True)
    controller.command(0.0)
    controller.set_odometry((1.1, 2.0, 0.0), STILL, 0.05)
    assert controller.command(0.05).linear < 0.0
    controller.set_odometry((0.9, 2.0, 0.0), STILL, 1.5)
    assert controller.command(1.5).linear > 0.0


def test_without_a_subgoal_it_stops():
    controller = steered(subgoal=None)
    assert 'no subgoal' in controller.command(0.0).reason


def test_it_turns_before_it_drives_to_what_is_far_aside():
    poses, commands = run(steered(pose=(2.5, 2.5, 2.0)), (2.5, 2.5, 2.0), 20.0)
    assert commands[0].mode is Mode.TURN
    turning = [command for command in commands if command.mode is Mode.TURN]
    assert all(command.linear == 0.0 for command in turning)
    assert commands[-1].mode is Mode.ARRIVED


def test_a_near_subgoal_behind_is_driven_at_backwards():
    pose = (2.5, 2.5, 0.0)
    poses, commands = run(steered(subgoal=(2.1, 2.5), pose=pose), pose, 6.0)
    assert commands[0].mode is Mode.REVERSE
    assert commands[-1].mode is Mode.ARRIVED
    assert np.abs(poses[:, 2]).max() < 0.1


def test_reversing_can_be_switched_off():
    pose = (2.5, 2.5, 0.0)
    settings = ReactiveConfiguration(reverse_reach=0.0)
    _, commands = run(steered(subgoal=(2.1, 2.5), pose=pose, settings=settings), pose, 20.0)
    assert all(command.linear >= 0.0 for command in commands)
    assert commands[-1].mode is Mode.ARRIVED


def test_it_backs_out_before_a_large_turn_when_the_nose_is_outside():
    start = (3.5, 2.5, 0.0)
    controller = steered(subgoal=(4.95, 2.5), pose=start, is_goal=False)
    poses, _ = run(controller, start, 8.0)
    there = tuple(poses[-1])
    assert there[0] > 4.8
    controller.set_subgoal((4.0, 4.5), False, True, 8.0)
    controller.set_region(ROOM, 8.0)
    poses, commands = run(controller, there, 4.0, now=8.0)
    assert commands[0].mode is Mode.BACK_OUT
    ends = next(k for k, command in enumerate(commands) if command.mode is not Mode.BACK_OUT)
    assert poses[ends][0] + 0.28 <= 5.0 + 0.12 + 0.01
    assert all(command.angular == pytest.approx(0.0, abs=0.05) for command in commands[:ends])
    assert commands[ends].mode is Mode.TURN


def test_backing_out_ends_after_its_length_and_is_not_begun_again():
    settings = ReactiveConfiguration(back_out_length=0.1)
    pose = (4.95, 2.5, 0.0)
    _, commands = run(steered(subgoal=(4.0, 4.5), pose=pose, settings=settings), pose, 6.0)
    modes = [command.mode for command in commands]
    assert modes[0] is Mode.BACK_OUT
    last = max(k for k, mode in enumerate(modes) if mode is Mode.BACK_OUT)
    assert all(mode is Mode.BACK_OUT for mode in modes[:last])
    assert last * STEP * 0.1 <= 0.1 + 0.02


def test_a_revoked_region_is_left_by_the_shortest_way_and_steered_in_again():
    pose = (4.0, 2.5, 0.5)
    controller = steered(subgoal=(4.5, 2.5), pose=pose, is_goal=False)
    controller.command(0.0)
    smaller = shapely.box(0.0, 0.0, 3.5, 5.0)
    controller.set_region(smaller, 0.05)
    poses, commands = run(controller, pose, 11.0, now=0.05)
    assert commands[0].mode is Mode.RETREAT
    outside = [smaller.distance(shapely.Point(place[:2])) for place in poses]
    assert all(after <= before + 1e-9 for before, after in zip(outside, outside[1:], strict=False))
    assert outside[-1] == 0.0
    assert max(abs(command.linear) for command in commands
               if command.mode is Mode.RETREAT) <= controller.configuration.retreat_speed + 1e-9
    assert poses[-1][1] == pytest.approx(2.5, abs=0.6)


def test_a_subgoal_outside_is_approached_as_near_as_the_region_lets_and_then_felt_for():
    controller = steered(subgoal=(6.0, 2.0))
    poses, commands = run(controller, (3.5, 2.0, 0.0), 11.0)
    assert commands[-1].mode is Mode.MARCH
    assert 'outside' in commands[-1].reason
    assert 4.8 < poses[-1][0] < 5.0


def test_a_subgoal_in_another_part_is_not_driven_at_across_the_gap():
    parts = shapely.MultiPolygon([shapely.box(0, 0, 2, 2), shapely.box(2.3, 0, 4, 2)])
    controller = steered(region=parts, subgoal=(3.0, 1.0), pose=(1.0, 1.0, 0.0))
    poses, commands = run(controller, (1.0, 1.0, 0.0), 11.0)
    assert commands[-1].mode is Mode.MARCH
    assert poses[:, 0].max() < 2.0


def test_a_deep_bay_in_a_hole_that_the_map_loses_is_left_by_the_field():
    # A hole is shrunk around its hub, so a long thin bay into it vanishes in rounding.
    bay = shapely.LineString([(3.0, 1.2), (3.0, 2.0), *[(3.0 + 7.0 * (k % 2), 2.0 + 0.8 * k / 2)
                              for k in range(1, 11)]]).buffer(0.1, cap_style='flat')
    outer = shapely.box(0.0, 0.0, 13.0, 11.0)
    hole = shapely.box(1.3, 1.3, 11.7, 9.7) - bay
    hole = max(hole.geoms, key=lambda part: part.area) if hasattr(hole, 'geoms') else hole
    region = shapely.Polygon(outer.exterior, [hole.exterior])
    deep = shapely.Point(bay.centroid.x, bay.bounds[3])
    start = shapely.ops.nearest_points(region.buffer(-0.05), deep)[0]
    pose = (start.x, start.y, 0.0)
    controller = steered(region=region, subgoal=(0.5, 0.5), pose=pose)
    controller.command(0.0)
    assert controller.counts.by_field == 1
    poses, commands = run(controller, pose, 600.0, now=0.05)
    assert commands[-1].mode is Mode.ARRIVED
    assert Border(region).outside_distances(poses[:, :2]).max() <= 0.0
    assert controller.counts.by_map > 0


def test_the_field_takes_over_when_the_robot_gets_nowhere():
    region = shapely.box(0, 0, 5, 1).union(shapely.box(4, 0, 5, 5))
    settings = ReactiveConfiguration(stall_time=5.0)
    controller = steered(region=region, subgoal=(4.5, 4.5), pose=(0.5, 0.5, 0.0),
                         settings=settings)
    for tick in range(140):
        # A robot that does not move, as if its legs spun.
        controller.set_odometry((0.5, 0.5, 0.0), STILL, tick * STEP)
        command = controller.command(tick * STEP)
        assert ('field' in command.reason) == (tick * STEP > 4.99)


def test_a_new_configuration_is_used_from_the_next_command_on():
    controller = steered()
    run(controller, (1.0, 2.0, 0.0), 2.0)
    controller.reconfigure(ReactiveConfiguration(linear_limit=0.1))
    _, commands = run(controller, (1.0, 2.0, 0.0), 1.0, now=2.0)
    assert commands[-1].mode is Mode.DRIVE
    assert all(command.linear <= 0.1 for command in commands)


@pytest.mark.parametrize('steering', ['harmonic', 'field'])
def test_both_ways_of_steering_lead_around_a_corner(steering):
    region = shapely.box(0, 0, 5, 0.6).union(shapely.box(4.4, 0, 5, 5))
    settings = ReactiveConfiguration(steering_map=steering)
    pose = (0.3, 0.3, 0.0)
    controller = steered(region=region, subgoal=(4.7, 4.7), pose=pose, settings=settings)
    _, commands = run(controller, pose, 45.0)
    assert commands[-1].mode is Mode.ARRIVED


def test_the_same_inputs_give_the_same_commands():
    region = shapely.Polygon(ROOM.exterior, [shapely.box(1.5, 1, 3, 4).exterior])
    first, second = (run(steered(region=region), (1.0, 2.0, 0.0), 10.0)[1] for _ in range(2))
    assert first == second


def test_a_region_that_says_the_same_again_builds_nothing_anew():
    region = shapely.Polygon(ROOM.exterior, [shapely.box(1.5, 1, 3, 4).exterior])
    controller = steered(region=region)
    run(controller, (1.0, 2.0, 0.0), 1.0)
    controller.set_region(shapely.Polygon(region), 1.0)
    run(controller, (1.0, 2.0, 0.0), 1.0, now=1.0)
    assert controller.counts.maps_built == 1
