# SPDX-License-Identifier: Apache-2.0
"""Which windows of the map a measurement reaches."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from psane_mapping.basis import mode_count
from psane_mapping.errors import ParameterError
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.kernels import Kernel, RadialBasis, reach_of

_CANDIDATES = (4.0, 5.0, 6.0, 8.0, 12.0)
_WIDEST_WHOLE = 40.0
_BLOCK_FLOOR = 100.0
_MOST_FLOOR = 1e-4
_OVERHEAD = 4e4


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
        How far from its cells a block's window listens [m].
    """

    grid: Grid
    tile_rows: int
    tile_columns: int
    margin: float

    @classmethod
    def cheapest(cls, grid: Grid, kernel: Kernel, tolerance: float,
                 grows: bool = False) -> 'Tiling':
        """Return the tiling with the least work per measurement.

        One window for the whole grid has no margin and no error from it, and is taken whenever it
        is not dearer than blocks: with an RBF up to about 20 lengthscales. With a tolerance of 0
        it is always taken. A tiling that grows has blocks, and a grid of whole blocks.

        Raises
        ------
        ParameterError
            When it is to grow and the tolerance is 0: the dense process knows no blocks.
        """
        whole = cls(grid, grid.rows, grid.columns, 0.0)
        reach = reach_of(kernel, tolerance)
        if math.isinf(reach):
            if grows:
                raise ParameterError('tolerance', tolerance, 'a value above 0 for a growing map')
            return whole
        widest = max(grid.shape) * grid.resolution
        candidates = []
        if not grows and widest <= _WIDEST_WHOLE * kernel.lengthscale:
            candidates.append(whole)
        for lengthscales in _CANDIDATES:
            cells = max(1, round(lengthscales * kernel.lengthscale / grid.resolution))
            rows, columns = (cells, cells) if grows else (min(cells, grid.rows),
                                                          min(cells, grid.columns))
            candidates.append(cls(grid, rows, columns, reach))
        best = min(candidates, key=lambda tiling: tiling.work(kernel, tolerance))
        return best._rounded_up() if grows else best

    @property
    def window_size(self) -> tuple[float, float]:
        """Height and width of a window [m]."""
        return (self.tile_rows * self.grid.resolution + 2.0 * self.margin,
                self.tile_columns * self.grid.resolution + 2.0 * self.margin)

    @property
    def is_whole(self) -> bool:
        """True when one window without a margin serves the whole grid."""
        return self.margin == 0.0 and (self.tile_rows, self.tile_columns) == self.grid.shape

    def floor(self, tolerance: float) -> float:
        """Return the share of prior variance [-] below which a window leaves out a mode.

        In blocks the margin decides the error of the mean, and finer modes do not mend it
        (measured: no change from 1e-8 to 1e-6), but make a measurement twice as dear.
        """
        if self.is_whole:
            return tolerance
        return max(tolerance, min(_BLOCK_FLOOR * tolerance, _MOST_FLOOR))

    def work(self, kernel: Kernel, tolerance: float) -> float:
        """Return the multiplications per measurement, averaged over the grid [count]."""
        height, width = self.window_size
        cells = self.tile_rows * self.tile_columns
        if self.is_whole:
            reached = 1.0
        else:
            edge = self.grid.resolution
            area = (self.tile_rows * self.tile_columns * edge**2
                    + 2.0 * self.margin * (self.tile_rows + self.tile_columns) * edge
                    + math.pi * self.margin**2)
            blocks = (math.ceil(self.grid.rows / self.tile_rows)
                      * math.ceil(self.grid.columns / self.tile_columns))
            reached = min(area / (cells * edge**2), float(blocks))
        if isinstance(kernel, RadialBasis):
            modes = mode_count((height, width), kernel.lengthscale, self.floor(tolerance))
            return reached * (modes**2 + math.sqrt(modes) * cells + _OVERHEAD)
        return reached * height * width

    def cells_in_window(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres of a block's cells along y and x, from its window's corner [m]."""
        step = self.grid.resolution
        along_y = self.margin + (np.arange(self.tile_rows, dtype=np.float64) + 0.5) * step
        along_x = self.margin + (np.arange(self.tile_columns, dtype=np.float64) + 0.5) * step
        return along_y, along_x

    def reached_from(self, point: FloatArray) -> Iterator[tuple[int, int]]:
        """Yield the (row, column) of each block within the margin of a point (2,) [m], map frame.

        A single window hears all points of its grid.
        """
        if self.is_whole:
            yield 0, 0
            return
        rows, columns = (self._spans(axis, float(position))
                         for axis, position in enumerate((point[1], point[0])))
        for row, above in rows:
            for column, beside in columns:
                if math.hypot(above, beside) <= self.margin:
                    yield row, column

    def tile(self, index: tuple[int, int]) -> Tile:
        """Return the block with an index (row, column) of blocks."""
        rows = (index[0] * self.tile_rows, min((index[0] + 1) * self.tile_rows, self.grid.rows))
        columns = (index[1] * self.tile_columns,
                   min((index[1] + 1) * self.tile_columns, self.grid.columns))
        corner = np.array([self.grid.origin_x + columns[0] * self.grid.resolution - self.margin,
                           self.grid.origin_y + rows[0] * self.grid.resolution - self.margin])
        return Tile(rows, columns, corner)

    def holds_reach_of(self, point: FloatArray) -> bool:
        """Tell whether all that a measurement at a point (2,) [m] reaches lies in the grid."""
        corners = point + np.array([[-self.margin], [self.margin]])
        return bool(self.grid.contains(corners).all())

    def grown_to_hold(self, point: FloatArray) -> tuple['Tiling', tuple[int, int]]:
        """Return a tiling with more blocks, so that the grid holds the reach of a point.

        Returns
        -------
        Tiling
        added : (rows, columns) int
            Blocks added before the first row (south) and before the first column (west).
        """
        first = self.grid.index_of(point - self.margin).tolist()
        last = self.grid.index_of(point + self.margin).tolist()
        south, north = _missing(first[0], last[0], self.grid.rows, self.tile_rows)
        west, east = _missing(first[1], last[1], self.grid.columns, self.tile_columns)
        grid = Grid(
            origin_x=self.grid.origin_x - west * self.tile_columns * self.grid.resolution,
            origin_y=self.grid.origin_y - south * self.tile_rows * self.grid.resolution,
            resolution=self.grid.resolution,
            rows=self.grid.rows + (south + north) * self.tile_rows,
            columns=self.grid.columns + (west + east) * self.tile_columns)
        return replace(self, grid=grid), (south, west)

    def _rounded_up(self) -> 'Tiling':
        rows = math.ceil(self.grid.rows / self.tile_rows) * self.tile_rows
        columns = math.ceil(self.grid.columns / self.tile_columns) * self.tile_columns
        return replace(self, grid=replace(self.grid, rows=rows, columns=columns))

    def _spans(self, axis: int, position: float) -> list[tuple[int, float]]:
        """Return index and distance [m] of the blocks within the margin along one axis."""
        cells = (self.tile_rows, self.tile_columns)[axis]
        edge = cells * self.grid.resolution
        offset = position - (self.grid.origin_y, self.grid.origin_x)[axis]
        last = math.ceil(self.grid.shape[axis] / cells) - 1
        first = max(math.floor((offset - self.margin) / edge), 0)
        final = min(math.floor((offset + self.margin) / edge), last)
        return [(index, max(index * edge - offset, offset - (index + 1) * edge, 0.0))
                for index in range(first, final + 1)]


def _missing(first: int, last: int, count: int, cells: int) -> tuple[int, int]:
    """Return how many blocks of `cells` are missing before 0 and from `count` on."""
    return max(0, math.ceil(-first / cells)), max(0, (last - count) // cells + 1)
