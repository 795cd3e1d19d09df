# SPDX-License-Identifier: Apache-2.0
"""A robot that leans: it leaves soft ground straight, and lies still when it has fallen over."""

import math

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from psane_reactive.balance import Balance, Tilt
from psane_reactive.command import Mode
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.limits import STANDSTILL, Velocity
from psane_reactive.safety_stop import SafetyStop

ROOM = shapely.box(0.0, 0.0, 4.0, 4.0)
LEANING, NOSE_DOWN, NOSE_UP = Tilt(0.0, 0.5), Tilt(0.5, 0.0), Tilt(-0.5, 0.0)
angles = st.floats(-1.5, 1.5)


def controller_in(room=ROOM, pose=(2.0, 2.0, 0.0), subgoal=(0.5, 2.0), tilt=None):
    made = ReactiveController()
    made.set_region(room, 0.0)
    made.set_subgoal(subgoal, False, False, 0.0)
    made.set_odometry(pose, (0.0, 0.0), 0.0, *(() if tilt is None else (tilt,)))
    return made


def settled(made, ticks=40, pose=(2.0, 2.0, 0.0), tilt=None):
    for tick in range(1, ticks):
        made.set_odometry(pose, (0.0, 0.0), 0.05 * tick, *(() if tilt is None else (tilt,)))
        command = made.command(0.05 * tick)
    return command


@given(angles, angles, st.floats(-3.0, 3.0), st.floats(0.1, 10.0))
def test_tilt_is_that_of_the_rotation_whatever_the_heading(pitch, roll, yaw, length):
    turned = Rotation.from_euler('ZYX', (yaw, pitch, roll))
    tilt = Tilt.of_quaternion(*(length * turned.as_quat()))
    assert (tilt.pitch, tilt.roll) == pytest.approx((pitch, roll), abs=1e-6)
    upward = turned.apply((0.0, 0.0, 1.0))
    assert math.cos(tilt.lean) == pytest.approx(upward[2], abs=1e-6)


@given(st.floats(-3.0, 3.0))
def test_the_low_end_has_the_sign_of_its_angle(yaw):
    heading = Rotation.from_euler('z', yaw)
    nose = (heading * Rotation.from_euler('y', 0.3)).apply((1.0, 0.0, 0.0))
    right = (heading * Rotation.from_euler('x', 0.3)).apply((0.0, -1.0, 0.0))
    assert nose[2] < 0.0 and right[2] < 0.0


@pytest.mark.parametrize('quaternion', [(0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0),
                                        (math.inf, 0.0, 0.0, 1.0)])
def test_an_attitude_that_is_none_counts_as_upright(quaternion):
    balance = Balance(ReactiveConfiguration(), SafetyStop(ReactiveConfiguration()))
    balance.take(Tilt(0.0, 3.0))
    assert balance.objection() is not None
    balance.take(Tilt.of_quaternion(*quaternion))
    assert balance.objection() is None


def test_an_upright_robot_turns_towards_a_subgoal_behind_it():
    command = settled(controller_in())
    assert command.mode is Mode.TURN and command.linear == 0.0 and command.angular != 0.0


@pytest.mark.parametrize(('tilt', 'sense'), [(NOSE_DOWN, -1.0), (NOSE_UP, 1.0), (LEANING, 1.0)])
def test_a_leaning_robot_walks_away_from_its_low_end_instead_of_turning(tilt, sense):
    command = settled(controller_in(tilt=tilt), tilt=tilt)
    assert command.angular == 0.0
    assert command.linear == pytest.approx(sense * ReactiveConfiguration().retreat_speed)
    assert 'leans' in command.reason


def test_a_leaning_robot_takes_the_other_way_where_one_is_barred():
    pose = (3.99, 2.0, 0.0)
    command = settled(controller_in(pose=pose, tilt=NOSE_UP), pose=pose, tilt=NOSE_UP)
    assert command.linear < 0.0 and command.angular == 0.0


def test_a_leaning_robot_with_no_straight_way_turns_as_before():
    room = shapely.box(1.98, 0.0, 2.02, 4.0)
    command = settled(controller_in(room, subgoal=(2.0, 3.5), tilt=LEANING), tilt=LEANING)
    assert command.linear == 0.0 and command.angular > 0.0
    assert 'leans' not in command.reason


def test_a_leaning_robot_that_walks_forward_is_left_alone():
    command = settled(controller_in(subgoal=(3.5, 2.3), tilt=LEANING), tilt=LEANING)
    assert command.mode is Mode.DRIVE and command.linear > 0.0 and command.angular > 0.0


