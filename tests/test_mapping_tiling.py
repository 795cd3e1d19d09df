# SPDX-License-Identifier: Apache-2.0
"""Which windows a measurement reaches, and that every cell belongs to one block."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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
def test_the_blocks_reached_are_those_whose_window_holds_the_point(x, y, margin):
    grid = Grid(origin_x=-1.0, origin_y=2.0, resolution=0.1, rows=25, columns=30)
    tiling = Tiling(grid, 7, 8, margin)
    point = np.array([x, y])
    reached = set(tiling.reached_from(point))
    for row in range(4):
        for column in range(4):
            corner = tiling.tile((row, column)).corner
            inside = point - corner
            size = np.array(tiling.window_size[::-1])
            # A point within round-off of a window's edge may count either way.
            if np.abs(np.concatenate((inside, size - inside))).min() > 1e-9:
                assert ((row, column) in reached) == bool(((inside > 0) & (inside < size)).all())


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
