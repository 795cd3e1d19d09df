# SPDX-License-Identifier: Apache-2.0
"""Alternating tripods and the feed-forward from a Twist to stance sweeps."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from psane_mapping.leg import TRIPOD
from psane_sim.calibration.ladder import REFERENCE_SPEED
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.feed_forward import sweeps_of
from psane_sim.robot.gait import Gait, wrap

law = settings(deadline=None, derandomize=True, max_examples=40)
CONFIG = SimulatorConfiguration()
TICKS_PER_STRIDE = round(1.0 / (CONFIG.stride_frequency * CONFIG.time_step))
speeds = st.floats(-1.0, 1.0)


def run(gait, ticks):
    """Return the reference angles of some ticks, (ticks, 6)."""
    return np.array([gait.tick().angle.copy() for _ in range(ticks)])


def walking(linear, angular=0.0, strides=2):
    """Return a gait that has found its stride."""
    gait = Gait(CONFIG)
    gait.command(linear, angular)
    run(gait, strides * TICKS_PER_STRIDE)
    return gait


@law
@given(linear=speeds, angular=speeds)
def test_sweeps_stay_within_the_joint_limit_for_any_command(linear, angular):
    sweep = sweeps_of(linear, angular, CONFIG)
    assert max(abs(sweep.left), abs(sweep.right)) <= CONFIG.sweep_limit + 1e-12


@law
@given(linear=speeds, angular=speeds)
def test_a_mirrored_turn_is_made_by_the_mirrored_sweeps(linear, angular):
    sweep = sweeps_of(linear, angular, CONFIG)
    mirrored = sweeps_of(linear, -angular, CONFIG)
    assert (mirrored.left, mirrored.right) == pytest.approx((sweep.right, sweep.left))
    if angular != 0.0 or linear != 0.0:
        assert (mirrored.swing_left, mirrored.swing_right) == (sweep.swing_right,
                                                               sweep.swing_left)


@law
@given(linear=st.floats(0.02, 0.3))
def test_a_faster_command_sweeps_further(linear):
    slow, fast = (sweeps_of(speed, 0.0, CONFIG) for speed in (0.9 * linear, linear))
    assert fast.left == fast.right > slow.left > 0.0


def test_the_legs_of_a_tripod_move_together_and_the_tripods_half_a_stride_apart():
    angles = run(walking(0.25), 2 * TICKS_PER_STRIDE)
    first = [leg for leg in range(6) if TRIPOD[leg] == 0]
    second = [leg for leg in range(6) if TRIPOD[leg] == 1]
    for legs in (first, second):
        assert np.ptp(angles[:, legs], axis=1).max() < 1e-9
    half = TICKS_PER_STRIDE / 2.0
    lead = angles[:, first[0]]
    later = np.interp(np.arange(800) + half, np.arange(len(lead)), np.unwrap(angles[:, second[0]]))
    error = [wrap(a - b) for a, b in zip(lead[:800], later, strict=True)]
    # One tick of the swing is 8.5 mrad, and half a stride is not a whole number of ticks.
    assert np.abs(error).max() < 0.02


def test_each_leg_turns_once_in_a_stride_and_spends_the_duty_in_its_stance_sweep():
    gait = walking(REFERENCE_SPEED)
    angles = np.unwrap(run(gait, TICKS_PER_STRIDE + 1), axis=0)
    np.testing.assert_allclose(angles[-1] - angles[0], 2.0 * math.pi, atol=0.02)
    in_sweep = np.abs(np.vectorize(wrap)(angles[:-1])) <= 0.5 * gait.sweep.left
    assert in_sweep.mean() == pytest.approx(CONFIG.duty, abs=0.01)
    assert gait.sweep.left == pytest.approx(1.2, abs=0.01)


def test_reference_angles_never_jump_whatever_is_commanded():
    generator = np.random.default_rng(1)
    gait = Gait(CONFIG)
    angles = []
    for _ in range(60):
        stand = generator.random() < 0.25
        gait.command(*((0.0, 0.0) if stand else generator.uniform(-0.4, 0.4, 2)))
        angles.append(run(gait, int(generator.integers(20, 700))))
    step = np.diff(np.vstack(angles), axis=0)
    step = (step + math.pi) % (2.0 * math.pi) - math.pi
    fastest = (2.0 * math.pi + CONFIG.sweep_limit) * CONFIG.stride_frequency / (1.0 - CONFIG.duty)
    catching_up = 5.0 + CONFIG.sweep_rate
    assert np.abs(step).max() <= (fastest + catching_up) * CONFIG.time_step


@law
@given(seed=st.integers(0, 1000))
def test_a_stop_ends_within_half_a_second_with_every_foot_below_its_hip(seed):
    generator = np.random.default_rng(seed)
    gait = walking(*generator.uniform(-0.3, 0.3, 2), strides=1)
    run(gait, int(generator.integers(0, TICKS_PER_STRIDE)))
    gait.command(0.0, 0.0)
    angles = run(gait, 500)
    assert gait.is_standing
    assert np.abs(angles[-1] - angles[-2]).max() / CONFIG.time_step < 0.05
    # A foot is below its hip while the leg points less than a right angle from straight down.
    assert np.abs([wrap(float(angle)) for angle in angles[-1]]).max() < 0.5 * math.pi - 0.2


@law
@given(ticks=st.integers(0, TICKS_PER_STRIDE))
def test_a_stop_holds_the_legs_on_the_ground_where_they_are(ticks):
    gait = walking(0.25)
    run(gait, ticks)
    before = gait.reference.angle.copy()
    grounded = np.abs([wrap(float(angle)) for angle in before]) < 0.45 * gait.sweep.left
    # While both tripods stand, all legs are near the ends of their stance.
    assume(grounded.any())
    sweep = gait.sweep.left
    gait.command(0.0, 0.0)
    assert gait.sweep == (0.0, 0.0, 0.0, 0.0)
    moved = np.abs([wrap(float(turn)) for turn in run(gait, 600)[-1] - before])
    # A leg in stance moves at the sweep's speed and comes to rest within 1 / stand_gain of time.
    speed = sweep * CONFIG.stride_frequency / CONFIG.duty
    assert moved[grounded].max() < 1.1 * speed / CONFIG.stand_gain


def test_it_starts_by_standing_on_straight_legs_and_standing_again_changes_nothing():
    gait = Gait(CONFIG)
    gait.command(0.0, 0.0)
    assert gait.is_standing
    assert not run(gait, 100).any()


def test_the_smallest_command_marches_in_place():
    gait = walking(1e-9)
    angles = np.unwrap(run(gait, TICKS_PER_STRIDE), axis=0)
    assert not gait.is_standing
    assert (np.ptp(angles, axis=0) > 6.0).all()
    assert abs(gait.sweep.left) < 1e-6


def test_walking_backward_turns_the_legs_the_other_way():
    angles = np.unwrap(run(walking(-0.2), TICKS_PER_STRIDE + 1), axis=0)
    np.testing.assert_allclose(angles[-1] - angles[0], -2.0 * math.pi, atol=0.02)
