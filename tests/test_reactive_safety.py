# SPDX-License-Identifier: Apache-2.0
"""Safety of the steering; each test quotes the requirement that it defends."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_reactive.clearance import Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.law import Pose
from psane_reactive.limits import STANDSTILL, Velocity
from psane_reactive.retreat import Retreat
from psane_reactive.safety_stop import SafetyStop, advance
from psane_reactive.sample_regions import random_snake

SETTINGS = ReactiveConfiguration()
REGION = random_snake(np.random.default_rng(2), 80, 0.3)
BORDER = Border(REGION)
LOW_X, LOW_Y, HIGH_X, HIGH_Y = REGION.bounds
POSES = st.builds(Pose, st.floats(LOW_X - 0.2, HIGH_X + 0.2), st.floats(LOW_Y - 0.2, HIGH_Y + 0.2),
                  st.floats(-math.pi, math.pi))
VELOCITIES = st.builds(Velocity, st.floats(-0.3, 0.3), st.floats(-0.4, 0.4))
TIMES = np.linspace(0.0, SETTINGS.stop_horizon, 200)
# The check looks at eight places of an arc; between them an arc bends by under a millimetre.
SAGITTA = 1e-3
# Distances are compared with this much slack, in the code and here.
ROUNDING = 2e-9


def outside_along(pose, velocity):
    places = [advance(*pose, *velocity, float(time))[:2] for time in TIMES]
    return BORDER.outside_distances(np.array(places))


@settings(max_examples=300, deadline=None)
@given(POSES, VELOCITIES, VELOCITIES)
def test_no_predicted_motion_leaves_the_region(pose, measured, wanted):
    """No command whose predicted motion over the stopping horizon leaves the region."""
    verdict = SafetyStop(SETTINGS).judge(BORDER, pose, measured, wanted)
    start = BORDER.outside_distance(pose)
    delayed = advance(*pose, *measured, SETTINGS.stop_delay)
    begin = BORDER.outside_distance(delayed)
    if verdict.velocity.linear == 0.0:
        return
    allowed = max(-SETTINGS.stop_margin, start, begin) + SAGITTA
    kept = 1.0 - SETTINGS.slip_share
    v, w = verdict.velocity
    for velocity in ((v, w), (v, kept * w), (kept * v, w)):
        assert outside_along(delayed, velocity).max() <= allowed


@settings(max_examples=300, deadline=None)
@given(POSES, VELOCITIES)
def test_a_command_that_leads_further_outside_is_refused(pose, wanted):
    """Outside the region, commands that increase the distance to it are refused."""
    start = BORDER.outside_distance(pose)
    if start <= 0.0:
        return
    verdict = SafetyStop(SETTINGS).judge(BORDER, pose, STANDSTILL, wanted)
    if verdict.velocity.linear != 0.0:
        along = outside_along(pose, verdict.velocity)
        assert along.max() <= start + SAGITTA
        assert along[-1] <= start + ROUNDING


@settings(max_examples=200, deadline=None)
@given(POSES, VELOCITIES, VELOCITIES)
def test_the_safety_stop_never_makes_a_command_faster_or_turns_it_round(pose, measured, wanted):
    verdict = SafetyStop(SETTINGS).judge(BORDER, pose, measured, wanted)
    assert abs(verdict.velocity.linear) <= abs(wanted.linear)
    assert verdict.velocity.linear * wanted.linear >= 0.0
    assert abs(verdict.velocity.angular) <= abs(wanted.angular)


def test_in_the_open_a_command_passes_unchanged():
    border = Border(shapely.box(0.0, 0.0, 5.0, 5.0))
    verdict = SafetyStop(SETTINGS).judge(border, Pose(2.5, 2.5, 0.3), Velocity(0.3, 0.0),
                                         Velocity(0.3, 0.2))
    assert verdict.velocity == Velocity(0.3, 0.2)
    assert not verdict.was_slowed


@pytest.mark.parametrize('gap', [0.19, 0.12, 0.05, 0.01])
def test_towards_an_edge_a_command_is_slowed_and_then_stopped(gap):
    """Otherwise slow, turn in place, stop."""
    border = Border(shapely.box(0.0, 0.0, 5.0, 5.0))
    pose = Pose(5.0 - gap, 2.5, 0.0)
    verdict = SafetyStop(SETTINGS).judge(border, pose, STANDSTILL, Velocity(0.3, 0.1))
    reach = verdict.velocity.linear * SETTINGS.stop_horizon
    assert reach <= gap - SETTINGS.stop_margin + SAGITTA
    assert verdict.velocity.angular == 0.1
    is_needed = 0.3 * SETTINGS.stop_horizon > gap - SETTINGS.stop_margin
    assert verdict.was_slowed == is_needed


def test_the_measured_speed_counts_until_the_command_takes_effect():
    border = Border(shapely.box(0.0, 0.0, 5.0, 5.0))
    pose = Pose(4.87, 2.5, 0.0)
    stop = SafetyStop(SETTINGS)
    wanted = Velocity(0.2, 0.0)
    assert stop.is_safe(border, pose, STANDSTILL, wanted)
    assert not stop.is_safe(border, pose, Velocity(0.3, 0.0), wanted)


@settings(max_examples=60, deadline=None)
@given(st.floats(0.0, 2.0 * math.pi), st.floats(0.02, 0.6), st.floats(-math.pi, math.pi))
def test_a_robot_outside_is_led_back_and_never_further_away(bearing, distance, yaw):
    """A robot outside is led back to the nearest inside point."""
    region = shapely.box(0.0, 0.0, 2.0, 2.0)
    border = Border(region)
    retreat, stop = Retreat(SETTINGS), SafetyStop(SETTINGS)
    edge = np.array((1.0, 1.0)) + 5.0 * np.array((math.cos(bearing), math.sin(bearing)))
    edge = border.nearest(edge)
    outward = (edge - 1.0) / np.hypot(*(edge - 1.0))
    pose = Pose(*(edge + distance * outward), yaw)
    before = border.outside_distance(pose)
    for _ in range(2000):
        if not retreat.is_needed(border.outside_distance(pose)):
            break
        verdict = stop.judge(border, pose, STANDSTILL, retreat.velocity(border, pose))
        pose = Pose(*advance(*pose, *verdict.velocity, 0.05))
        after = border.outside_distance(pose)
        assert after <= max(before, 0.0) + 1e-6
        before = after
    assert border.outside_distance(pose) < 0.0
