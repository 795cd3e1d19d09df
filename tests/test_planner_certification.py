# SPDX-License-Identifier: Apache-2.0
"""Confidence intervals and certified cells: what may never happen, and brute force beside it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from psane_mapping.errors import ParameterError
from psane_mapping.grid import Grid
from psane_planner.component import component_around
from psane_planner.confidence import Bounds, ConfidenceIntervals
from psane_planner.configuration import STRATEGIES, PlannerConfiguration
from psane_planner.discs import NO_DISC, count_in_discs, squared_radii, union_of_discs
from psane_planner.errors import MapError, StrategyError
from psane_planner.safe_set import SafeSet, admissible_cells, propagate
from psane_planner.strategies import AVAILABLE, make_strategy

GRID = Grid.over_workspace(0.0, 0.0, 3.0, 2.5, 0.1)
CENTRE = np.array((1.5, 1.2))
SEEDS = st.integers(0, 2**32 - 1)


def smooth_field(draw, shape=GRID.shape, width=2.0):
    field = ndimage.gaussian_filter(draw.normal(size=shape), width)
    return (field - field.min()) / (field.max() - field.min())


def test_a_map_changed_in_place_is_seen_and_one_that_cannot_change_is_not_looked_at_twice():
    intervals = ConfidenceIntervals(GRID.shape, 4.0, 1.0)
    mean, std = np.full(GRID.shape, 0.2), np.full(GRID.shape, 0.05)
    first = intervals.update(mean, std)
    mean[3, 4] = 0.6
    second = intervals.update(mean, std)
    assert second.version == first.version + 1 and second.newest[3, 4] == pytest.approx(0.65)
    frozen = mean.copy()
    for array in (frozen, std):
        array.setflags(write=False)
    assert intervals.update(frozen, std).version == second.version
    assert intervals.update(frozen, std) == intervals.update(frozen, std)


def lipschitz_union_by_pairs(previous, upper, config, resolution):
    """Test each pair of cells literally: u(x) + L |x - x'| <= h for some x in S_{t-1}."""
    rows, columns = np.indices(upper.shape)
    result = np.zeros(upper.shape, bool)
    for r, c in np.argwhere(previous):
        distance = resolution * np.sqrt(((rows - r) ** 2 + (columns - c) ** 2).astype(float))
        result |= upper[r, c] + config.lipschitz_constant * distance <= config.slip_threshold
    return result


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_intervals_only_narrow_except_where_they_are_reset(seed):
    draw = np.random.default_rng(seed)
    intervals = ConfidenceIntervals(GRID.shape, 4.0, 1.0)
    before = intervals.update(draw.uniform(0, 1, GRID.shape), draw.uniform(0, 0.3, GRID.shape))
    for _ in range(4):
        mean, std = draw.uniform(0, 1, GRID.shape), draw.uniform(0, 0.3, GRID.shape)
        after = intervals.update(mean, std)
        nested = (after.lower >= before.lower) & (after.upper <= before.upper)
        fresh = (after.lower == mean - 2 * std) & (after.upper == mean + 2 * std)
        apart = (mean - 2 * std > before.upper) | (mean + 2 * std < before.lower)
        assert (nested | (apart & fresh)).all()
        assert after.resets == apart.sum()
        assert (after.lower <= after.upper).all()
        before = after


def test_resets_are_counted_over_all_updates():
    intervals = ConfidenceIntervals((1, 2), 4.0, 1.0)
    for mean in (0.1, 0.9, 0.1):
        intervals.update(np.full((1, 2), mean), np.full((1, 2), 0.01))
    assert intervals.total_resets == 4


def test_a_cell_that_lost_its_estimate_starts_over():
    intervals = ConfidenceIntervals((1, 2), 4.0, 1.0)
    intervals.update(np.array([[0.1, 0.1]]), np.array([[0.01, 0.01]]))
    bounds = intervals.update(np.array([[np.nan, 0.1]]), np.array([[0.01, 0.01]]))
    assert bounds.upper[0, 0] == np.inf and bounds.lower[0, 0] == -np.inf
    assert np.isfinite(bounds.upper[0, 1]) and bounds.resets == 0


@pytest.mark.parametrize(('mean', 'std', 'word'), [
    (np.zeros((2, 2)), np.zeros((1, 2)), 'shape'),
    (np.array([[np.inf, 0.0]]), np.zeros((1, 2)), 'infinite'),
    (np.zeros((1, 2)), np.array([[-0.1, 0.0]]), 'negative')])
