# SPDX-License-Identifier: Apache-2.0
"""The compiled regression beside the same one in numpy."""

import numpy as np
import pytest

from psane_mapping.robust_slope import huber_slope, pairwise_sum

ROUNDS, BEND, LEAST_SCALE = 6, 1.5, 1.0


def in_numpy(predictor, measured):
    weights = np.ones_like(measured)
    for _ in range(ROUNDS):
        slope = (weights * predictor * measured).sum() / (weights * predictor**2).sum()
        residual = measured - slope * predictor
        scale = max(LEAST_SCALE, 1.4826 * float(np.median(np.abs(residual))))
        weights = np.minimum(1.0, BEND * scale / np.maximum(np.abs(residual), 1e-12))
    return slope, weights, residual


@pytest.mark.parametrize('count', [1, 7, 8, 9, 127, 128, 129, 136, 257, 5001])
def test_the_sum_is_that_of_numpy_to_the_last_bit(count):
    values = np.random.default_rng(count).normal(size=count)
    assert pairwise_sum(values) == values.sum()


@pytest.mark.parametrize('count', [8, 33, 48, 180, 301])
def test_slope_weights_and_residuals_are_those_of_numpy_to_the_last_bit(count):
    generator = np.random.default_rng(count)
    predictor = generator.normal(size=count)
    measured = 0.7 * predictor + generator.standard_t(2, size=count)
    weights, residual = np.empty(count), np.empty(count)
    slope = huber_slope(predictor, measured, weights, residual, ROUNDS, BEND, LEAST_SCALE)
    expected = in_numpy(predictor, measured)
    assert slope == expected[0]
    assert np.array_equal(weights, expected[1])
    assert np.array_equal(residual, expected[2])


def test_samples_that_tell_nothing_give_no_number():
    nothing = np.zeros(12)
    slope = huber_slope(nothing, nothing, np.empty(12), np.empty(12), ROUNDS, BEND, LEAST_SCALE)
    assert np.isnan(slope)
