# SPDX-License-Identifier: Apache-2.0
"""The screened-Poisson field has no local minimum and measures distance inside the region."""

import numpy as np
import pytest
import shapely

from psane_reactive.errors import MapError
from psane_reactive.field import ScreenedPoissonField
from psane_reactive.region import smooth_parts
from psane_reactive.sample_regions import random_points, random_snake, star_world
from psane_reactive.shortest_path import ShortestPath

# The way runs over the eight directions of a grid: up to 8 % longer, and a cell at each end.
EIGHT_DIRECTIONS = 1.09
ENDS = 0.2


def regions():
    random = np.random.default_rng(31)
    parts = [random_snake(random, 120, 0.3) for _ in range(4)] + [star_world(random, 6, side=6.0)]
    return [smooth_parts(part, 0.01)[0] for part in parts]


@pytest.mark.parametrize('region', regions())
def test_every_cell_but_the_goal_has_a_neighbour_with_a_larger_value(region):
    field = ScreenedPoissonField(region)
    goal = random_points(np.random.default_rng(0), region, 1)[0]
    values = np.pad(field.potential(goal), 1)
    around = np.max([np.roll(values, shift, axis) for shift in (1, -1) for axis in (0, 1)], axis=0)
    is_minimum = ((values > 0.0) & (around <= values))[1:-1, 1:-1]
    assert is_minimum.sum() == 1
    peak = field.grid.point_of(np.argwhere(is_minimum)[0])
    assert np.hypot(*(peak - goal)) < 2.0 * field.grid.resolution


@pytest.mark.parametrize('region', regions()[:2])
def test_it_solves_the_equation_of_its_cells(region):
    length, cell = 0.2, 0.05
    field = ScreenedPoissonField(region, cell, length)
    goal = random_points(np.random.default_rng(1), region, 1)[0]
    values = field.potential(goal)
    flux = np.zeros_like(values)
    inside = field.is_inside
    for axis in (0, 1):
        count = inside.shape[axis] - 1
        centres = field.grid.points.reshape(*inside.shape, 2)
        ends = [np.take(centres, range(k, count + k), axis) for k in (0, 1)]
        lines = shapely.linestrings(np.stack(ends, axis=2))
        # Neighbours are linked where the straight line between them stays inside.
        both = shapely.covers(region, lines)
        step = np.where(both, np.diff(values, axis=axis), 0.0)
        pad = [(0, 0), (0, 0)]
        pad[axis] = (0, 1)
        flux += np.pad(step, pad)
        pad[axis] = (1, 0)
        flux -= np.pad(step, pad)
    residual = values - (length / cell) ** 2 * flux
    at_goal = values == 1.0
    # Relative to each cell's own value: no cell is too far away to be right.
    assert np.abs(residual[inside & ~at_goal] / values[inside & ~at_goal]).max() < 1e-9


@pytest.mark.parametrize('region', regions())
def test_the_way_reaches_every_goal_with_nearly_the_shortest_length(region):
    field, oracle = ScreenedPoissonField(region), ShortestPath(region.simplify(0.004))
    points = random_points(np.random.default_rng(2), region, 24, 0.05)
    for start, goal in zip(points[::2], points[1::2], strict=True):
        shortest = oracle.length(start, goal)
        way = field.way(start, goal, 1e9)
        assert way is not None
        assert way.ends_at_goal
        assert (way.points[-1] == goal).all()
        length = shapely.LineString([start, *way.points]).length
        assert length <= 1.1 * EIGHT_DIRECTIONS * shortest + ENDS
        assert length >= 0.99 * shortest - ENDS


def test_a_corridor_of_eighty_metres_does_not_underflow():
    corridor = shapely.box(0.0, 0.0, 80.0, 0.3)
    field = ScreenedPoissonField(corridor)
    way = field.way(np.array((0.1, 0.15)), np.array((79.9, 0.15)), 1.0)
    assert way is not None
    assert way.points[-1][0] > 0.9


def test_a_goal_in_another_part_has_no_way():
    region = shapely.box(0.0, 0.0, 1.0, 1.0).union(shapely.box(1.0, 0.495, 1.5, 0.5)).union(
        shapely.box(1.5, 0.0, 2.5, 1.0))
    field = ScreenedPoissonField(region)
    assert field.way(np.array((0.5, 0.5)), np.array((2.0, 0.8)), 1.0) is None


def test_a_region_without_a_cell_is_refused():
    with pytest.raises(MapError, match='smaller cells'):
        ScreenedPoissonField(shapely.Polygon([(0, 0), (1, 0.001), (0, 0.002)]), cell=0.5)


def test_shortest_path_around_a_square_is_the_one_past_its_corner():
    region = shapely.Polygon(shapely.box(0, 0, 4, 4).exterior, [shapely.box(1, 1, 3, 3).exterior])
    oracle = ShortestPath(region)
    length = oracle.length(np.array((0.0, 2.0)), np.array((2.0, 0.0)))
    assert length == pytest.approx(2.0 * 2.0**0.5)
    around = oracle.length(np.array((0.5, 2.0)), np.array((3.5, 2.0)))
    assert around == pytest.approx(2.0 + 2.0 * 1.25**0.5)