def test_a_map_that_means_nothing_is_refused_with_a_sentence(mean, std, word):
    with pytest.raises(MapError, match=word):
        ConfidenceIntervals((1, 2), 4.0, 1.0).update(mean, std)


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.sampled_from([0.5, 2.0, 7.3]), st.sampled_from([0.05, 0.1, 0.13]),
       st.booleans())
def test_the_lipschitz_union_equals_brute_force_exactly(seed, slope, resolution, on_ties):
    draw = np.random.default_rng(seed)
    config = PlannerConfiguration(lipschitz_constant=slope)
    upper = draw.uniform(-1.5, 0.8, (draw.integers(1, 30), draw.integers(1, 30)))
    if on_ties:
        # Bounds on multiples of L * resolution put many pairs exactly on the threshold.
        step = slope * resolution
        upper = config.slip_threshold - step * np.round((0.5 - upper) / step)
    upper[draw.uniform(size=upper.shape) < 0.1] = np.inf
    previous = draw.uniform(size=upper.shape) < draw.uniform(0, 0.4)
    fast = propagate(previous, upper, config, resolution)
    np.testing.assert_array_equal(
        fast, lipschitz_union_by_pairs(previous, upper, config, resolution))


def test_propagation_starts_from_formerly_certified_cells_only():
    config = PlannerConfiguration()
    upper = np.full((9, 9), -1.0)
    nothing = np.zeros((9, 9), bool)
    assert not propagate(nothing, upper, config, 0.1).any()


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_counts_in_discs_equal_brute_force(seed):
    draw = np.random.default_rng(seed)
    targets = draw.uniform(size=(17, 23)) < 0.5
    cells = np.column_stack((draw.integers(0, 17, 12), draw.integers(0, 23, 12)))
    radii = draw.integers(-1, 120, 12)
    rows, columns = np.indices(targets.shape)
    expected = [int((targets & ((rows - r) ** 2 + (columns - c) ** 2 <= m)).sum())
                for (r, c), m in zip(cells, radii, strict=True)]
    assert count_in_discs(targets, cells, radii).tolist() == expected


def test_no_disc_covers_anything():
    assert not union_of_discs(np.full((4, 5), NO_DISC)).any()
    assert squared_radii(np.array([np.nan, np.inf, 0.51]), 0.5, 2.0, 0.1, 50).tolist() == [-1] * 3


def test_a_disc_reaches_exactly_to_the_threshold_and_no_further():
    # h - u = 0.25, L = 2.5 /m: 0.1 m exactly in real numbers, one cell of 0.1 m.
    radius = squared_radii(np.array([0.25]), 0.5, 2.5, 0.1, 50)[0]
    assert radius == 1
    above = squared_radii(np.array([0.25 + 1e-12]), 0.5, 2.5, 0.1, 50)[0]
    assert above == 0


@pytest.mark.parametrize('rule', ['bound', 'lipschitz'])
@settings(max_examples=25, deadline=None)
@given(seed=SEEDS)
def test_certificates_respect_threshold_border_and_keep_out(rule, seed):
    draw = np.random.default_rng(seed)
    config = PlannerConfiguration(certification=rule)
    safe_set, intervals = SafeSet(config, GRID), ConfidenceIntervals(GRID.shape, 4.0, 1.0)
    keep_out = draw.uniform(size=GRID.shape) < 0.05
    admissible = admissible_cells(GRID, config.border_width, keep_out)
    near_border = GRID.distance_to_border() <= 0.3 + 1e-9
    for _ in range(4):
        mean = smooth_field(draw)
        std = np.full(GRID.shape, 0.08)
        bounds = intervals.update(mean, std)
        certified = safe_set.update(bounds, std, admissible, CENTRE)
        assert not (certified & (near_border | keep_out)).any()
        if rule == 'bound':
            assert (bounds.upper[certified] <= 0.5).all()
            assert (mean[certified] + 0.08 <= 0.5).all()


@pytest.mark.parametrize(('mean', 'std', 'is_kept'), [
    (0.56, 0.1, False), (0.45, 0.1, False), (0.38, 0.1, True)])
