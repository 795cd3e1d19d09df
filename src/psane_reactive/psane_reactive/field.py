# SPDX-License-Identifier: Apache-2.0
"""Screened-Poisson field over a region: no local minima in any region, for one goal at a time."""

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from psane_mapping.grid import FloatArray, Grid, IndexArray
from psane_reactive.clearance import Border
from psane_reactive.climb import climb
from psane_reactive.errors import MapError
from psane_reactive.model_map import Way

Mask = NDArray[np.bool_]

# Number of cells inside the region, and in the box around it, at most.
_LARGEST = 60000
_LARGEST_BOX = 1000000
# Within so many cells the cell of a point is looked for.
_VIEW = 3.0


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
        self._border = Border(polygon)
        self._open_right, self._open_up = self._open_links(polygon)
        self._factors = self._factorise(length)
        self._solved: tuple[int, FloatArray] | None = None

    def _open_links(self, polygon: shapely.Polygon) -> tuple[Mask, Mask]:
        """Tell which cells can be left to the right and upwards without crossing the border."""
        cell = self.grid.resolution
        depth = np.zeros(self.grid.shape)
        depth[self.is_inside] = -self._border.outside_distances(self._centres)
        shapely.prepare(polygon)
        links = []
        for down, right in ((0, 1), (1, 0)):
            link = self.is_inside & np.roll(self.is_inside, (-down, -right), (0, 1))
            link[-1:, :] &= down == 0
            link[:, -1:] &= right == 0
            near = np.argwhere(link & (depth < cell))
            ends = np.stack((self.grid.point_of(near), self.grid.point_of(near + (down, right))),
                            axis=1)
            link[tuple(near.T)] = shapely.covers(polygon, shapely.linestrings(ends))
            links.append(link)
        return links[0], links[1]

    def _factorise(self, length: float) -> object:
        """Factorise the five-point matrix of the inside cells."""
        weight = (length / self.grid.resolution) ** 2
        heads, tails = [], []
        for link, shift in ((self._open_right, (0, -1)), (self._open_up, (-1, 0))):
            first, second = self._number[link], np.roll(self._number, shift, (0, 1))[link]
            heads += [first, second]
            tails += [second, first]
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
        steps = climb(values, here, end, reach, self._centres, self._cells, self._number,
                      self._open_right, self._open_up)
        if len(steps) == 0:
            return None
        points = self._centres[steps]
        if steps[-1] == end:
            return Way(np.vstack((points, goal)), ends_at_goal=True)
        return Way(points, ends_at_goal=False)

    def _nearest(self, point: FloatArray) -> int:
        """Return the inside cell whose centre is nearest to a point, seen from it if any is."""
        aside = self._centres - point
        squares = aside[:, 0] ** 2 + aside[:, 1] ** 2
        near = np.flatnonzero(squares < (_VIEW * self.grid.resolution) ** 2)
        for cell in near[np.argsort(squares[near])]:
            if self._border.segment_distance(point, self._centres[cell], 1e-6) > 0.0:
                return int(cell)
        return int(np.argmin(squares))

    def _solve(self, goal: int) -> FloatArray:
        """Return u of the inside cells for a goal cell, kept until the goal changes."""
        if self._solved is None or self._solved[0] != goal:
            source = np.zeros(len(self._cells))
            source[goal] = 1.0
            values = self._factors.solve(source)  # type: ignore[attr-defined]
            self._solved = (goal, np.maximum(values, 0.0) / values[goal])
        return self._solved[1]
