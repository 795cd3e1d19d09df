# SPDX-License-Identifier: Apache-2.0
"""From stances to maps: what a stance may claim, and what no number of stances may claim."""

import math

import numpy as np
import pytest
from felt_stances import stance
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.errors import ParameterError
from psane_mapping.mapper import TerrainMapper, TerrainSample
from psane_mapping.parameters import from_mapping
from psane_mapping.propagation import propagate, slip_model_of
from psane_mapping.slip import CalibratedSlipCurve, RotaryWalking
from psane_mapping.strength import Reason, Rejection, StrengthEstimate

CONFIG = MappingConfiguration()
CURVE = CalibratedSlipCurve()


def estimate(strength, log_deviation):
    return StrengthEstimate(strength=strength, log_deviation=log_deviation, r_squared=0.99,
                            scatter_deviation=0.0, height_deviation=0.0, samples=50)


@pytest.fixture
def mapper():
    return TerrainMapper(CONFIG)


def test_small_errors_propagate_by_the_delta_method():
    for strength in (0.05, 0.08, 0.2, 1.0):
        deviation = propagate(estimate(strength, 0.01), CURVE, CONFIG).deviation
        slope = float(CURVE.derivative(strength)) * strength
        assert math.isclose(deviation, math.hypot(CONFIG.slip_noise_floor, 0.01 * slope),
                            rel_tol=1e-3)


def test_a_saturated_stance_is_not_certain():
    saturated = propagate(estimate(0.5 * CURVE.saturation_strength, 0.05), CURVE, CONFIG)
    assert saturated.slip == 1.0
    assert saturated.deviation > CONFIG.saturation_deviation
    at_the_bend = propagate(estimate(CURVE.saturation_strength, 0.1), CURVE, CONFIG)
    assert CONFIG.slip_noise_floor < at_the_bend.deviation
    assert at_the_bend.deviation > math.sqrt(0.49) * CONFIG.saturation_deviation


@settings(max_examples=200, deadline=None)
@given(strength=st.floats(1e-3, 100.0), deviation=st.floats(0.0, 1.5),
       model=st.sampled_from([CURVE, RotaryWalking(), RotaryWalking(clipped=False)]))
def test_slip_is_a_ratio_and_its_deviation_never_below_the_floor(strength, deviation, model):
    slip, error = propagate(estimate(strength, deviation), model, CONFIG)
    assert 0.0 <= slip <= 1.0
    assert CONFIG.slip_noise_floor <= error <= 1.1


def test_propagated_deviation_equals_that_of_many_draws():
    rng = np.random.default_rng(0)
    config = MappingConfiguration(saturation_deviation=0.0)
    for strength, deviation in ((0.06, 0.2), (0.04, 0.3), (0.3, 0.4)):
        draws = CURVE.slip(strength * np.exp(deviation * rng.normal(size=200_000)))
        expected = math.hypot(config.slip_noise_floor, np.sqrt(
            np.mean((draws - CURVE.slip(strength)) ** 2)))
        got = propagate(estimate(strength, deviation), CURVE, config).deviation
        # The kink at slip 1 costs the quadrature a few per cent.
        assert abs(got / expected - 1.0) < 0.05


def test_a_stance_lowers_the_uncertainty_where_it_was_felt(mapper):
    before = mapper.maps()
    sample = mapper.add(stance(0.3, 0.08, point=(5.0, 5.0)))
    after = mapper.maps()
    assert isinstance(sample, TerrainSample) and mapper.accepted == 1
    assert after.version == before.version + 1 and after.time == 1.0
    assert after.slip_std[50, 50] < 0.3 * before.slip_std[50, 50]
    assert abs(after.slip_mean[50, 50] - sample.slip) < 0.02
    assert abs(after.log_strength_mean[50, 50] - math.log(0.3)) < 0.1
    assert (after.slip_std <= before.slip_std).all()
    assert math.isclose(after.slip_std[0, 0], CONFIG.slip_prior_deviation)


def test_unfelt_ground_is_not_certified_by_the_default_prior(mapper):
    maps = mapper.maps()
    # beta = 4: upper bound mean + 2 std; the largest threshold in use is 0.8.
    assert (maps.slip_mean + 2.0 * maps.slip_std >= 1.0).all()


def test_no_number_of_stances_averages_out_the_common_error(mapper):
    for seed in range(400):
        mapper.add(stance(0.5, 0.08, seed=seed, time=float(seed)))
    maps = mapper.maps()
    assert maps.slip_std.min() >= CONFIG.common_deviation
    assert maps.slip_std.min() < 1.3 * CONFIG.common_deviation
    assert maps.log_strength_std.min() >= CONFIG.common_log_deviation
    assert maps.slip_std.max() <= CONFIG.slip_prior_deviation


