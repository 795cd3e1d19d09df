# SPDX-License-Identifier: Apache-2.0
"""Geometry of the robot and of its half-circle legs."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.errors import ParameterError, ShapeError
from psane_mapping.leg import LEG_NAMES, SIDE, TRIPOD, RobotModel, elements_in_base
from psane_mapping.leg_response import LegMotion, leg_response

law = settings(deadline=None, derandomize=True, max_examples=40)
ROBOT = RobotModel()
angles = st.floats(-math.pi, math.pi)


def motion(**changes):
    """Return a leg that is pressed straight down at 0.1 m/s from the moment it touches."""
    count = 80
    time = 0.005 * np.arange(count)
    values = {'time': time, 'angle': np.zeros(count), 'speed': np.zeros(count),
              'height': 0.18 - 0.1 * time, 'rotation': np.tile(np.eye(3), (count, 1, 1)),
              'velocity': np.tile([0.0, 0.0, -0.1], (count, 1)),
              'angular_velocity': np.zeros((count, 3))}
    return LegMotion(**{**values, **changes})


def test_the_reference_robot_weighs_eight_and_a_half_kilograms():
    assert ROBOT.mass == pytest.approx(8.5)


def test_hips_are_where_the_leg_names_say():
    for name, hip in zip(LEG_NAMES, ROBOT.hips, strict=True):
        side, row = name.split('_')
        assert math.copysign(1.0, hip[1]) == (1.0 if side == 'left' else -1.0)
        assert np.sign(hip[0]) == {'front': 1.0, 'middle': 0.0, 'rear': -1.0}[row]


def test_each_tripod_stands_on_both_sides():
    for tripod in (0, 1):
        legs = [leg for leg in range(6) if TRIPOD[leg] == tripod]
        assert len(legs) == 3
        assert {SIDE[leg] for leg in legs} == {0, 1}


@law
@given(angle=angles, leg=st.integers(0, 5))
def test_elements_lie_on_a_circle_through_the_hip(angle, leg):
    position, normal = elements_in_base(ROBOT, leg, angle)
    radius = ROBOT.leg_radius
    centre = ROBOT.hips[leg] + radius * np.array([-math.sin(angle), 0.0, -math.cos(angle)])
    np.testing.assert_allclose(np.linalg.norm(position - centre, axis=1), radius)
    np.testing.assert_allclose((position - centre) / radius, normal, atol=1e-12)


def test_a_leg_points_down_with_its_convex_side_to_the_rear_and_swings_back_as_it_turns():
    position, _ = elements_in_base(ROBOT, 0, 0.0)
    relative = position - ROBOT.hips[0]
    assert (relative[:, 0] < 0.0).all()
    assert relative[-1, 2] == pytest.approx(-2.0 * ROBOT.leg_radius, abs=1e-3)
    turned, _ = elements_in_base(ROBOT, 0, 0.3)
    assert turned[-1, 0] < position[-1, 0]


def test_the_elements_of_a_leg_add_up_to_its_face():
    face = math.pi * ROBOT.leg_radius * ROBOT.leg_width
    assert ROBOT.leg.area.sum() == pytest.approx(face)
    assert ROBOT.belly.area.sum() == pytest.approx(ROBOT.body_length * ROBOT.body_width)


def test_surfaces_cannot_be_written_to():
    with pytest.raises(ValueError, match='read-only'):
        ROBOT.leg.position[0, 0] = 1.0
    with pytest.raises(ValueError, match='read-only'):
        ROBOT.hips[0, 0] = 1.0


def test_a_robot_without_length_is_refused():
    with pytest.raises(ParameterError, match='body_length'):
        RobotModel(body_length=0.0)


def test_a_leg_above_the_ground_feels_nothing():
    response = leg_response(ROBOT, 0, motion(height=np.full(80, 0.2)))
    assert not response.force.any()
    assert not response.moment.any()
    assert not response.depth.any()


def test_a_leg_that_is_pressed_down_is_pushed_up_more_the_deeper_it_is():
    response = leg_response(ROBOT, 1, motion())
    touching = response.depth > 0.003
    assert touching.sum() > 10
    assert (np.diff(response.force[touching, 2]) > 0.0).all()
    np.testing.assert_allclose(response.depth[touching],
                               -(motion().height[touching] - 0.175), atol=1e-3)


@law
@given(yaw=angles, leg=st.integers(0, 5))
def test_the_response_does_not_depend_on_the_heading(yaw, leg):
    cosine, sine = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    straight = leg_response(ROBOT, leg, motion(velocity=np.tile([0.1, 0.05, -0.1], (80, 1))))
    turned = leg_response(ROBOT, leg, motion(
        rotation=np.tile(turn, (80, 1, 1)),
        velocity=np.tile(turn @ [0.1, 0.05, -0.1], (80, 1))))
    np.testing.assert_allclose(turned.force, straight.force, atol=1e-9)
    np.testing.assert_allclose(turned.moment, straight.moment, atol=1e-9)
    np.testing.assert_allclose(turned.place, straight.place @ turn.T, atol=1e-9)


def test_the_moment_is_that_of_the_force_about_the_hip():
    response = leg_response(ROBOT, 0, motion())
    deep = response.depth > 0.01
    lever = response.place - ROBOT.hips[0]
    about_hip = lever[:, 2] * response.force[:, 0] - lever[:, 0] * response.force[:, 2]
    # The weighted place is not exactly the centre of action; the sign and the size must agree.
    np.testing.assert_allclose(response.moment[deep], about_hip[deep], rtol=0.15, atol=0.05)


def test_a_motion_with_a_missing_sample_or_a_nan_is_refused():
    with pytest.raises(ShapeError, match='angle'):
        motion(angle=np.zeros(79))
    with pytest.raises(ShapeError, match='height'):
        motion(height=np.full(80, np.nan))
