# SPDX-License-Identifier: Apache-2.0
"""How likely ground is safe, and what a way to the goal costs over ground that may not be."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm

from psane_mapping.grid import Grid
from psane_planner.confidence import ConfidenceIntervals
from psane_planner.geodesic import distance_along
from psane_planner.prospects import WHOLE, Prospects

GRID = Grid(origin_x=0.0, origin_y=0.0, resolution=0.1, rows=30, columns=40)
BETA, H = 4.0, 0.5
EVERYWHERE = np.ones(GRID.shape, dtype=bool)
SEEDS = st.integers(0, 2**32 - 1)
ALL = np.argwhere(EVERYWHERE)


def bounds_of(mean, std):
    return ConfidenceIntervals(GRID.shape, BETA, 1.0).update(mean, std)


def random_map(seed):
    draw = np.random.default_rng(seed)
    return draw.uniform(0.0, 1.0, GRID.shape), draw.uniform(0.02, 0.4, GRID.shape)


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_weights_are_the_normal_probability_and_zero_where_the_interval_excludes_it(seed):
    mean, std = random_map(seed)
    weights = Prospects(GRID, BETA, H).weights(bounds_of(mean, std), EVERYWHERE)
    expected = norm.cdf((H - mean) / std)
    expected[mean - 2.0 * std > H] = 0.0
    expected[mean + 2.0 * std <= H] = 1.0
    # A weight is rounded up to whole parts.
    assert (weights >= WHOLE * expected - 1e-6).all()
    assert (weights <= WHOLE * expected + 1.0 + 1e-6).all()


@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_keeping_up_with_changes_equals_starting_anew(seed):
    draw = np.random.default_rng(seed)
    intervals, prospects = ConfidenceIntervals(GRID.shape, BETA, 1.0), Prospects(GRID, BETA, H)
    mean, std = random_map(seed)
    for k in range(6):
        row, column = draw.integers(0, 25, 2)
        mean[row:row + 4, column:column + 5] += draw.normal(0.0, 0.1)
        std[row:row + 4, column:column + 5] *= 0.8
        bounds = intervals.update(mean, std)
        # Now and then nobody asks: what changed meanwhile must not be missed.
        if k in (1, 2):
            continue
        np.testing.assert_array_equal(prospects.weights(bounds, EVERYWHERE),
                                      Prospects(GRID, BETA, H).weights(bounds, EVERYWHERE))


def test_over_ground_that_is_safe_for_certain_the_way_is_the_distance():
    low, high = np.full(GRID.shape, 0.1), np.full(GRID.shape, 0.01)
    goal = np.array((3.0, 2.0))
    way = Prospects(GRID, BETA, H).way_to(goal, bounds_of(low, high), EVERYWHERE, ALL)
    straight = distance_along(EVERYWHERE, GRID, goal).ravel()
    # Only the two cells around the goal are exact, elsewhere it is a first-order scheme.
    np.testing.assert_allclose(way, straight, rtol=0.1, atol=0.05)


@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_a_way_is_never_shorter_than_the_distance_and_grows_with_slip(seed):
    mean, std = random_map(seed)
    # A goal that nothing can stand on is begun from beside it, which is another way.
    mean[16:24, 26:34], std[16:24, 26:34] = 0.1, 0.02
    goal = np.array((3.0, 2.0))
    way = Prospects(GRID, BETA, H).way_to(goal, bounds_of(mean, std), EVERYWHERE, ALL)
    worse = Prospects(GRID, BETA, H).way_to(goal, bounds_of(mean + 0.05, std), EVERYWHERE, ALL)
    straight = np.hypot(*(GRID.points - goal).T)
    assert (way >= straight - 0.05).all()
    assert (worse >= way - 1e-9).all()


def wall(mean):
    """Return a map of firm ground with a wall of slip `mean` across it, which has a gap."""
    slip, std = np.full(GRID.shape, 0.1), np.full(GRID.shape, 0.05)
    slip[:26, 20:23], std[:26, 20:23] = mean, 0.15
    return bounds_of(slip, std)


@pytest.mark.parametrize(('slip', 'is_around'), [(0.2, False), (0.75, True)])
def test_a_wall_that_is_likely_unsafe_is_gone_around_long_before_it_is_certain(slip, is_around):
    start, goal = np.array([[5, 5]]), np.array((3.5, 0.55))
    way = Prospects(GRID, BETA, H).way_to(goal, wall(slip), EVERYWHERE, start)[0]
    through = 3.0
    assert (way > through + 1.5) == is_around and np.isfinite(way)


def test_known_unsafe_ground_cannot_be_passed_at_all():
    slip, std = np.full(GRID.shape, 0.1), np.full(GRID.shape, 0.05)
    slip[:, 20:23] = 0.9
    way = Prospects(GRID, BETA, H).way_to(np.array((3.5, 1.0)), bounds_of(slip, std), EVERYWHERE,
                                          np.array([[5, 5], [5, 30]]))
    assert np.isinf(way[0]) and np.isfinite(way[1])


def test_on_a_large_grid_blocks_agree_with_cells():
    large = Grid(origin_x=0.0, origin_y=0.0, resolution=0.1, rows=600, columns=500)
    everywhere = np.ones(large.shape, dtype=bool)
    mean, std = np.full(large.shape, 0.1), np.full(large.shape, 0.01)
    mean[:400, 200:230] = 0.9
    bounds = ConfidenceIntervals(large.shape, BETA, 1.0).update(mean, std)
    goal = np.array((40.0, 10.0))
    cells = np.argwhere(everywhere)[::977]
    way = Prospects(large, BETA, H).way_to(goal, bounds, everywhere, cells)
    exact = distance_along(mean < 0.5, large, goal)[cells[:, 0], cells[:, 1]]
    reached = np.isfinite(exact)
    # Two blocks of three cells, and the scheme's own error on coarser cells.
    np.testing.assert_allclose(way[reached], exact[reached], rtol=0.06, atol=0.6)
