# SPDX-License-Identifier: Apache-2.0
"""Ground known beforehand: masks of any grid on the planner's, and what they do to a plan."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.grid import Grid
from psane_planner.configuration import PlannerConfiguration
from psane_planner.errors import MapError
from psane_planner.given_areas import covered, touched
from psane_planner.given_maps import GivenMaps
from psane_planner.planner import SafePlanner

GRID = Grid.over_workspace(0.0, 0.0, 3.0, 2.5, 0.1)


def squares(grid, mask):
    half = grid.resolution / 2.0
    points = grid.point_of(np.argwhere(mask))
    return shapely.union_all([shapely.box(x - half, y - half, x + half, y + half)
                              for x, y in points])


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.03, 0.07, 0.1, 0.23, 0.5]))
def test_masks_agree_with_the_squares_they_stand_for(seed, resolution):
    draw = np.random.default_rng(seed)
    other = Grid(origin_x=draw.uniform(-0.5, 0.5), origin_y=draw.uniform(-0.5, 0.5),
                 resolution=resolution, rows=max(2, round(2.0 / resolution)),
                 columns=max(2, round(2.5 / resolution)))
    mask = draw.uniform(size=other.shape) < 0.3
    marked = squares(other, mask)
    near, full = touched(GRID, other, mask), covered(GRID, other, mask)
    half = GRID.resolution / 2.0
    for row, column in draw.integers(0, GRID.shape, (40, 2)):
        x, y = GRID.point_of(np.array((row, column)))
        cell = shapely.box(x - half, y - half, x + half, y + half)
        shared = cell.intersection(marked).area
        if shared > 1e-6:
            assert near[row, column]
        elif cell.distance(marked) > 1e-6:
            assert not near[row, column]
        if shared < cell.area - 1e-6:
            assert not full[row, column]


def plan_with(**masks):
    grid = Grid.over_workspace(0.0, 0.0, 6.0, 5.0, 0.1)
    planner = SafePlanner(PlannerConfiguration(), grid)
    away = np.hypot(*(grid.points - (2.0, 2.0)).T).reshape(grid.shape)
    mean, std = np.where(away < 1.0, 0.1, 0.0), np.where(away < 1.0, 0.03, 0.5)
    given = {name: make(grid) for name, make in masks.items()}
    return grid, planner.update(mean, std, np.array((2.0, 2.0, 0.0)), None, 0.0, **given)


def test_ground_to_keep_out_of_is_never_certified_and_never_in_the_region():
    def stripe(grid):
        return np.tile((grid.x > 2.4) & (grid.x < 2.6), (grid.rows, 1))
    grid, plan = plan_with(keep_out=stripe)
    assert plan.component.any() and not (plan.certified & stripe(grid)).any()
    assert plan.region.distance(squares(grid, stripe(grid))) >= 0.15


def test_ground_known_to_be_safe_is_certified_without_being_felt():
    def east(grid):
        return np.tile(grid.x > 2.5, (grid.rows, 1))
    grid, plan = plan_with(known_safe=east)
    row, column = grid.index_of(np.array((5.0, 4.0)))
    assert plan.certified[row, column] and plan.component[row, column]


def test_keeping_out_is_stronger_than_being_known_to_be_safe():
    def east(grid):
        return np.tile(grid.x > 2.5, (grid.rows, 1))
    grid, plan = plan_with(known_safe=east, keep_out=east)
    assert not (plan.certified & east(grid)).any()


def test_ground_felt_to_be_unsafe_is_not_certified_because_it_was_said_to_be_safe():
    grid = Grid.over_workspace(0.0, 0.0, 6.0, 5.0, 0.1)
    planner = SafePlanner(PlannerConfiguration(), grid)
    plan = planner.update(np.full(grid.shape, 0.8), np.full(grid.shape, 0.05), np.ones(3), None,
                          0.0, known_safe=np.ones(grid.shape, bool))
    assert not plan.certified.any()


@pytest.mark.parametrize('name', ['keep_out', 'known_safe'])
def test_a_mask_of_another_shape_is_refused_by_name(name):
    with pytest.raises(MapError, match=name):
        plan_with(**{name: lambda grid: np.zeros((3, 3), bool)})


def test_given_maps_are_looked_up_again_when_a_new_one_comes():
    maps = GivenMaps()
    assert maps.masks_on(GRID) == (None, None)
    cells = np.full(GRID.shape, -1, np.int8)
    cells[3, 4] = 100
    maps.take_keep_out(GRID, cells)
    keep_out, safe = maps.masks_on(GRID)
    assert safe is None and keep_out.sum() == 1 and keep_out[3, 4]
    assert maps.masks_on(GRID)[0] is keep_out, 'made once'
    maps.take_known_safe(GRID, cells)
    assert maps.masks_on(GRID)[1][3, 4]
