# SPDX-License-Identifier: Apache-2.0
"""Safety of the published maps: no ground looks safer than it is.

"Rounding is conservative (mean and std up, so u is never under-estimated) ... -1 = no estimate."
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from psane_mapping.encoding import (
    decode_log_strength,
    decode_slip_mean,
    decode_std,
    encode_log_strength,
    encode_slip_mean,
    encode_std,
)
from psane_mapping.errors import ParameterError

SCALE = 0.005
# A value within 1e-9 of a whole step counts as that step (round-off of the division).
WHOLE_STEP = 1e-9


@settings(max_examples=200, deadline=None)
@given(mean=arrays(np.float64, (4, 5), elements=st.floats(-0.5, 1.0)),
       std=arrays(np.float64, (4, 5), elements=st.floats(0.0, 100 * SCALE)),
       beta=st.floats(0.0, 100.0))
def test_the_decoded_upper_bound_is_never_below_the_true_one(mean, std, beta):
    decoded_mean = decode_slip_mean(encode_slip_mean(mean))
    decoded_std = decode_std(encode_std(std, SCALE), SCALE)
    upper = decoded_mean + math.sqrt(beta) * decoded_std
    truth = mean + math.sqrt(beta) * std
    assert (upper >= truth - WHOLE_STEP).all()


@settings(max_examples=200, deadline=None)
@given(mean=arrays(np.float64, (6,), elements=st.floats(0.0, 1.0)),
       std=arrays(np.float64, (6,), elements=st.floats(0.0, 100 * SCALE)))
def test_rounding_costs_less_than_a_step(mean, std):
    assert (decode_slip_mean(encode_slip_mean(mean)) - mean < 0.01).all()
    assert (decode_std(encode_std(std, SCALE), SCALE) - std < SCALE).all()


@given(st.integers(0, 100))
def test_cells_survive_decoding_and_encoding(step):
    cells = np.array([[step]], dtype=np.int8)
    assert encode_slip_mean(decode_slip_mean(cells)) == cells
    assert encode_std(decode_std(cells, SCALE), SCALE) == cells
    assert encode_log_strength(decode_log_strength(cells, 0.01, 10.0), 0.01, 10.0) == cells


def test_no_estimate_is_minus_one_and_comes_back_as_nan():
    values = np.array([[0.2, np.nan]])
    for encode, decode in ((encode_slip_mean, decode_slip_mean),
                           (lambda v: encode_std(v, SCALE), lambda c: decode_std(c, SCALE)),
                           (lambda v: encode_log_strength(v, 0.01, 10.0),
                            lambda c: decode_log_strength(c, 0.01, 10.0))):
        cells = encode(values)
        assert cells.dtype == np.int8 and cells[0, 1] == -1 and cells[0, 0] >= 0
        assert np.isnan(decode(cells)[0, 1]) and np.isfinite(decode(cells)[0, 0])


def test_slip_outside_the_range_is_shown_at_its_end():
    assert encode_slip_mean(np.array([-0.3, 1.4])).tolist() == [0, 100]


def test_a_deviation_that_does_not_fit_is_refused_and_not_cut():
    assert encode_std(np.array([0.5]), SCALE) == 100
    with pytest.raises(ParameterError, match='std_scale'):
        encode_std(np.array([0.5001]), SCALE)


@given(st.floats(0.01, 10.0))
def test_strength_is_rounded_down_by_less_than_seven_percent(strength):
    decoded = np.exp(decode_log_strength(
        encode_log_strength(np.log(np.array([strength])), 0.01, 10.0), 0.01, 10.0))
    assert decoded <= strength * (1.0 + 1e-9) and decoded > strength / 1.072


def test_strength_beyond_the_ends_is_shown_at_them():
    assert encode_log_strength(np.log(np.array([1e-4, 1e3])), 0.01, 10.0).tolist() == [0, 100]
    with pytest.raises(ParameterError):
        encode_log_strength(np.zeros(1), 2.0, 1.0)