def test_a_robot_that_has_fallen_over_keeps_still_and_says_so_until_it_stands_again():
    made = controller_in(tilt=Tilt(0.0, 3.0))
    command = settled(made, tilt=Tilt(0.0, 3.0))
    assert (command.linear, command.angular) == (0.0, 0.0) and command.mode is Mode.STOPPED
    assert 'fallen over' in command.reason and 'set it upright' in command.reason
    assert settled(made, tilt=Tilt()).mode is Mode.TURN


@given(angles, angles, st.floats(-0.3, 0.3), st.floats(-0.4, 0.4),
       st.tuples(st.floats(0.05, 3.95), st.floats(0.05, 3.95), st.floats(-3.0, 3.0)))
def test_the_way_out_is_straight_and_passes_the_safety_stop(pitch, roll, linear, angular, place):
    configuration = ReactiveConfiguration()
    made = controller_in(pose=place)
    made.command(0.0)
    border, pose = made._guide.border, made.inputs.pose
    safety = SafetyStop(configuration)
    balance = Balance(configuration, safety)
    balance.take(Tilt(pitch, roll))
    out = balance.way_out(border, pose, STANDSTILL, Velocity(linear, angular))
    if out is None:
        return
    assert Tilt(pitch, roll).lean > configuration.lean_limit
    assert abs(out.linear) == configuration.retreat_speed or out == (0.0, angular)
    assert out.linear * out.angular == 0.0 and safety.is_safe(border, pose, STANDSTILL, out)
    assert linear <= 0.0
    assert out.linear >= 0.0 or Tilt(pitch, roll).lean <= configuration.backward_limit


def way_out(tilt, wanted, pose=(2.0, 2.0, 0.0)):
    made = controller_in(pose=pose)
    made.command(0.0)
    balance = Balance(made.configuration, SafetyStop(made.configuration))
    balance.take(tilt)
    return balance.way_out(made._guide.border, made.inputs.pose, STANDSTILL, wanted)


@pytest.mark.parametrize('wanted', [Velocity(-0.2, 0.0), Velocity(-0.1, 0.3)])
def test_a_robot_that_leans_far_is_not_levered_over_by_walking_backward(wanted):
    speed = ReactiveConfiguration().retreat_speed
    assert way_out(Tilt(-0.6, 0.2), wanted) == Velocity(speed, 0.0)
    barred = way_out(Tilt(-0.6, 0.2), wanted, (3.99, 2.0, 0.0))
    assert barred == Velocity(0.0, wanted.angular)


def test_a_robot_that_leans_far_does_not_turn_by_walking_backward():
    assert way_out(Tilt(0.7, 0.0), Velocity(0.0, 0.4)).linear > 0.0
    assert way_out(Tilt(0.7, 0.0), Velocity(0.0, 0.4), (3.99, 2.0, 0.0)) is None


def test_a_straight_way_out_ends_and_the_turn_is_made_all_the_same():
    made = controller_in(tilt=NOSE_UP)
    way = made.configuration.lean_way
    first = settled(made, tilt=NOSE_UP)
    assert first.linear > 0.0
    there = (2.0 + way + 0.01, 2.0, 0.0)
    for tick in range(40, 60):
        made.set_odometry(there, (0.0, 0.0), 0.05 * tick, NOSE_UP)
        command = made.command(0.05 * tick)
    assert command.mode is Mode.TURN and command.linear == 0.0 and command.angular != 0.0


def test_a_jump_of_the_pose_begins_a_new_way_out():
    made = controller_in(tilt=NOSE_UP)
    assert settled(made, tilt=NOSE_UP).linear > 0.0
    command = None
    for tick in range(40, 60):
        made.set_odometry((1.2, 1.2, 0.3), (0.0, 0.0), 0.05 * tick, NOSE_UP)
        command = made.command(0.05 * tick)
    assert command.linear > 0.0 and command.angular == 0.0


def test_once_upright_again_a_robot_may_leave_straight_anew():
    configuration = ReactiveConfiguration()
    made = controller_in()
    made.command(0.0)
    balance = Balance(configuration, SafetyStop(configuration))
    turn, border = Velocity(0.0, 0.4), made._guide.border
    for tilt, goes in ((NOSE_UP, True), (Tilt(), False), (NOSE_UP, True)):
        balance.take(tilt)
        out = balance.way_out(border, made.inputs.pose, STANDSTILL, turn)
        assert (out is not None) is goes
