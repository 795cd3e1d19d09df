# SPDX-License-Identifier: Apache-2.0
"""Smoothing of what is known twice, and the height that the stances give away."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from psane_sim.touch.complementary import added_up, corrected, corrected_attitude, smooth
from psane_sim.touch.height_bias import HeightBias, HeightOffset, offset_of

law = settings(deadline=None, derandomize=True, max_examples=40)
TIME = np.arange(160) * 0.005
HIP = np.array([0.2, 0.15, 0.0])


@law
@given(a=st.floats(-5.0, 5.0), width=st.floats(0.01, 1.0), seed=st.integers(0, 100))
def test_a_constant_is_smoothed_to_itself(a, width, seed):
    at = np.random.default_rng(seed).uniform(-0.5, 1.5, 20)
    found = smooth(TIME, np.full((len(TIME), 2), a), at, width)
    np.testing.assert_allclose(found, a, atol=1e-9)


def test_a_straight_line_is_hardly_bent():
    line = np.column_stack((2.0 * TIME, -TIME))
    np.testing.assert_allclose(smooth(TIME, line, TIME, 0.05), line, atol=5e-3)


@pytest.mark.parametrize('at', [-3.0, 0.4, 9.0])
def test_one_value_is_as_good_as_it_is_everywhere(at):
    found = smooth(np.array([0.2]), np.array([[3.0]]), np.array([at]), 0.1)
    np.testing.assert_allclose(found, 3.0)


def test_the_integral_of_a_mean_rate_is_exact():
    motion = np.sin(7.0 * TIME)[:, None]
    rate = np.diff(motion, axis=0, prepend=np.zeros((1, 1))) / 0.005
    np.testing.assert_allclose(added_up(TIME, rate, is_mean=True), motion, atol=1e-12)


@law
@given(seed=st.integers(0, 200))
def test_rate_and_value_together_are_better_than_either(seed):
    generator = np.random.default_rng(seed)
    motion = np.column_stack([np.sin((3.0 + k) * TIME + k) for k in range(3)])
    rate = np.gradient(motion, 0.005, axis=0) + 0.05 + 0.3 * generator.normal(size=motion.shape)
    noisy = motion + 0.05 * generator.normal(size=motion.shape)
    together = corrected(TIME, added_up(TIME, rate), TIME, noisy, 0.1)

    def error(found):
        return float(np.sqrt(np.mean((found - motion) ** 2)))

    assert error(together) < 0.5 * error(noisy)
    assert error(together) < error(motion[0] + added_up(TIME, rate))


def test_an_attitude_is_found_out_of_rates_and_noisy_attitudes():
    generator = np.random.default_rng(0)
    rate = np.column_stack((np.sin(5.0 * TIME), np.cos(3.0 * TIME), np.full(len(TIME), 0.4)))
    true = [Rotation.from_euler('xyz', [0.1, -0.2, 1.0])]
    for before, after in zip(rate[:-1], rate[1:], strict=True):
        true.append(true[-1] * Rotation.from_rotvec(0.0025 * (before + after)))
    noisy = [Rotation.from_rotvec(0.01 * generator.normal(size=3)) * each for each in true]
    found = corrected_attitude(TIME, rate + 0.005 * generator.normal(size=rate.shape),
                               np.array([each.as_quat() for each in noisy]), 0.1)
    errors = [(Rotation.from_matrix(matrix) * each.inv()).magnitude()
              for matrix, each in zip(found, true, strict=True)]
    assert np.sqrt(np.mean(np.square(errors))) < 0.006
    np.testing.assert_allclose(np.linalg.det(found), 1.0)


def penetration(offset, seed, noise=1.0):
    """Return measured, response, deeper response and deviation of a leg that goes in and out."""
    generator = np.random.default_rng(seed)
    depth = 0.05 * np.sin(np.linspace(0.0, np.pi, 80))

    def force(at):
        vertical = 4.0e3 * np.maximum(at, 0.0) ** 1.4
        return np.column_stack((0.3 * vertical, vertical, -0.5 * vertical))

    measured = 0.7 * force(depth + offset)
    deviation = 1.0 + 0.03 * np.abs(measured)
    return (measured + noise * deviation * generator.normal(size=measured.shape), force(depth),
            force(depth + 0.002), deviation)


@law
@given(offset=st.floats(-0.004, 0.004), seed=st.integers(0, 500))
def test_a_stance_gives_its_height_away_as_surely_as_it_says(offset, seed):
    found = offset_of(*penetration(offset, seed), 0.002)
    assert found is not None
    assert abs(found.offset - offset) < 5.0 * found.deviation + 0.0008
    assert found.deviation < 0.005


def test_a_response_that_grows_alike_everywhere_gives_no_height():
    measured, response, _, deviation = penetration(0.002, 0)
    assert offset_of(measured, response, 1.1 * response, deviation, 0.002) is None


def bias():
    return HeightBias(0.005, 0.005, 0.003, 0.0003)


def test_many_stances_find_the_height_and_the_tilt():
    generator = np.random.default_rng(3)
    filter_ = bias()
    hips = [np.array([x, y, 0.0]) for x in (0.2, 0.0, -0.2) for y in (0.15, -0.15)]
    for step in range(120):
        hip = hips[step % 6]
        true = 0.006 + 0.008 * hip[0] - 0.01 * hip[1]
        filter_.learn(HeightOffset(true + 0.004 * generator.normal(), 0.003), hip, 0.2 * step)
    for hip in hips:
        assert filter_.at(hip) == pytest.approx(0.006 + 0.008 * hip[0] - 0.01 * hip[1], abs=0.002)
    assert filter_.deviation < 0.0015


def test_one_wild_stance_does_not_spoil_what_many_have_said():
    filter_ = bias()
    for step in range(20):
        filter_.learn(HeightOffset(0.002, 0.002), HIP, 0.2 * step)
    before = filter_.at(HIP)
    filter_.learn(HeightOffset(0.2, 0.002), HIP, 5.0)
    assert abs(filter_.at(HIP) - before) < 0.002


def test_what_is_known_of_the_height_fades_but_never_beyond_the_prior():
    filter_ = bias()
    for step in range(20):
        filter_.learn(HeightOffset(0.0, 0.001), HIP, float(step))
    sure = filter_.deviation
    filter_.learn(HeightOffset(0.0, 1.0), HIP, 100.0)
    faded = filter_.deviation
    filter_.learn(HeightOffset(0.0, 1.0), HIP, 1.0e7)
    assert sure < faded < filter_.deviation <= 0.005
