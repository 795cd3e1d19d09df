# SPDX-License-Identifier: Apache-2.0
"""Strength of the ground from a stance: unbiased, honest about its error, or rejected."""

import dataclasses

import numpy as np
import pytest
from felt_stances import stance
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.strength import Reason, Rejection, StrengthEstimate, estimate_strength

CONFIG = MappingConfiguration()


def changed(contact, **arrays):
    return dataclasses.replace(contact, **arrays)


@settings(max_examples=60, deadline=None)
@given(strength=st.floats(0.03, 3.0), deepest=st.floats(0.02, 0.15), velocity=st.booleans())
def test_without_noise_the_strength_is_exact(strength, deepest, velocity):
    contact = stance(strength, deepest, noise=0.0, has_velocity=velocity)
    estimate = estimate_strength(contact, CONFIG)
    if isinstance(estimate, Rejection):
        assert estimate.reason is Reason.NO_RESPONSE
        return
    assert abs(np.log(estimate.strength / strength)) < 1e-9
    assert estimate.r_squared > 1.0 - 1e-9


@settings(max_examples=40, deadline=None)
@given(factor=st.floats(0.1, 10.0), seed=st.integers(0, 1000))
def test_a_stronger_ground_scales_the_estimate(factor, seed):
    contact = stance(0.5, seed=seed)
    louder = changed(contact, measured=factor * contact.measured,
                     deviation=factor * contact.deviation)
    config = MappingConfiguration(least_response=0.0, least_r_squared=0.0)
    one, other = (estimate_strength(c, config) for c in (contact, louder))
    assert np.isclose(other.strength, factor * one.strength, rtol=1e-9)
    assert np.isclose(other.log_deviation, one.log_deviation, rtol=1e-6)


def test_the_scatter_is_that_of_repeated_stances():
    config = MappingConfiguration(height_bias_deviation=0.0, model_deviation=0.0)
    estimates = [estimate_strength(stance(0.3, 0.04, seed=seed), config) for seed in range(400)]
    errors = np.log([estimate.strength / 0.3 for estimate in estimates])
    claimed = np.sqrt(np.mean([estimate.log_deviation**2 for estimate in estimates]))
    # 400 repetitions know a standard deviation to 3.5 %; the estimate may be cautious.
    assert 0.85 < claimed / errors.std() < 1.6
    assert abs(errors.mean()) < 3.0 * errors.std() / np.sqrt(400)


def test_noise_that_lasts_several_samples_widens_the_scatter():
    config = MappingConfiguration(height_bias_deviation=0.0, model_deviation=0.0,
                                  least_r_squared=0.0)
    errors, claimed = [], []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        contact = stance(0.3, 0.06, samples=140, noise=0.0)
        slow = np.zeros(contact.measured.shape)
        for i in range(1, slow.shape[0]):
            slow[i] = 0.9 * slow[i - 1] + np.sqrt(1.0 - 0.81) * rng.normal(size=3)
        noisy = contact.measured + 2.0 * contact.deviation * slow
        estimate = estimate_strength(changed(contact, measured=noisy), config)
        errors.append(np.log(estimate.strength / 0.3))
        claimed.append(estimate.log_deviation)
    # Taken for independent, the samples would claim a quarter of the true error.
    assert 0.6 < np.sqrt(np.mean(np.square(claimed))) / np.std(errors) < 1.8


@pytest.mark.parametrize('deepest', [0.02, 0.05, 0.15])
def test_a_height_bias_is_covered_by_the_height_deviation(deepest):
    rng = np.random.default_rng(1)
    errors, claimed = [], []
    for bias in rng.normal(0.0, 0.002, 200):
        estimate = estimate_strength(stance(1.0, deepest, noise=0.0, height_bias=bias),
                                     MappingConfiguration(height_bias_deviation=0.002))
        errors.append(np.log(estimate.strength))
        claimed.append(estimate.height_deviation)
    assert 0.8 < np.mean(claimed) / np.std(errors) < 1.5


def test_shallow_stances_are_less_certain():
    deviations = [estimate_strength(stance(2.0, depth), CONFIG).log_deviation
                  for depth in (0.15, 0.08, 0.04, 0.02, 0.01)]
    assert deviations == sorted(deviations)
    assert deviations[-1] > 5.0 * deviations[0]


def test_the_deviation_over_the_range_of_ground_is_that_of_the_reference():
    # Depths of the deepest leg at each strength; the reference log-RMSE at 5 mm bias is 0.188.
    ladder = zip([.030, .048, .075, .119, .189, .300, .475, .754, 1.194, 1.893, 3.000],
                 [.218, .158, .145, .137, .124, .107, .078, .058, .043, .031, .022], strict=True)
    config = MappingConfiguration(height_bias_deviation=0.005, model_deviation=0.05)
    claimed = [estimate_strength(stance(strength, depth), config).log_deviation
               for strength, depth in ladder]
    assert 0.15 < np.sqrt(np.mean(np.square(claimed))) < 0.25


