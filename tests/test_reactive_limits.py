# SPDX-License-Identifier: Apache-2.0
"""No command exceeds what the legs can do, whatever is asked for."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from psane_mapping.errors import ParameterError
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.limits import Velocity, limited, rate_limited, walkable, wrap

SETTINGS = ReactiveConfiguration()
TIGHT = ReactiveConfiguration(sweep_limit=1.0)
ANY = st.floats(allow_nan=True, allow_infinity=True)
ROUNDING = 1e-12


@given(ANY, ANY, st.sampled_from([SETTINGS, TIGHT]))
def test_any_velocity_is_limited_alone_and_together(linear, angular, settings):
    result = limited(Velocity(linear, angular), settings)
    assert abs(result.linear) <= settings.linear_limit
    assert abs(result.angular) <= settings.angular_limit
    sweep = (settings.sweep_per_speed * abs(result.linear)
             + settings.sweep_per_yaw_rate * abs(result.angular))
    assert sweep <= settings.sweep_limit + ROUNDING


@given(st.floats(-0.3, 0.3), st.floats(-0.4, 0.4))
def test_joint_limit_keeps_the_curvature(linear, angular):
    result = limited(Velocity(linear, angular), TIGHT)
    assert result.linear * angular == pytest.approx(result.angular * linear, abs=1e-12)


def test_a_velocity_within_the_limits_is_left_alone():
    assert limited(Velocity(0.2, 0.1), SETTINGS) == Velocity(0.2, 0.1)


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_a_velocity_that_is_not_finite_becomes_standstill(bad):
    assert limited(Velocity(bad, 0.1), SETTINGS) == Velocity(0.0, 0.0)
    assert limited(Velocity(0.1, bad), SETTINGS) == Velocity(0.0, 0.0)


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1), st.floats(0, 0.2))
def test_no_step_is_larger_than_the_accelerations_allow(v, w, last_v, last_w, step):
    result = rate_limited(Velocity(v, w), Velocity(last_v, last_w), step, SETTINGS)
    assert abs(result.linear - last_v) <= SETTINGS.linear_acceleration * step + ROUNDING
    assert abs(result.angular - last_w) <= SETTINGS.angular_acceleration * step + ROUNDING


@given(st.floats(-50.0, 50.0))
def test_a_wrapped_angle_is_the_same_angle_within_half_a_turn(angle):
    wrapped = wrap(angle)
    assert -math.pi <= wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.parametrize(('name', 'value'), [
    ('linear_limit', -0.1), ('steering_map', 'straight'), ('turn_until', 1.5), ('slowest', 0.4),
    ('mesh_edge', math.nan), ('mesh_size', 2.5)])
def test_a_bad_parameter_is_refused_by_its_name(name, value):
    with pytest.raises(ParameterError, match=name):
        ReactiveConfiguration(**{name: value})


@given(st.floats(-0.3, 0.3), st.floats(-0.4, 0.4))
def test_what_is_walked_is_never_a_tighter_arc_and_turns_in_place_stay(linear, angular):
    settings = ReactiveConfiguration()
    walked = walkable(Velocity(linear, angular), settings)
    assert walked.linear == linear
    if linear == 0.0:
        assert walked.angular == angular
    else:
        assert abs(walked.angular) <= abs(linear) / settings.arc_radius + 1e-12
        assert walked.angular * angular >= 0.0