def test_a_certificate_is_revoked_when_the_newest_map_speaks_against_it(mean, std, is_kept):
    safe_set, intervals = SafeSet(PlannerConfiguration(), GRID), ConfidenceIntervals(
        GRID.shape, 4.0, 1.0)
    everywhere = np.ones(GRID.shape, bool)
    for value, deviation, expected in ((0.3, 0.05, True), (mean, std, is_kept)):
        spread = np.full(GRID.shape, deviation)
        bounds = intervals.update(np.full(GRID.shape, value), spread)
        assert (bounds.upper <= 0.5).all(), 'the old interval alone would still certify'
        assert safe_set.update(bounds, spread, everywhere, CENTRE).all() == expected


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_no_cell_is_certified_beyond_the_reach_of_what_was_felt(seed):
    draw = np.random.default_rng(seed)
    config = PlannerConfiguration()
    mean = 0.4 * smooth_field(draw)
    std = np.where(draw.uniform(size=GRID.shape) < 0.03, 0.05, 0.102)
    bounds = ConfidenceIntervals(GRID.shape, 0.0, 1.0).update(mean, std)
    certified = SafeSet(config, GRID).update(bounds, std, np.ones(GRID.shape, bool), CENTRE)
    rows, columns = np.indices(GRID.shape)
    reached = np.zeros(GRID.shape, bool)
    for r, c in np.argwhere(std <= config.felt_deviation):
        away = GRID.resolution * np.hypot(rows - r, columns - c)
        reached |= mean[r, c] + std[r, c] + config.felt_slope * away <= config.slip_threshold
    np.testing.assert_array_equal(certified, reached & (mean + std <= config.slip_threshold))


def test_a_slope_of_zero_trusts_the_map_alone():
    config = PlannerConfiguration(felt_slope=0.0)
    std = np.full(GRID.shape, 0.15)
    bounds = ConfidenceIntervals(GRID.shape, 4.0, 1.0).update(np.zeros(GRID.shape), std)
    everywhere = np.ones(GRID.shape, bool)
    assert SafeSet(config, GRID).update(bounds, std, everywhere, CENTRE).all()
    assert not SafeSet(PlannerConfiguration(), GRID).update(bounds, std, everywhere,
                                                            CENTRE).any()


@settings(max_examples=20, deadline=None)
@given(SEEDS, st.sampled_from(['bound', 'lipschitz']))
def test_monotone_sets_never_shrink(seed, rule):
    draw = np.random.default_rng(seed)
    config = PlannerConfiguration(certification=rule, monotone=True)
    safe_set, intervals = SafeSet(config, GRID), ConfidenceIntervals(GRID.shape, 4.0, 1.0)
    admissible = admissible_cells(GRID, config.border_width)
    before = np.zeros(GRID.shape, bool)
    for _ in range(5):
        mean = smooth_field(draw)
        std = np.full(GRID.shape, draw.uniform(0.02, 0.1))
        bounds = intervals.update(mean, std)
        after = safe_set.update(bounds, std, admissible, CENTRE)
        assert not (before & ~after).any()
        before = after


def test_the_first_lipschitz_set_is_the_component_around_the_robot():
    upper = np.full(GRID.shape, 0.9)
    upper[8:16, 10:18] = 0.4
    upper[8:16, 22:27] = 0.4
    bounds = Bounds(np.zeros(GRID.shape), upper, upper, 0)
    safe_set = SafeSet(PlannerConfiguration(certification='lipschitz'), GRID)
    first = safe_set.update(bounds, np.zeros(GRID.shape), admissible_cells(GRID, 0.3),
                            np.array((1.3, 1.2)))
    assert first[8:16, 10:18].all() and first.sum() == 64


def test_cells_that_meet_at_a_corner_are_not_connected():
    certified = np.zeros(GRID.shape, bool)
    certified[5, 5] = certified[6, 6] = True
    component = component_around(certified, GRID, np.array((0.5, 0.5)))
    assert component.mask.sum() == 1 and component.outside_distance == 0.0


def test_the_distance_outside_is_to_the_square_and_not_to_its_centre():
    certified = np.zeros(GRID.shape, bool)
    certified[5, 5] = True
    away = component_around(certified, GRID, np.array((0.75, 0.5))).outside_distance
    assert math.isclose(away, 0.2)
    none = component_around(np.zeros(GRID.shape, bool), GRID, CENTRE)
    assert none.outside_distance == math.inf and not none.mask.any()


def test_every_file_of_a_strategy_is_found_by_its_name_and_no_other():
    assert {'psane_geodesic', 'psane', 'pgh', 'sgh', 'ngh'} == set(STRATEGIES)
    assert all(kind.__module__.endswith(f'.{name}') for name, kind in AVAILABLE.items())
    with pytest.raises(StrategyError, match="unknown strategy 'fast'"):
        make_strategy('fast')


@pytest.mark.parametrize('bad', [
    {'slip_threshold': 1.2}, {'strategy': 'fast'}, {'certification': 'hope'},
    {'confidence_scale': math.nan}, {'found_distance': 0.4, 'lost_distance': 0.3},
    {'contour_tolerance': 0.1, 'clearance': 0.05}])
def test_a_parameter_out_of_range_is_refused(bad):
    with pytest.raises(ParameterError, match=next(iter(bad))):
        PlannerConfiguration(**bad)
