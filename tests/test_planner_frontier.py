# SPDX-License-Identifier: Apache-2.0
"""Frontiers, distances along the ground, scores and the strategies' choices."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from psane_mapping.grid import Grid
from psane_planner.chooser import FrontierChooser
from psane_planner.component import component_around
from psane_planner.configuration import PlannerConfiguration
from psane_planner.frontier import expansion_counts, frontier_cells
from psane_planner.geodesic import distance_along, distance_within_reach
from psane_planner.memory import FrontierMemory
from psane_planner.pareto import pareto_front
from psane_planner.scores import score_frontier
from psane_planner.strategies import AVAILABLE, make_strategy
from psane_planner.survey import without_crumbs

GRID = Grid.over_workspace(0.0, 0.0, 4.0, 3.0, 0.1)
CONFIG = PlannerConfiguration()
SEEDS = st.integers(0, 2**32 - 1)
# First-order upwind differences overestimate; the seeds' exact disc keeps it below this share.
EIKONAL_ERROR = 0.04


def blobs(draw, shape=GRID.shape, share=0.5, width=2.0):
    field = ndimage.gaussian_filter(draw.normal(size=shape), width)
    return field <= np.quantile(field, share)


def scored(draw, count=30, eligible=None, points=None):
    points = draw.uniform(0, 3, (count, 2)) if points is None else points
    growth = draw.integers(0, 60, count)
    eligible = growth > 0 if eligible is None else eligible
    return score_frontier(GRID.index_of(points), points, growth, draw.uniform(0, 9, count),
                          eligible, 0.1, 0.1)


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_the_frontier_is_the_components_edge_toward_ground_that_may_be_certified(seed):
    draw = np.random.default_rng(seed)
    certified, admissible = blobs(draw), draw.uniform(size=GRID.shape) < 0.9
    certified &= admissible
    component = component_around(certified, GRID, np.array((2.0, 1.5))).mask
    open_ground = np.pad(admissible & ~certified, 1)
    expected = [(r, c) for r, c in np.argwhere(component)
                if open_ground[r, c + 1] or open_ground[r + 2, c + 1]
                or open_ground[r + 1, c] or open_ground[r + 1, c + 2]]
    found = frontier_cells(component, certified, admissible)
    assert [tuple(cell) for cell in found] == expected


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_the_expansion_count_equals_its_definition(seed):
    draw = np.random.default_rng(seed)
    lower, targets = draw.uniform(-1.0, 0.6, GRID.shape), draw.uniform(size=GRID.shape) < 0.5
    cells = np.column_stack((draw.integers(0, GRID.rows, 15), draw.integers(0, GRID.columns, 15)))
    rows, columns = np.indices(GRID.shape)
    expected = []
    for r, c in cells:
        away = GRID.resolution * np.sqrt(((rows - r) ** 2 + (columns - c) ** 2).astype(float))
        reached = lower[r, c] + CONFIG.lipschitz_constant * away <= CONFIG.slip_threshold
        expected.append(int((targets & reached).sum()))
    assert expansion_counts(cells, lower, targets, CONFIG, 0.1).tolist() == expected


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_on_open_ground_the_way_is_the_straight_distance(seed):
    draw = np.random.default_rng(seed)
    source = draw.uniform((0.0, 0.0), (4.0, 3.0))
    field = distance_along(np.ones(GRID.shape, bool), GRID, source)
    straight = np.hypot(*(GRID.points - source).T).reshape(GRID.shape)
    assert (field >= straight - 1e-9).all()
    assert (field <= straight * (1.0 + EIKONAL_ERROR) + 1e-9).all()


@settings(max_examples=15, deadline=None)
@given(SEEDS)
def test_the_way_around_obstacles_agrees_with_dijkstra(seed):
    draw = np.random.default_rng(seed)
    passable = blobs(draw, share=0.7)
    start = np.argwhere(passable)[draw.integers(passable.sum())]
    field = distance_along(passable, GRID, GRID.point_of(start))
    oracle = eight_neighbour_distance(passable, tuple(start))
    edgewise = eight_neighbour_distance(passable, tuple(start), diagonal=False)
    reached = np.isfinite(edgewise)
    np.testing.assert_array_equal(np.isfinite(field), reached)
    # Steps along edges and diagonals overestimate a straight way by up to 8.24 %, and the scheme
    # may in turn overestimate by its own error; a diagonal step through a corner gap, which only
    # the oracle takes, is what the one cell allows for.
    assert (field[reached] <= edgewise[reached] + 1e-6).all()
    assert (field[reached] >= oracle[reached] / 1.0824 - 1e-6).all()


def eight_neighbour_distance(passable, start, diagonal=True):
    index = np.arange(passable.size).reshape(passable.shape)
    rows, columns, lengths = [], [], []
    steps = [(0, 1), (1, 0)] + ([(1, 1), (1, -1)] if diagonal else [])
    for dr, dc in steps:
        for r, c in np.argwhere(passable):
            i, j = r + dr, c + dc
            if i < passable.shape[0] and 0 <= j < passable.shape[1] and passable[i, j]:
                rows.append(index[r, c])
                columns.append(index[i, j])
                lengths.append(0.1 * math.hypot(dr, dc))
    graph = coo_matrix((lengths, (rows, columns)), shape=(passable.size, passable.size))
    return dijkstra(graph.tocsr(), directed=False,
                    indices=index[start]).reshape(passable.shape)


def test_a_wall_makes_the_way_longer_and_a_closed_one_endless():
    passable = np.ones(GRID.shape, bool)
    passable[:25, 20] = False
    way = distance_along(passable, GRID, np.array((1.9, 0.5)))
    around = 2.0 + math.hypot(0.1, 0.0)
    assert way[5, 21] > 2.0 * around * 0.95
    passable[:, 20] = False
    assert np.isinf(distance_along(passable, GRID, np.array((1.9, 0.5)))[5, 21])


def test_a_source_off_the_ground_begins_with_a_step_to_it():
    passable = np.zeros(GRID.shape, bool)
    passable[10, 10:20] = True
    way = distance_along(passable, GRID, np.array((0.7, 1.0)))
    assert math.isclose(way[10, 10], 0.3, abs_tol=1e-9)
    assert math.isclose(way[10, 19], 1.2, abs_tol=1e-9)
    assert np.isinf(distance_along(np.zeros(GRID.shape, bool), GRID, np.zeros(2))).all()


def test_cells_beside_the_way_are_reached_within_reach_only():
    field = np.full(GRID.shape, np.inf)
    field[10, 10] = 1.0
    cells = np.array(((10, 10), (10, 14), (10, 15)))
    reached = distance_within_reach(field, cells, GRID, 0.45)
    np.testing.assert_allclose(reached, (1.0, 1.4, np.inf))


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(0, 40), st.integers(1, 12))
def test_the_pareto_front_equals_its_definition(seed, count, levels):
    draw = np.random.default_rng(seed)
    first, second = (draw.integers(0, levels, count) / levels for _ in range(2))
    expected = [not any(first[j] >= first[i] and second[j] >= second[i]
                        and (first[j] > first[i] or second[j] > second[i])
                        for j in range(count)) for i in range(count)]
    assert pareto_front(first, second).tolist() == expected


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_scores_follow_the_papers_formulas(seed):
    draw = np.random.default_rng(seed)
    growth, way = draw.integers(0, 80, 20), draw.uniform(0, 20, 20)
    scores = score_frontier(np.zeros((20, 2), int), np.zeros((20, 2)), growth, way,
                            np.ones(20, bool), 0.1, 0.1)
    for k in range(20):
        assert math.isclose(scores.expansion[k], 1 - math.exp(-0.1 * growth[k]), abs_tol=1e-12)
        assert math.isclose(scores.goal_value[k], math.exp(-0.1 * way[k]))
        assert math.isclose(scores.overall[k], scores.expansion[k] * scores.goal_value[k])


@pytest.mark.parametrize('name', sorted(AVAILABLE))
@settings(max_examples=20, deadline=None)
@given(seed=SEEDS)
def test_every_strategy_chooses_an_eligible_cell(name, seed):
    draw = np.random.default_rng(seed)
    scores = scored(draw)
    strategy = make_strategy(name)
    assert all(scores.eligible[strategy.choose(scores)] for _ in range(4))


@pytest.mark.parametrize('name', ['psane', 'psane_geodesic'])
def test_psane_takes_the_best_product_of_all(name):
    for seed in range(20):
        scores = scored(np.random.default_rng(seed))
        chosen = make_strategy(name).choose(scores)
        assert scores.overall[chosen] == scores.overall[scores.eligible].max()
        assert scores.pareto[chosen]


def test_pgh_gives_the_goal_two_turns_of_three():
    scores = scored(np.random.default_rng(3))
    pgh = make_strategy('pgh')
    by_goal = np.flatnonzero(scores.pareto)[np.argmax(scores.goal_value[scores.pareto])]
    by_growth = np.flatnonzero(scores.pareto)[np.argmax(scores.expansion[scores.pareto])]
    assert by_goal != by_growth
    assert [pgh.choose(scores) for _ in range(6)] == [by_goal, by_goal, by_growth] * 2


def test_sgh_looks_at_the_goal_alone():
    scores = scored(np.random.default_rng(4), eligible=np.ones(30, bool))
    assert make_strategy('sgh').choose(scores) == np.argmax(scores.goal_value)


def two_frontiers(first, second):
    """Two distant frontiers of one cell each, with the given overall scores."""
    points = np.array(((0.5, 0.5), (3.5, 2.5)))
    way = -np.log(np.array((first, second)) / (1.0 - math.exp(-1.0)))
    return score_frontier(GRID.index_of(points), points, np.array((10, 10)), way,
                          np.ones(2, bool), 0.1, 1.0)


def test_two_frontiers_of_like_merit_do_not_pull_the_robot_to_and_fro():
    chooser = FrontierChooser(CONFIG, GRID, make_strategy('psane_geodesic'))
    everywhere = np.ones(GRID.shape, bool)
    chosen = [tuple(chooser.choose(two_frontiers(0.5 + e, 0.5 - e), everywhere, False))
              for e in (0.01, -0.01, 0.02, -0.02, -0.05)]
    assert set(chosen) == {(5, 5)} and chooser.changes == 1
    assert tuple(chooser.choose(two_frontiers(0.3, 0.5), everywhere, False)) == (25, 35)


def test_the_papers_strategies_keep_their_subgoal_until_they_arrive():
    chooser = FrontierChooser(CONFIG, GRID, make_strategy('psane'))
    everywhere = np.ones(GRID.shape, bool)
    assert tuple(chooser.choose(two_frontiers(0.5, 0.4), everywhere, False)) == (5, 5)
    assert tuple(chooser.choose(two_frontiers(0.1, 0.5), everywhere, False)) == (5, 5)
    assert tuple(chooser.choose(two_frontiers(0.1, 0.5), everywhere, True)) == (25, 35)


def test_a_held_subgoal_that_is_no_longer_certified_is_dropped():
    chooser = FrontierChooser(CONFIG, GRID, make_strategy('psane'))
    component = np.ones(GRID.shape, bool)
    chooser.choose(two_frontiers(0.5, 0.4), component, False)
    component[5, 5] = False
    assert tuple(chooser.choose(two_frontiers(0.1, 0.5), component, False)) == (25, 35)


def stay(memory, point, count, start, duration):
    for tick in range(round(duration / 0.25)):
        memory.note_stay(point, count, start + 0.25 * tick)


def test_a_frontier_rests_after_five_arrivals_without_growth_and_then_returns():
    memory, point = FrontierMemory(CONFIG), np.array((1.0, 1.0))
    stay(memory, point, 40, 0.0, 5 * CONFIG.dwell_time)
    assert not memory.is_resting(point[None], 7.25).any()
    memory.note_stay(point, 40, 5 * CONFIG.dwell_time)
    points = np.array(((1.0, 1.0), (1.2, 1.1), (1.5, 1.0)))
    assert memory.is_resting(points, 8.0).tolist() == [True, True, False]
    assert memory.is_resting(points, 7.4 + CONFIG.rest_time).any()
    assert not memory.is_resting(points, 7.5 + CONFIG.rest_time).any()


def test_resting_frontiers_can_be_woken():
    memory, point = FrontierMemory(CONFIG), np.array((1.0, 1.0))
    memory.set_aside(point, 0.0)
    assert memory.is_resting(point[None], 1.0).all()
    memory.wake()
    assert not memory.is_resting(point[None], 1.0).any()


def test_crumbs_wait_until_no_other_frontier_is_left():
    growth = np.array((1.0, 30.0, 4.0, 3.9, 50.0))
    eligible = np.array((True, True, True, True, False))
    assert without_crumbs(eligible, growth, 4.0).tolist() == [False, True, True, False, False]
    eligible[1:3] = False
    assert without_crumbs(eligible, growth, 4.0).tolist() == [True, False, False, True, False]


def test_a_frontier_that_grows_never_rests():
    memory, point = FrontierMemory(CONFIG), np.array((1.0, 1.0))
    for tick in range(200):
        memory.note_stay(point, 40 + tick // 20, 0.25 * tick)
    assert not memory.is_resting(point[None], 50.0).any()


def test_ground_certified_and_revoked_in_turn_does_not_pass_for_growth():
    memory, point = FrontierMemory(CONFIG), np.array((1.0, 1.0))
    for tick in range(60):
        memory.note_stay(point, 40 + tick % 2, 0.25 * tick)
    assert memory.is_resting(point[None], 15.0).all()
