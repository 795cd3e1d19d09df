# SPDX-License-Identifier: Apache-2.0
"""The deviation of slip is wider where stances were riskier than the map had promised."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.gaussian_process import Innovation
from psane_mapping.grid import Grid
from psane_mapping.mapper import TerrainMapper, TerrainSample
from psane_mapping.surprise import SurpriseMap
from psane_planner.presets import PRESETS

GRID = Grid.over_workspace(0.0, 0.0, 4.0, 4.0, 0.1)
HERE = np.array((2.0, 2.0))


def surprises(reach=0.15, trust=2.0, allowance=2.0):
    return SurpriseMap(GRID, reach, trust, allowance)


def at(array, point, grid=GRID):
    return array[tuple(grid.index_of(np.array(point)))]


def sample(x, y, slip, time=0.0):
    return TerrainSample(time=time, point=np.array((x, y)), leg=0, strength=0.2,
                         log_strength_deviation=0.1, slip=slip, slip_deviation=0.04)


def walk(mapper, strip):
    """Feel rows of firm ground with a strip of soft ground, 0.2 m wide, between y 1.9 and 2.1."""
    for x in np.arange(1.0, 3.0, 0.1):
        for y in (*np.arange(1.0, 1.85, 0.1), *np.arange(2.2, 3.05, 0.1)):
            mapper.take(sample(x, y, 0.3))
    for x in np.arange(1.6, 2.4, 0.1):
        mapper.take(sample(x, 1.95, strip))
    return mapper.maps()


def mapper(**changes):
    return TerrainMapper(MappingConfiguration(max_x=4.0, max_y=4.0, **changes))


def test_a_soft_strip_that_is_smoothed_over_is_not_called_certain():
    plain, wary = (walk(mapper(surprise_reach=reach), 0.65) for reach in (0.0, 0.15))
    assert wary.slip_mean == pytest.approx(plain.slip_mean, abs=0.0)
    here = (2.0, 2.0)
    # A planner gives a certificate up where mean + std exceeds the threshold, 0.5.
    assert at(plain.slip_mean, here) + at(plain.slip_std, here) < 0.5
    assert at(wary.slip_mean, here) + at(wary.slip_std, here) > 0.5
    away = np.hypot(*(GRID.points - HERE).T).reshape(GRID.shape) > 1.2
    np.testing.assert_array_equal(wary.slip_std[away], plain.slip_std[away])


def test_ground_as_promised_or_firmer_changes_nothing():
    for strip in (0.3, 0.1):
        plain, wary = (walk(mapper(surprise_reach=reach), strip) for reach in (0.0, 0.15))
        np.testing.assert_array_equal(wary.slip_std, plain.slip_std)


def test_stances_of_an_honest_map_widen_next_to_nothing():
    made, random = surprises(), np.random.default_rng(0)
    for point in random.uniform(1.0, 3.0, (3000, 2)):
        made.add(point, Innovation(0.05 * random.normal(), 0.05), 0.0)
    factor = made.factor()
    assert (factor > 1.0).mean() < 0.02
    assert factor.max() < 1.2


@given(st.lists(st.tuples(st.floats(-1.0, 5.0), st.floats(-1.0, 5.0), st.floats(-1e3, 1e3)),
                max_size=30))
def test_the_factor_is_bounded_whatever_is_felt_and_wherever(stances):
    made = surprises()
    for x, y, value in stances:
        made.add(np.array((x, y)), Innovation(value, 0.05), 0.02)
    factor = made.factor()
    assert (factor >= 1.0).all()
    assert (factor <= 4.0 + 1e-9).all()


def test_an_innovation_that_is_no_number_is_left_out():
    made = surprises()
    made.add(HERE, Innovation(np.nan, np.nan), 0.0)
    assert (made.factor() == 1.0).all()


def test_a_common_error_is_no_surprise():
    strict, lenient = surprises(), surprises()
    for _ in range(10):
        strict.add(HERE, Innovation(0.15, 0.05), 0.0)
        lenient.add(HERE, Innovation(0.15, 0.05), 0.15)
    assert at(strict.factor(), HERE) > 1.5
    assert at(lenient.factor(), HERE) == 1.0


def test_a_map_that_grows_takes_its_surprises_along():
    fixed, growing = (TerrainMapper(MappingConfiguration(max_x=4.0, max_y=4.0, grow=grow))
                      for grow in (False, True))
    stances = [sample(2.0, 1.0 + 0.1 * k, 0.3) for k in range(20)]
    stances += [sample(2.0, 2.0, 0.7)] * 4
    for stance in stances:
        fixed.take(stance)
        growing.take(stance)
    growing.take(sample(-3.0, -2.0, 0.3))
    # On ground that the map has only just grown to, surprises count too.
    for stance in [sample(-3.0, -2.0, 0.9)] * 4:
        growing.take(stance)
    known, larger = fixed.maps(), growing.maps()
    assert larger.grid.shape != known.grid.shape
    assert at(known.slip_std, HERE) > 1.5 * at(known.slip_std, (2.0, 1.3))
    for place in ((2.0, 2.0), (2.0, 1.8), (2.2, 2.1), (2.0, 1.3)):
        place = np.array(place) + 0.01
        assert at(larger.slip_std, place, larger.grid) == pytest.approx(
            at(known.slip_std, place), rel=0.02)
    assert at(larger.slip_std, (-2.99, -1.99), larger.grid) > 0.05


def test_a_growing_map_can_be_shown_before_anything_was_felt():
    made = mapper(grow=True)
    maps = made.maps()
    assert maps.slip_std.shape == maps.grid.shape == made.grid.shape
    assert maps.slip_std == pytest.approx(0.5)


@pytest.mark.parametrize('seed', range(3))
def test_the_order_of_stances_matters_only_near_a_surprise(seed):
    made, other = mapper(), mapper()
    walk(made, 0.65)
    random = np.random.default_rng(seed)
    points = [(x, y, 0.3) for x in np.arange(1.0, 3.0, 0.1)
              for y in (*np.arange(1.0, 1.85, 0.1), *np.arange(2.2, 3.05, 0.1))]
    points += [(x, 1.95, 0.65) for x in np.arange(1.6, 2.4, 0.1)]
    for number in random.permutation(len(points)):
        other.take(sample(*points[number]))
    one, two = made.maps(), other.maps()
    assert two.slip_mean == pytest.approx(one.slip_mean, abs=1e-8)
    away = np.abs(GRID.points[:, 1] - 1.95).reshape(GRID.shape) > 0.6
    assert two.slip_std[away] == pytest.approx(one.slip_std[away], rel=0.1)


def test_a_reset_forgets_surprises():
    made = mapper()
    walk(made, 0.65)
    made.reset()
    assert made.maps().slip_std == pytest.approx(mapper().maps().slip_std)


def test_the_published_runs_know_no_surprise():
    assert PRESETS['published'].mapping.surprise_reach == 0.0
    assert PRESETS['default'].mapping.surprise_reach > 0.0
