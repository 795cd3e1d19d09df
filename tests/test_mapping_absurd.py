# SPDX-License-Identifier: Apache-2.0
"""Stances with absurd numbers neither crash the mapper nor corrupt the map."""

import warnings

import numpy as np
import pytest

from psane_mapping.configuration import STRENGTH_METHODS, MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.mapper import TerrainMapper, TerrainSample
from psane_mapping.strength import Rejection

EXTREMES = (0.0, 1e308, -1e308, 1e-308)
DRAWS = 400


def absurd(rng, shape=()):
    """Return finite numbers: of any size and sign, ordinary, small, or the largest there are."""
    ordinary = rng.normal(size=shape)
    any_size = np.sign(ordinary) * 10.0 ** rng.uniform(-300.0, 300.0, shape)
    kinds = (any_size, ordinary, 0.1 * np.abs(ordinary), rng.choice(EXTREMES, shape))
    return np.choose(rng.integers(0, 4, shape), kinds)


def absurd_stance(rng):
    count = int(rng.integers(3, 12))

    def draw(shape):
        return np.abs(rng.normal(size=shape)) if plausible else absurd(rng, shape)

    plausible = rng.random() < 0.7
    measured = draw((count, 3))
    with np.errstate(all='ignore'):
        response = measured / 10.0 ** rng.uniform(-3.0, 3.0) if rng.random() < 0.5 else draw(
            (count, 3))
    return LegContact(
        leg=0, touch_down=0.0, lift_off=float(absurd(rng)), measured=measured,
        point=rng.uniform(0.0, 2.0, 2) if plausible else absurd(rng, 2), depth=draw(count),
        point_deviation=float(absurd(rng)), response=np.nan_to_num(response, posinf=1e308),
        deviation=draw((count, 3)), has_velocity=bool(rng.integers(2)))


@pytest.mark.parametrize('method', STRENGTH_METHODS)
@pytest.mark.parametrize('grow', [False, True])
@pytest.mark.parametrize('least_r_squared', [0.0, 0.9])
def test_a_stance_of_any_numbers_is_taken_or_rejected_and_the_map_stays_sound(
        method, grow, least_r_squared):
    config = MappingConfiguration(
        strength_method=method, grow=grow, max_x=2.0, max_y=2.0, resolution=0.2,
        largest_extent=5.0, least_samples=3, least_response=0.0, least_r_squared=least_r_squared)
    mapper, rng = TerrainMapper(config), np.random.default_rng(7)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        outcomes = [mapper.add(absurd_stance(rng)) for _ in range(DRAWS)]
    assert all(isinstance(outcome, (TerrainSample, Rejection)) for outcome in outcomes)
    assert mapper.accepted + sum(mapper.rejected.values()) == DRAWS
    # Both kinds came, or nothing was tried.
    assert mapper.accepted and mapper.rejected
    maps = mapper.maps()
    for mean in (maps.slip_mean, maps.log_strength_mean):
        assert np.isfinite(mean).all()
    assert (maps.slip_std > 0.0).all() and (maps.slip_std <= config.slip_prior_deviation).all()
    assert (maps.log_strength_std <= config.log_strength_prior_deviation).all()
