# SPDX-License-Identifier: Apache-2.0
"""Which windows of the map a measurement reaches."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from psane_mapping.basis import mode_count
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.kernels import Kernel, RadialBasis, reach_of

_CANDIDATES = (4.0, 5.0, 6.0, 8.0, 12.0)
_WIDEST_WHOLE = 40.0


class Tile(NamedTuple):
    """A block of cells: half-open ranges of rows and columns, and its window's corner [m]."""

    rows: tuple[int, int]
    columns: tuple[int, int]
    corner: FloatArray

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.rows[1] - self.rows[0], self.columns[1] - self.columns[0]


@dataclass(frozen=True)
class Tiling:
    """Equal blocks of cells over a grid, each with a margin around it.

    Parameters
    ----------
    grid : Grid
    tile_rows, tile_columns : int
        Cells of a block; the last ones of a row or column may be cut off by the grid.
    margin : float
        How far beyond its cells a block's window listens [m].
    """

    grid: Grid
    tile_rows: int
    tile_columns: int
    margin: float

    @classmethod
    def cheapest(cls, grid: Grid, kernel: Kernel, tolerance: float) -> 'Tiling':
        """Return the tiling with the least work per measurement.

        One window for the whole grid has no margin and no error from it, and is taken whenever it
        is not dearer than blocks: with an RBF up to about 20 lengthscales. With a tolerance of 0
        it is always taken.
        """
        whole = cls(grid, grid.rows, grid.columns, 0.0)
        reach = reach_of(kernel, tolerance)
        if math.isinf(reach):
            return whole
        candidates = []
        if max(grid.shape) * grid.resolution <= _WIDEST_WHOLE * kernel.lengthscale:
            candidates.append(whole)
        for lengthscales in _CANDIDATES:
            cells = max(1, round(lengthscales * kernel.lengthscale / grid.resolution))
            candidates.append(cls(grid, min(cells, grid.rows), min(cells, grid.columns), reach))
        return min(candidates, key=lambda tiling: tiling.work(kernel, tolerance))

    @property
    def window_size(self) -> tuple[float, float]:
        """Height and width of a window [m]."""
        return (self.tile_rows * self.grid.resolution + 2.0 * self.margin,
                self.tile_columns * self.grid.resolution + 2.0 * self.margin)

    @property
    def is_whole(self) -> bool:
        """True when one window serves the whole grid."""
        return self.tile_rows == self.grid.rows and self.tile_columns == self.grid.columns

    def work(self, kernel: Kernel, tolerance: float) -> float:
        """Return the multiplications per measurement, averaged over the grid [count]."""
        height, width = self.window_size
        reached = 1.0
        for size, cells, total in ((height, self.tile_rows, self.grid.rows),
                                   (width, self.tile_columns, self.grid.columns)):
            reached *= min(size / (cells * self.grid.resolution), math.ceil(total / cells))
        if isinstance(kernel, RadialBasis):
            return reached * mode_count((height, width), kernel.lengthscale, tolerance) ** 2
        return reached * height * width

    def cells_in_window(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres of a block's cells along y and x, from its window's corner [m]."""
        step = self.grid.resolution
        along_y = self.margin + (np.arange(self.tile_rows, dtype=np.float64) + 0.5) * step
        along_x = self.margin + (np.arange(self.tile_columns, dtype=np.float64) + 0.5) * step
        return along_y, along_x

    def reached_from(self, point: FloatArray) -> Iterator[tuple[int, int]]:
        """Yield the (row, column) of each block whose window holds a point (2,) [m], map frame."""
        origin = (self.grid.origin_y, self.grid.origin_x)
        sizes = (self.tile_rows, self.tile_columns)
        spans = []
        for axis, position in enumerate((point[1], point[0])):
            edge = sizes[axis] * self.grid.resolution
            last = math.ceil(self.grid.shape[axis] / sizes[axis]) - 1
            first = math.floor((position - self.margin - origin[axis]) / edge)
            final = math.floor((position + self.margin - origin[axis]) / edge)
            spans.append(range(max(first, 0), min(final, last) + 1))
        for row in spans[0]:
            for column in spans[1]:
                yield row, column

    def tile(self, index: tuple[int, int]) -> Tile:
        """Return the block with an index (row, column) of blocks."""
        rows = (index[0] * self.tile_rows, min((index[0] + 1) * self.tile_rows, self.grid.rows))
        columns = (index[1] * self.tile_columns,
                   min((index[1] + 1) * self.tile_columns, self.grid.columns))
        corner = np.array([self.grid.origin_x + columns[0] * self.grid.resolution - self.margin,
                           self.grid.origin_y + rows[0] * self.grid.resolution - self.margin])
        return Tile(rows, columns, corner)
