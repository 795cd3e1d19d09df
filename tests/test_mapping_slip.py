# SPDX-License-Identifier: Apache-2.0
"""Slip models: the published figures, and what holds of any of them."""

import math

import numpy as np
import pytest

from psane_mapping.errors import ParameterError
from psane_mapping.slip import CalibratedSlipCurve, RotaryWalking

# Slip of the simulated hexapod on uniform ground (multibody reference).
STRENGTH = np.array([.030, .048, .075, .119, .189, .300, .475, .754, 1.194, 1.893, 3.000])
SLIP = np.array([1.00, .833, .500, .306, .197, .141, .104, .090, .082, .070, .060])

MODELS = [CalibratedSlipCurve(), RotaryWalking(), RotaryWalking(clipped=False)]
FALLING = MODELS[:2]


def error(model):
    return float(np.sqrt(np.mean((model.slip(STRENGTH) - SLIP) ** 2)))


def test_the_calibrated_curve_fits_the_reference_ladder():
    assert error(CalibratedSlipCurve()) < 0.025


def test_rotary_walking_is_as_far_off_as_was_found():
    assert 0.10 < error(RotaryWalking()) < 0.17
    assert 0.20 < error(RotaryWalking(clipped=False)) < 0.28


@pytest.mark.parametrize('model', FALLING)
def test_slip_falls_with_strength_and_stays_a_ratio(model):
    strength = np.geomspace(1e-4, 100.0, 4000)
    slip = model.slip(strength)
    assert (np.diff(slip) <= 1e-12).all()
    assert (slip <= 1.0).all() and (slip >= 0.0).all()


def test_the_raw_rotary_model_is_not_monotone_and_the_clipped_one_is():
    strength = np.geomspace(0.05, 10.0, 500)
    assert (np.diff(RotaryWalking(clipped=False).slip(strength)) > 1e-6).any()
    assert RotaryWalking(clipped=False).slip(strength).min() < 0.0


@pytest.mark.parametrize('model', MODELS)
def test_the_derivative_equals_finite_differences(model):
    strength = np.geomspace(1.1 * model.saturation_strength, 10.0, 200)
    step = 1e-6 * strength
    numeric = (model.slip(strength + step) - model.slip(strength - step)) / (2.0 * step)
    # Next to the kink of the clipped model the two sides differ.
    kink = np.abs(numeric - model.derivative(strength)) > 1e-4 * (1.0 + np.abs(numeric))
    assert kink.sum() <= (1 if getattr(model, 'clipped', False) else 0)


@pytest.mark.parametrize('model', MODELS)
def test_the_inverse_undoes_the_slip(model):
    slip = np.linspace(0.12, 1.0, 50)
    strength = model.inverse(slip)
    assert (np.diff(strength) < 0.0).all()
    # At slip 1 the step vanishes like a square root, so that round-off is magnified.
    assert np.allclose(model.slip(strength * (1.0 + 1e-12)), slip, atol=1e-4)
    assert np.allclose(model.slip(strength[:-1]), slip[:-1], atol=1e-9)


@pytest.mark.parametrize('model', MODELS)
def test_slip_is_one_below_the_saturation_strength(model):
    weak = model.saturation_strength * np.array([0.0, 0.01, 0.5, 0.999])
    assert (model.slip(weak) == 1.0).all()
    assert (model.derivative(weak) == 0.0).all()
    assert float(model.slip(1.05 * model.saturation_strength)) < 1.0
    assert math.isclose(float(model.inverse(1.0)), model.saturation_strength)
    assert float(model.inverse(1.3)) == float(model.inverse(1.0))


def test_slip_that_no_ground_makes_has_an_infinite_strength():
    assert np.isinf(CalibratedSlipCurve().inverse([0.0, 0.081])).all()
    assert np.isinf(RotaryWalking(clipped=False).inverse(-10.0))


def test_deeper_sinkage_on_weaker_ground():
    model = RotaryWalking()
    assert (np.diff(model.sinkage(STRENGTH)) < 0.0).all()
    assert np.isinf(model.sinkage(0.0))
    # Newton's second law at the start of the stance, shared by three legs.
    force = 8.5 * (0.0875 * 4.7 / 0.4 + 9.81) / 3.0
    assert math.isclose(float(model.sinkage(0.5)), force / (0.5 * 3500.0))


@pytest.mark.parametrize('build', [
    lambda: CalibratedSlipCurve(half_strength=0.0), lambda: CalibratedSlipCurve(residual=1.0),
    lambda: CalibratedSlipCurve(exponent=math.nan), lambda: RotaryWalking(mass=-1.0),
    lambda: RotaryWalking(hip_height=0.2), lambda: RotaryWalking(legs_in_stance=0)])
def test_impossible_models_are_refused(build):
    with pytest.raises(ParameterError):
        build()
