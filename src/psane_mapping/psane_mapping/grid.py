# SPDX-License-Identifier: Apache-2.0
"""The one place that knows cells and points."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from psane_mapping.errors import ParameterError

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Square cells over a rectangle, laid out like `nav_msgs/OccupancyGrid`.

    Row = y, column = x; cell (0, 0) touches the origin corner; arrays over the grid have shape
    (rows, columns) and are row-major. `index_of` and `point_of` are inverses at cell centres.

    Parameters
    ----------
    origin_x, origin_y : float
        Corner of cell (0, 0) (not its centre), map frame [m].
    resolution : float
        Edge of a cell [m].
    rows, columns : int
        Number of cells along y and x.
    """

    origin_x: float
    origin_y: float
    resolution: float
    rows: int
    columns: int

    def __post_init__(self) -> None:
        """Refuse a grid without cells or with a non-finite corner."""
        for name in ('origin_x', 'origin_y'):
            if not math.isfinite(getattr(self, name)):
                raise ParameterError(name, getattr(self, name), 'a finite value', 'm')
        if not (math.isfinite(self.resolution) and self.resolution > 0.0):
            raise ParameterError('resolution', self.resolution, 'a finite value above 0', 'm')
        for name in ('rows', 'columns'):
            if getattr(self, name) < 1:
                raise ParameterError(name, getattr(self, name), 'at least one cell')

    @classmethod
    def over_workspace(cls, min_x: float, min_y: float, max_x: float, max_y: float,
                       resolution: float) -> 'Grid':
        """Return the grid whose outermost cell centres lie on the workspace's border [m]."""
        return cls(origin_x=min_x - resolution / 2.0, origin_y=min_y - resolution / 2.0,
                   resolution=resolution,
                   rows=round((max_y - min_y) / resolution) + 1,
                   columns=round((max_x - min_x) / resolution) + 1)

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.rows, self.columns

    @property
    def cell_area(self) -> float:
        """Area of one cell [m^2]."""
        return self.resolution**2

    @property
    def x(self) -> FloatArray:
        """Cell centres along x, shape (columns,), map frame [m]."""
        return np.asarray(self.origin_x + (np.arange(self.columns) + 0.5) * self.resolution,
                          dtype=np.float64)

    @property
    def y(self) -> FloatArray:
        """Cell centres along y, shape (rows,), map frame [m]."""
        return np.asarray(self.origin_y + (np.arange(self.rows) + 0.5) * self.resolution,
                          dtype=np.float64)

    @property
    def points(self) -> FloatArray:
        """All cell centres in row-major order, shape (rows * columns, 2), map frame [m]."""
        x, y = np.meshgrid(self.x, self.y)
        return np.column_stack((x.ravel(), y.ravel()))

    def point_of(self, cells: IndexArray) -> FloatArray:
        """Return the centres of cells.

        Parameters
        ----------
        cells : (..., 2) int
            Row and column.

        Returns
        -------
        (..., 2) float, map frame [m].
        """
        cells = np.asarray(cells)
        x = self.origin_x + (cells[..., 1] + 0.5) * self.resolution
        y = self.origin_y + (cells[..., 0] + 0.5) * self.resolution
        return np.stack((x, y), axis=-1)

    def index_of(self, points: FloatArray) -> IndexArray:
        """Return the row and column of the cells that hold points, not clipped to the grid.

        Parameters
        ----------
        points : (..., 2) float, map frame [m]

        Returns
        -------
        (..., 2) int.
        """
        points = np.asarray(points, dtype=np.float64)
        column = np.floor((points[..., 0] - self.origin_x) / self.resolution)
        row = np.floor((points[..., 1] - self.origin_y) / self.resolution)
        if points.ndim == 1:
            return np.array((row, column)).astype(np.int64)
        return np.stack((row, column), axis=-1).astype(np.int64)

    def contains(self, points: FloatArray) -> NDArray[np.bool_]:
        """Tell which points (..., 2) [m], map frame, lie in a cell of the grid."""
        points = np.asarray(points, dtype=np.float64)
        if points.ndim == 1:
            # Asked for every stance several times.
            column = (points.item(0) - self.origin_x) / self.resolution
            row = (points.item(1) - self.origin_y) / self.resolution
            return np.asarray(0.0 <= row < self.rows and 0.0 <= column < self.columns)
        cells = self.index_of(points)
        inside = (cells >= 0) & (cells < np.array(self.shape))
        return np.asarray(inside.all(axis=-1))

    def distance_to_border(self) -> FloatArray:
        """Distance of each cell's centre to the outermost cell centres, (rows, columns) [m]."""
        rows = np.arange(self.rows)
        columns = np.arange(self.columns)
        to_row = np.minimum(rows, self.rows - 1 - rows)
        to_column = np.minimum(columns, self.columns - 1 - columns)
        return np.minimum(to_row[:, None], to_column[None, :]) * self.resolution