def test_a_knock_of_a_few_samples_does_not_tilt_the_line():
    contact = stance(0.4, 0.06)
    knocked = contact.measured.copy()
    knocked[38:42] += 60.0
    estimate = estimate_strength(changed(contact, measured=knocked), CONFIG)
    plain = (contact.response * knocked / contact.deviation**2).sum() / (
        (contact.response / contact.deviation) ** 2).sum()
    assert abs(np.log(estimate.strength / 0.4)) < 0.04
    assert abs(np.log(plain / 0.4)) > 2.0 * abs(np.log(estimate.strength / 0.4))


def test_without_velocity_only_the_vertical_channel_counts():
    contact = stance(0.4, 0.06, has_velocity=False)
    spoiled = contact.measured.copy()
    spoiled[:, [0, 2]] = 1e3
    assert (estimate_strength(changed(contact, measured=spoiled), CONFIG)
            == estimate_strength(contact, CONFIG))


@pytest.mark.parametrize('share', [0.75, 1.25])
def test_forces_that_contradict_each_other_widen_the_deviation(share):
    agreeing = stance(0.4, 0.08)
    tilted = agreeing.measured.copy()
    tilted[:, 0] *= share
    plain, wider = (estimate_strength(contact, CONFIG) for contact in (
        agreeing, changed(agreeing, measured=tilted)))
    assert plain.disagreement_deviation < 0.02
    expected = CONFIG.disagreement_share * abs(np.log(share))
    assert wider.disagreement_deviation == pytest.approx(expected, rel=0.25)
    assert wider.log_deviation > plain.log_deviation
    alone = estimate_strength(changed(agreeing, measured=tilted, has_velocity=False), CONFIG)
    assert alone.disagreement_deviation == 0.0


def rejected_stances():
    good = stance(0.4, 0.06)
    rng = np.random.default_rng(0)
    return [
        (Reason.TOO_FEW_SAMPLES, stance(0.4, 0.06, samples=6)),
        (Reason.TOO_SHALLOW, stance(0.4, 0.0029)),
        (Reason.NO_RESPONSE, changed(good, response=np.zeros_like(good.response))),
        (Reason.NOT_POSITIVE, changed(good, measured=-good.measured)),
        (Reason.IMPLAUSIBLE, changed(good, measured=1e4 * good.measured,
                                     deviation=10.0 * good.deviation)),
        (Reason.POOR_FIT, changed(good, measured=good.measured
                                  + 40.0 * rng.normal(size=good.measured.shape))),
    ]


@pytest.mark.parametrize('reason, contact', rejected_stances())
def test_a_stance_that_tells_nothing_is_rejected_with_its_reason(reason, contact):
    outcome = estimate_strength(contact, CONFIG)
    assert isinstance(outcome, Rejection) and outcome.reason is reason


def test_the_gates_have_two_sides():
    assert isinstance(estimate_strength(stance(3.0, 0.0031, noise=0.0), MappingConfiguration(
        least_response=0.0)), StrengthEstimate)
    contact = stance(0.4, 0.06, noise=4.0, seed=3)
    r_squared = estimate_strength(contact, MappingConfiguration(least_r_squared=0.0)).r_squared
    assert r_squared < 1.0
    for least, kind in ((r_squared - 1e-6, StrengthEstimate), (r_squared + 1e-6, Rejection)):
        outcome = estimate_strength(contact, MappingConfiguration(least_r_squared=least))
        assert isinstance(outcome, kind)


def test_the_published_linear_fit_recovers_a_linear_spring():
    config = MappingConfiguration(strength_method='linear_stiffness', fit_stiffness=2000.0)
    contact = stance(0.4, 0.05)
    spring = contact.measured.copy()
    spring[:, 1] = 0.7 * 2000.0 * contact.depth
    estimate = estimate_strength(changed(contact, measured=spring), config)
    assert abs(estimate.strength - 0.7) < 1e-9


@settings(max_examples=60, deadline=None)
@given(scale=st.sampled_from([0.0, 1e-200, 1e-9, 1.0, 1e6, 1e200]), seed=st.integers(0, 100),
       samples=st.integers(1, 30))
def test_any_finite_record_gives_a_finite_estimate_or_a_rejection(scale, seed, samples):
    rng = np.random.default_rng(seed)
    contact = stance(samples=samples)
    contact = changed(contact, depth=rng.normal(0.0, 0.1, samples),
                      measured=scale * rng.normal(size=(samples, 3)),
                      response=scale * rng.normal(size=(samples, 3)),
                      deviation=scale * np.abs(rng.normal(size=(samples, 3))))
    outcome = estimate_strength(contact, MappingConfiguration(least_r_squared=0.0))
    if isinstance(outcome, StrengthEstimate):
        assert outcome.strength > 0.0 and np.isfinite(outcome.strength)
        assert outcome.log_deviation > 0.0 and np.isfinite(outcome.log_deviation)
