# SPDX-License-Identifier: Apache-2.0
"""Which windows a measurement reaches, and that every cell belongs to one block."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.errors import ParameterError
from psane_mapping.grid import Grid
from psane_mapping.kernels import RadialBasis
from psane_mapping.tiling import Tiling

RBF = RadialBasis(lengthscale=0.6, deviation=0.5)


@given(rows=st.integers(1, 40), columns=st.integers(1, 40), tile=st.integers(1, 15))
def test_every_cell_belongs_to_exactly_one_block(rows, columns, tile):
    grid = Grid(origin_x=-1.0, origin_y=2.0, resolution=0.1, rows=rows, columns=columns)
    tiling = Tiling(grid, min(tile, rows), min(tile, columns), 100.0)
    owners = np.zeros(grid.shape, dtype=int)
    for index in tiling.reached_from(np.array([0.0, 2.0])):
        block = tiling.tile(index)
        owners[slice(*block.rows), slice(*block.columns)] += 1
    assert (owners == 1).all()


@settings(max_examples=200)
@given(x=st.floats(-1.0, 2.0), y=st.floats(2.0, 4.5), margin=st.floats(0.0, 1.5))
def test_the_blocks_reached_are_those_within_the_margin_of_the_point(x, y, margin):
    grid = Grid(origin_x=-1.0, origin_y=2.0, resolution=0.1, rows=25, columns=30)
    tiling = Tiling(grid, 7, 8, margin)
    reached = set(tiling.reached_from(np.array([x, y])))
    for row in range(4):
        for column in range(4):
            low = np.array([-1.0 + 0.8 * column, 2.0 + 0.7 * row])
            nearest = np.clip((x, y), low, low + (0.8, 0.7))
            distance = math.hypot(*(nearest - (x, y)))
            # A point within round-off of the margin may count either way.
            if abs(distance - margin) > 1e-9:
                assert ((row, column) in reached) == (distance < margin)


@settings(max_examples=200)
@given(x=st.floats(-30.0, 30.0), y=st.floats(-30.0, 30.0))
def test_a_tiling_grows_by_whole_blocks_until_it_holds_the_reach_of_a_point(x, y):
    start = Tiling.cheapest(Grid.over_workspace(0.0, 0.0, 2.0, 3.0, 0.1), RBF, 1e-8, grows=True)
    assert start.grid.rows % start.tile_rows == start.grid.columns % start.tile_columns == 0
    point = np.array([x, y])
    grown, (south, west) = start.grown_to_hold(point)
    assert grown.holds_reach_of(point) or start.margin == 0.0
    assert grown.grid.rows % start.tile_rows == grown.grid.columns % start.tile_columns == 0
    # What was a block stays the same block, at the same place.
    old, new = start.tile((0, 0)), grown.tile((south, west))
    assert np.allclose(old.corner, new.corner, atol=1e-9)
    # No more than needed.
    assert grown.grid.rows <= start.grid.rows + 2 + (
        abs(y) + 2.0 * start.margin) / 0.1 + 2 * start.tile_rows
    # A tiling that already holds it stays as it is.
    assert grown.grown_to_hold(point) == (grown, (0, 0))


def test_a_growing_map_of_tolerance_zero_is_refused():
    with pytest.raises(ParameterError, match='tolerance'):
        Tiling.cheapest(Grid.over_workspace(0.0, 0.0, 2.0, 3.0, 0.1), RBF, 0.0, grows=True)


def test_a_small_map_is_one_window_and_a_large_one_is_not():
    small = Tiling.cheapest(Grid.over_workspace(0, 0, 10, 10, 0.1), RBF, 1e-8)
    large = Tiling.cheapest(Grid.over_workspace(0, 0, 100, 100, 0.1), RBF, 1e-8)
    assert small.is_whole and small.margin == 0.0
    assert not large.is_whole and large.margin > 4.0 * RBF.lengthscale


def test_the_work_of_a_measurement_does_not_grow_with_the_map():
    works = [Tiling.cheapest(Grid.over_workspace(0, 0, size, size, 0.1), RBF, 1e-8)
             .work(RBF, 1e-8) for size in (50, 100, 200)]
    assert works[0] == pytest.approx(works[1]) == pytest.approx(works[2])


def test_tolerance_zero_is_one_window_for_any_map():
    grid = Grid.over_workspace(0, 0, 60, 60, 0.5)
    assert Tiling.cheapest(grid, RBF, 0.0).is_whole
