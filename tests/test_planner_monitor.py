# SPDX-License-Identifier: Apache-2.0
"""The stride monitor: ground weaker than felt is noticed, ground as felt is left alone.

The requirement that these tests defend: a monitor of felt against measured slip tightens
certification, or stops, when the ground is weaker than the calibration says.
"""

import math

import numpy as np
import pytest

from psane_mapping.grid import Grid
from psane_mapping.slip import CalibratedSlipCurve
from psane_planner.configuration import PlannerConfiguration
from psane_planner.planner import SafePlanner
from psane_planner.status import PlannerState
from psane_planner.stride_monitor import StrideMonitor

CURVE = CalibratedSlipCurve()
CONFIG = PlannerConfiguration()
SPEED, STEP = 0.25, 0.05


def walk(monitor, strength, factor, seconds, seed=0, turn=0.0, extra=CONFIG.stride_allowance,
         start=0.0):
    """Walk ahead on ground of `factor` times the strength that is felt."""
    draw = np.random.default_rng(seed)
    felt = float(CURVE.slip(np.array(strength)))
    slip = min(1.0, float(CURVE.slip(np.array(strength * factor))) + extra)
    pose = np.array((1.0, 1.0, 0.3))
    for k in range(round(seconds / STEP)):
        monitor.note(start + STEP * k, pose, SPEED, turn, felt)
        gone = SPEED * STEP * (1.0 - slip) / (1.0 - CONFIG.stride_firm_slip)
        pose[:2] += (gone + draw.normal(0.0, 0.0005)) * np.array((math.cos(0.3), math.sin(0.3)))


def test_ground_as_strong_as_felt_changes_nothing():
    monitor = StrideMonitor(CONFIG)
    walk(monitor, 0.1, 1.0, 60.0)
    mean = np.linspace(0.0, 1.0, 50)
    assert monitor.strides > 30 and monitor.weakening == 0.0 and not monitor.is_too_weak
    np.testing.assert_array_equal(monitor.pessimistic(mean), mean)


def test_ground_firmer_than_felt_is_never_used_to_be_bolder():
    monitor = StrideMonitor(CONFIG)
    walk(monitor, 0.1, 1.5, 60.0)
    assert monitor.log_factor > 0.1 and monitor.weakening == 0.0


@pytest.mark.parametrize('factor', [0.8, 0.65])
def test_the_factor_of_weaker_ground_is_learnt_on_soft_ground(factor):
    monitor = StrideMonitor(CONFIG)
    walk(monitor, 0.12, factor, 240.0)
    # The slope of the curve is taken at the felt strength, which under-rates steep changes.
    assert monitor.log_factor == pytest.approx(math.log(factor), abs=0.12)
    assert monitor.weakening == monitor.log_factor < -2.0 * monitor.deviation


def test_what_may_be_chance_has_no_consequences_and_what_cannot_be_has_all():
    monitor = StrideMonitor(CONFIG)
    for deviations, share in ((0.9, 0.0), (1.0, 0.0), (1.5, 2.0 / 3.0), (2.0, 1.0), (4.0, 1.0)):
        monitor.log_factor = -deviations * monitor.deviation
        assert monitor.weakening == pytest.approx(share * monitor.log_factor)


def test_soft_ground_beside_the_centre_counts_as_felt():
    grid = Grid.over_workspace(0.0, 0.0, 6.0, 5.0, 0.1)
    aside = np.abs(grid.points[:, 1] - 1.05).reshape(grid.shape)
    corridor, pose = np.where(aside > 0.12, 0.6, 0.1), np.array((1.05, 1.05, 0.0))
    planner = SafePlanner(CONFIG, grid)
    planner.update(corridor, np.full(grid.shape, 0.03), pose, None, 0.0)
    slip = 0.1 + 0.5 * 4.0 / 6.0
    for k in range(400):
        planner.note_motion(pose, SPEED, 0.0, STEP * k)
        pose[0] += SPEED * STEP * (1.0 - slip) / (1.0 - CONFIG.stride_firm_slip)
    assert planner.strides.strides > 10 and planner.strides.weakening == 0.0


def test_strides_on_firm_ground_tell_next_to_nothing():
    monitor = StrideMonitor(CONFIG)
    walk(monitor, 2.0, 0.6, 60.0)
    assert abs(monitor.log_factor) < 0.05
    assert monitor.deviation > 0.9 * CONFIG.stride_prior_deviation


def test_pessimistic_slip_is_what_the_curve_says_of_the_weaker_ground():
    monitor = StrideMonitor(CONFIG)
    walk(monitor, 0.12, 0.7, 240.0)
    strength = np.geomspace(0.05, 1.0, 30)
    expected = CURVE.slip(strength * math.exp(monitor.weakening))
    np.testing.assert_allclose(monitor.pessimistic(np.asarray(CURVE.slip(strength))), expected,
                               atol=1e-6)


