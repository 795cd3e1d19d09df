# SPDX-License-Identifier: Apache-2.0
"""Screened-Poisson field over a region: no local minima in any region, for one goal at a time."""

import math

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from psane_mapping.grid import FloatArray, Grid, IndexArray
from psane_reactive.errors import MapError
from psane_reactive.model_map import Way

# Number of cells inside the region, and in the box around it, at most.
_LARGEST = 60000
_LARGEST_BOX = 1000000
_STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1))


class ScreenedPoissonField:
    """Solution of u - length^2 laplacian(u) = source at the goal, no flux through the border.

    Parameters
    ----------
    polygon : Polygon, map frame [m]
    cell : float
        Edge of a cell; longer where the region would need too many [m].
    length : float
        Decay length [m].

    Raises
    ------
    MapError
        When no cell's centre lies inside the region.

    Notes
    -----
    -length log(u) tends to the distance to the goal as length goes to 0 (Varadhan 1967). The
    matrix is an M-matrix: each cell but the goal's has a neighbour with a larger u, and
    elimination without pivoting adds only numbers of one sign, so even the smallest u keeps its
    relative accuracy. Cells that the goal does not reach have u = 0.
    """

    def __init__(self, polygon: shapely.Polygon, cell: float = 0.05, length: float = 0.2) -> None:
        low_x, low_y, high_x, high_y = polygon.bounds
        cell = max(cell, float(np.sqrt(polygon.area / _LARGEST)),
                   float(np.sqrt((high_x - low_x) * (high_y - low_y) / _LARGEST_BOX)))
        self.grid = Grid(origin_x=low_x, origin_y=low_y, resolution=cell,
                         rows=int((high_y - low_y) / cell) + 1,
                         columns=int((high_x - low_x) / cell) + 1)
        self.is_inside = shapely.contains_xy(polygon, self.grid.points).reshape(self.grid.shape)
        self._cells: IndexArray = np.argwhere(self.is_inside)
        if len(self._cells) == 0:
            raise MapError(f'no cell of {cell:g} m has its centre inside the region; '
                           'use smaller cells')
        self._centres = self.grid.point_of(self._cells)
        self._number = np.full(self.grid.shape, -1)
        self._number[self.is_inside] = np.arange(len(self._cells))
        self._factors = self._factorise(length)
        self._solved: tuple[int, FloatArray] | None = None

    def _factorise(self, length: float) -> object:
        """Factorise the five-point matrix of the inside cells."""
        weight = (length / self.grid.resolution) ** 2
        heads, tails = [], []
        for first, second in ((self._number[:, :-1], self._number[:, 1:]),
                              (self._number[:-1], self._number[1:])):
            both = (first >= 0) & (second >= 0)
            heads += [first[both], second[both]]
            tails += [second[both], first[both]]
        row, column = np.concatenate(heads), np.concatenate(tails)
        count = len(self._cells)
        diagonal = 1.0 + weight * np.bincount(row, minlength=count)
        every = np.arange(count)
        matrix = coo_array((np.concatenate((np.full(len(row), -weight), diagonal)),
                            (np.concatenate((row, every)), np.concatenate((column, every)))),
                           shape=(count, count)).tocsc()
        return splu(matrix, permc_spec='MMD_AT_PLUS_A', diag_pivot_thresh=0.0,
                    options={'SymmetricMode': True})

    def potential(self, goal: FloatArray) -> FloatArray:
        """Return u / u(goal) over the grid (rows, columns), 0 outside [-]."""
        potential = np.zeros(self.grid.shape)
        potential[self.is_inside] = self._solve(self._nearest(goal))
        return potential

    def way(self, position: FloatArray, goal: FloatArray, reach: float) -> Way | None:
        """Descend -log u from a position to a goal, (2,) [m], for `reach` metres.

        Returns
        -------
        None when the goal cannot be reached through the cells.
        """
        end, here = self._nearest(goal), self._nearest(position)
        values = self._solve(end)
        if values[here] <= 0.0:
            return None
        points, length = [self._centres[here]], 0.0
        while here != end and length < reach:
            following = self._uphill(here, values)
            if following < 0:
                return None
            length += float(np.hypot(*(self._centres[following] - self._centres[here])))
            here = following
            points.append(self._centres[here])
        if here == end:
            return Way(np.array([*points, goal]), ends_at_goal=True)
        return Way(np.array(points), ends_at_goal=False)

    def _nearest(self, point: FloatArray) -> int:
        """Return the number of the inside cell whose centre is nearest to a point."""
        return int(np.argmin(((self._centres - point) ** 2).sum(axis=1)))

    def _solve(self, goal: int) -> FloatArray:
        """Return u of the inside cells for a goal cell, kept until the goal changes."""
        if self._solved is None or self._solved[0] != goal:
            source = np.zeros(len(self._cells))
            source[goal] = 1.0
            values = self._factors.solve(source)  # type: ignore[attr-defined]
            self._solved = (goal, np.maximum(values, 0.0) / values[goal])
        return self._solved[1]

    def _uphill(self, here: int, values: FloatArray) -> int:
        """Return the neighbour with the steepest rise of log u, -1 when there is none."""
        row, column = self._cells[here]
        best, steepest = -1, 0.0
        for down, right in _STEPS:
            other = self._at(row + down, column + right)
            if other < 0 or values[other] <= values[here]:
                continue
            is_diagonal = down != 0 and right != 0
            if is_diagonal and min(self._at(row + down, column),
                                   self._at(row, column + right)) < 0:
                continue
            rise = math.log(values[other] / values[here]) / math.hypot(down, right)
            if rise > steepest:
                best, steepest = other, rise
        return best

    def _at(self, row: int, column: int) -> int:
        """Return the number of the inside cell at row and column, -1 outside."""
        rows, columns = self.grid.shape
        if not (0 <= row < rows and 0 <= column < columns):
            return -1
        return int(self._number[row, column])