def test_maps_cover_the_true_slip_of_a_field_as_often_as_they_claim():
    def true_slip(points):
        return 0.45 + 0.35 * np.sin(0.9 * points[..., 0]) * np.cos(0.8 * points[..., 1])

    mapper = TerrainMapper(CONFIG)
    rng = np.random.default_rng(2)
    for seed, point in enumerate(rng.uniform(0.5, 9.5, (500, 2))):
        strength = float(CURVE.inverse(true_slip(point)))
        depth = float(np.clip(0.04 / math.sqrt(strength), 0.01, 0.15))
        mapper.add(stance(strength, depth, seed=seed, point=tuple(point), time=float(seed),
                          height_bias=0.003))
    assert mapper.accepted > 400
    maps = mapper.maps()
    truth = true_slip(mapper.grid.points).reshape(mapper.grid.shape)
    inside = (slice(10, -10), slice(10, -10))
    error = (maps.slip_mean - truth)[inside]
    assert np.sqrt(np.mean(error**2)) < 0.06
    # Two standard deviations hold 95 % of a normal; the bias of this walk is shared by all cells.
    covered = np.abs(error) <= 2.0 * maps.slip_std[inside]
    assert covered.mean() > 0.9


def test_rejections_are_counted_by_reason_and_change_nothing(mapper):
    version = mapper.version
    outcomes = [mapper.add(stance(0.4, 0.001)), mapper.add(stance(0.4, 0.06, samples=5)),
                mapper.add(stance(0.4, 0.06, point=(10.5, 2.0)))]
    assert all(isinstance(outcome, Rejection) for outcome in outcomes)
    assert mapper.rejected == {Reason.TOO_SHALLOW: 1, Reason.TOO_FEW_SAMPLES: 1,
                               Reason.OUTSIDE_MAP: 1}
    assert mapper.version == version and mapper.accepted == 0
    assert (mapper.maps().slip_std == CONFIG.slip_prior_deviation).all()


def test_an_uncertain_point_is_believed_less_on_a_slope_and_as_much_on_the_level():
    def deviations(strengths, point_deviation):
        mapper = TerrainMapper(CONFIG)
        for seed in range(60):
            x = 4.0 + 2.0 * (seed % 12) / 11.0
            strength = float(np.interp(x, (4.0, 6.0), strengths))
            mapper.add(stance(strength, 0.1, seed=seed, point=(x, 4.6 + 0.2 * (seed // 12))))
        sample = mapper.add(stance(float(np.mean(strengths)), 0.1,
                                   point_deviation=point_deviation))
        return sample.slip_deviation

    assert deviations((0.06, 0.2), 0.2) > 1.15 * deviations((0.06, 0.2), 0.0)
    assert deviations((0.2, 0.2), 0.2) < 1.05 * deviations((0.2, 0.2), 0.0)


def test_without_a_map_of_strength_that_of_slip_is_the_same(mapper):
    alone = TerrainMapper(CONFIG, has_strength_map=False)
    untouched = mapper.maps()
    for k in range(20):
        felt = stance(0.3 + 0.02 * k, leg=k % 6, point=(3.0 + 0.1 * k, 4.0), time=1.0 + k)
        assert isinstance(mapper.add(felt), TerrainSample)
        assert isinstance(alone.add(felt), TerrainSample)
    one, both = alone.maps(), mapper.maps()
    np.testing.assert_array_equal(one.slip_mean, both.slip_mean)
    np.testing.assert_array_equal(one.slip_std, both.slip_std)
    np.testing.assert_array_equal(one.log_strength_std, untouched.log_strength_std)
    assert not np.array_equal(both.log_strength_std, untouched.log_strength_std)


def test_position_noise_can_be_switched_off():
    mapper = TerrainMapper(MappingConfiguration(use_position_noise=False))
    mapper.add(stance(0.06, 0.1, point=(4.8, 5.0)))
    one, other = (mapper.add(stance(0.2, 0.1, point_deviation=d, leg=k))
                  for k, d in enumerate((0.0, 0.5)))
    assert one.slip_deviation == other.slip_deviation


def test_reset_forgets_the_ground_but_not_the_version(mapper):
    mapper.add(stance(0.3, 0.08))
    version = mapper.version
    mapper.reset()
    maps = mapper.maps()
    assert maps.version > version and math.isnan(maps.time) and mapper.accepted == 0
    assert (maps.slip_mean == CONFIG.slip_prior_mean).all()
    assert (maps.slip_std == CONFIG.slip_prior_deviation).all()


def test_maps_cannot_be_written_and_do_not_change_afterwards(mapper):
    maps = mapper.maps()
    with pytest.raises(ValueError, match='read-only'):
        maps.slip_mean[0, 0] = 1.0
    mapper.add(stance(0.3, 0.08))
    assert (maps.slip_std == CONFIG.slip_prior_deviation).all()


def test_the_default_grid_is_that_of_the_design(mapper):
    assert mapper.grid.shape == (101, 101)


@pytest.mark.parametrize('name, model', [
    ('calibrated', CURVE), ('rotary_walking', RotaryWalking()),
    ('rotary_walking_raw', RotaryWalking(clipped=False))])
def test_the_configuration_names_the_slip_model(name, model):
    assert slip_model_of(MappingConfiguration(slip_model=name)) == model


@pytest.mark.parametrize('values', [
    {'max_x': -1.0}, {'common_deviation': 0.6}, {'std_scale': 0.001}, {'kernel': 'cubic'},
    {'log_std_scale': 0.01}, {'lengthscale': math.nan}, {'highest_strength': 0.005},
    {'no_such_parameter': 1.0}])
def test_a_configuration_that_cannot_work_is_refused(values):
    with pytest.raises(ParameterError):
        from_mapping(MappingConfiguration, values)