def test_pessimistic_slip_is_never_below_the_map_and_keeps_the_unknown():
    monitor = StrideMonitor(CONFIG)
    walk(monitor, 0.12, 0.7, 120.0)
    mean = np.r_[np.linspace(-0.3, 1.2, 40), np.nan]
    result = monitor.pessimistic(mean)
    assert (result[:-1] >= mean[:-1]).all() and np.isnan(result[-1])


def test_a_map_that_cannot_change_is_weakened_anew_when_more_is_known():
    monitor = StrideMonitor(CONFIG)
    walk(monitor, 0.12, 0.8, 60.0)
    mean = np.linspace(0.0, 1.0, 40)
    mean.setflags(write=False)
    first = monitor.pessimistic(mean)
    assert monitor.pessimistic(mean) is first
    walk(monitor, 0.12, 0.6, 240.0)
    assert (monitor.pessimistic(mean)[5:35] > first[5:35]).all()


@pytest.mark.parametrize('details', [
    {'turn': 0.4}, {'strength': 0.0}])
def test_turning_and_unknown_ground_are_left_out(details):
    monitor = StrideMonitor(CONFIG)
    if 'turn' in details:
        walk(monitor, 0.1, 0.6, 30.0, turn=details['turn'])
    else:
        for k in range(600):
            monitor.note(STEP * k, np.array((0.001 * k, 0.0, 0.0)), SPEED, 0.0, math.nan)
    assert monitor.strides == 0 and monitor.log_factor == 0.0


def test_a_jump_of_the_pose_counts_no_more_than_three_deviations():
    monitor = StrideMonitor(CONFIG)
    walk(monitor, 0.1, 1.0, 10.0)
    before = monitor.log_factor
    monitor.note(20.0, np.array((0.0, 0.0, 0.0)), SPEED, 0.0, 0.3)
    for k in range(1, 40):
        monitor.note(20.0 + STEP * k, np.array((-50.0, 0.0, 0.0)), SPEED, 0.0, 0.3)
    assert abs(monitor.log_factor - before) < 0.2


def test_a_planner_stops_with_a_reason_on_ground_far_weaker_than_felt():
    grid = Grid.over_workspace(0.0, 0.0, 6.0, 5.0, 0.1)
    planner = SafePlanner(CONFIG, grid)
    slip = float(CURVE.slip(np.array(0.12)))
    ground = np.full(grid.shape, slip), np.full(grid.shape, 0.03)
    plan = planner.update(*ground, np.array((1.0, 1.0, 0.3)), np.array((5.0, 4.0)), 0.0)
    assert plan.state is not PlannerState.STALLED
    walk(planner.strides, 0.12, 0.3, 400.0)
    plan = planner.update(*ground, np.array((1.0, 1.0, 0.3)), np.array((5.0, 4.0)), 0.2)
    assert plan.state is PlannerState.STALLED and plan.subgoal is None
    assert 'weaker than touch says' in plan.cause and 'calibrate' in plan.remedy


def test_a_planner_certifies_less_on_ground_weaker_than_felt():
    grid = Grid.over_workspace(0.0, 0.0, 6.0, 5.0, 0.1)
    slip = np.tile(np.linspace(0.1, 0.6, grid.columns), (grid.rows, 1))
    ground, pose = (slip, np.full(grid.shape, 0.03)), np.array((1.0, 2.5, 0.0))
    trusting, careful = SafePlanner(CONFIG, grid), SafePlanner(CONFIG, grid)
    walk(careful.strides, 0.12, 0.75, 240.0)
    before = trusting.update(*ground, pose, None, 0.0).certified
    after = careful.update(*ground, pose, None, 0.0).certified
    assert 0 < after.sum() < before.sum() and not (after & ~before).any()


def test_the_robot_s_motion_reaches_the_monitor_through_the_planner():
    grid = Grid.over_workspace(0.0, 0.0, 6.0, 5.0, 0.1)
    planner = SafePlanner(CONFIG, grid)
    planner.update(np.full(grid.shape, 0.3), np.full(grid.shape, 0.03), np.zeros(3) + 1.0, None,
                   0.0)
    for k in range(100):
        planner.note_motion(np.array((1.0 + 0.0125 * k, 1.0, 0.0)), SPEED, 0.0, STEP * k)
    assert planner.strides.strides == 3
    for k in range(100, 200):
        planner.note_motion(np.array((-9.0, 1.0, 0.0)), SPEED, 0.0, STEP * k)
    assert planner.strides.strides == 3, 'nothing is felt outside of the map'
