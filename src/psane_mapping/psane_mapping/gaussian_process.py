# SPDX-License-Identifier: Apache-2.0
"""Gaussian-process posterior over the cells of a grid, updated in place by each measurement.

Notes
-----
The grid is served by windows (`tiling`, `windows`): each holds the exact posterior of its own
cells given every measurement within the kernel's reach of them. So

- a measurement costs the same however large the map and however long the history (RBF);
- the posterior is a function of the set of measurements, whatever their order, up to round-off
  (1e-8 is asserted; 1e-12 is typical);
- what lies beyond the reach is ignored, not guessed. The windows of a large map are therefore less
  certain than the dense process, modes left out aside (measured at the default tolerance: below
  its deviation by 6e-4 at most), and their mean differs by a few per cent of the deviation.

`tolerance` alone trades error against speed. It is the share of prior variance below which a mode
is left out (a hundred times that in blocks), and the share that a measurement just beyond the
reach could have taken away; 0 keeps everything in one window, and equals the dense process to
round-off.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from psane_mapping.errors import ParameterError, ShapeError
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.kalman import assimilate
from psane_mapping.kernels import Kernel
from psane_mapping.tiling import Tiling
from psane_mapping.window_store import WindowStore

_NOISE_SHARES = (1e-6, 1e6)

PriorMean = float | FloatArray | Callable[[Grid], float | FloatArray]


class Innovation(NamedTuple):
    """How far a measurement was from its prediction, and how far was to be expected.

    `deviation` is that of the prediction and the measurement's noise together; the ratio of the
    two is standard normal when the model is right.
    """

    value: float
    deviation: float


class GridPosterior:
    """Posterior mean and standard deviation of a quantity at each cell of a grid.

    Parameters
    ----------
    grid : Grid
    kernel : Kernel
    prior_mean : float, (rows, columns) float, or a function of a grid that returns one of them
        A map that grows needs a constant or a function.
    tolerance : float
        Bound on what is left out, as a share of the prior variance [-]; 0 for the dense process.
    grows : bool
        True for a grid that grows by whole blocks, so that it holds all that is measured and what
        lies in reach of it; `grid` is then where it starts.
    """

    def __init__(self, grid: Grid, kernel: Kernel, prior_mean: PriorMean = 0.0,
                 tolerance: float = 1e-8, grows: bool = False) -> None:
        if not (math.isfinite(tolerance) and 0.0 <= tolerance <= 1e-2):
            raise ParameterError('tolerance', tolerance, 'a finite value in [0, 0.01]')
        self.kernel = kernel
        self.tiling = Tiling.cheapest(grid, kernel, tolerance, grows)
        self._grows = grows
        self._prior_mean = prior_mean
        self._windows = WindowStore(kernel, self.tiling, tolerance)
        self.reset()

    @property
    def grid(self) -> Grid:
        """The cells; a larger grid once it has grown."""
        return self.tiling.grid

    def reset(self, prior_mean: PriorMean | None = None) -> None:
        """Forget every measurement, and take another prior mean if one is given."""
        if prior_mean is not None:
            self._prior_mean = prior_mean
        self._prior = self._prior_over_grid()
        self._mean = self._prior.copy()
        self._variance = np.full(self.grid.shape, self.kernel.deviation**2)
        self._windows.clear()
        self.count = 0

    @property
    def mean(self) -> FloatArray:
        """Posterior mean, (rows, columns), a copy."""
        return self._mean.copy()

    @property
    def std(self) -> FloatArray:
        """Posterior standard deviation, (rows, columns), never above the prior's."""
        return np.sqrt(self._variance)

    @property
    def variance(self) -> FloatArray:
        """Posterior variance, (rows, columns), a copy."""
        return self._variance.copy()

    def condition(self, point: FloatArray, value: float, deviation: float) -> Innovation:
        """Take in one measurement.

        Parameters
        ----------
        point : (2,) float, map frame [m]
            Inside the grid, unless that grows.
        value : float
        deviation : float
            Standard deviation of the measurement's noise, above 0; below a millionth or above
            a million times the prior's it counts as that, to stay clear of round-off.

        Raises
        ------
        ShapeError
            For a number that is not finite or a point outside the grid; nothing is changed.
        """
        point = self._checked(point, value, deviation)
        low, high = (share * self.kernel.deviation for share in _NOISE_SHARES)
        variance = min(max(deviation, low), high) ** 2
        excess = value - self._prior_at(point)
        innovation = Innovation(math.nan, math.nan)
        row, column = self._cell_of(point)
        home = (row // self.tiling.tile_rows, column // self.tiling.tile_columns)
        for index in self.tiling.reached_from(point):
            tile = self.tiling.tile(index)
            x, y = (point - tile.corner).tolist()
            evidence = self._windows.observe(index, x, y, excess, variance)
            rows, columns = slice(*tile.rows), slice(*tile.columns)
            assimilate(self._mean[rows, columns], self._variance[rows, columns], *evidence)
            if index == home:
                innovation = Innovation(evidence.innovation,
                                        math.sqrt(evidence.innovation_variance))
        self.count += 1
        return innovation

    def gradient(self, point: FloatArray) -> FloatArray:
        """Return the slope of the mean at a point (2,) [m], map frame: (d/dx, d/dy) [1/m]."""
        row, column = self._cell_of(point)
        slopes = []
        for values, index in ((self._mean[row], column), (self._mean[:, column], row)):
            low, high = max(index - 1, 0), min(index + 1, values.size - 1)
            rise = float(values[high]) - float(values[low])
            slopes.append(rise / ((high - low) * self.grid.resolution) if high > low else 0.0)
        return np.array(slopes)

    def _cell_of(self, point: FloatArray) -> tuple[int, int]:
        """Return row and column of the cell that holds a point, or of the nearest one."""
        grid = self.grid
        row = math.floor((float(point[1]) - grid.origin_y) / grid.resolution)
        column = math.floor((float(point[0]) - grid.origin_x) / grid.resolution)
        return min(max(row, 0), grid.rows - 1), min(max(column, 0), grid.columns - 1)

    def _checked(self, point: FloatArray, value: float, deviation: float) -> FloatArray:
        point = np.asarray(point, dtype=np.float64)
        if point.shape != (2,) or not np.isfinite(point).all():
            raise ShapeError(f'point = {point}, expected two finite coordinates [m]')
        if not math.isfinite(value):
            raise ShapeError(f'value = {value}, expected a finite number')
        if not (math.isfinite(deviation) and deviation > 0.0):
            raise ShapeError(f'deviation = {deviation}, expected a finite number above 0')
        if self._grows and not self.tiling.holds_reach_of(point):
            self._grow(point)
        if not self.grid.contains(point):
            raise ShapeError(f'point = {point} m lies outside the grid')
        return point

    def _grow(self, point: FloatArray) -> None:
        """Add blocks of cells, so that the grid holds the reach of a point."""
        self.tiling, added = self.tiling.grown_to_hold(point)
        self._windows.regrid(self.tiling, added)
        rows, columns = self._mean.shape
        first_row = added[0] * self.tiling.tile_rows
        first_column = added[1] * self.tiling.tile_columns
        kept = (slice(first_row, first_row + rows), slice(first_column, first_column + columns))
        self._prior = self._prior_over_grid()
        mean, variance = self._prior.copy(), np.full(self.grid.shape, self.kernel.deviation**2)
        mean[kept], variance[kept] = self._mean, self._variance
        self._mean, self._variance = mean, variance

    def _prior_over_grid(self) -> FloatArray:
        """Return the prior mean (rows, columns), read-only; a constant takes no memory."""
        prior = self._prior_mean
        values = np.array(prior(self.grid) if callable(prior) else prior, dtype=np.float64)
        if not np.isfinite(values).all():
            raise ShapeError('prior_mean holds a number that is not finite')
        if values.shape not in ((), self.grid.shape):
            raise ShapeError(f'prior_mean has shape {values.shape}, expected {self.grid.shape}')
        return np.broadcast_to(values, self.grid.shape)

    def _prior_at(self, point: FloatArray) -> float:
        """Interpolate the prior map bilinearly between cell centres."""
        grid = self.grid
        row = min(max((float(point[1]) - grid.origin_y) / grid.resolution - 0.5, 0.0),
                  grid.rows - 1.0)
        column = min(max((float(point[0]) - grid.origin_x) / grid.resolution - 0.5, 0.0),
                     grid.columns - 1.0)
        top, left = int(row), int(column)
        bottom, right = min(top + 1, grid.rows - 1), min(left + 1, grid.columns - 1)
        upper = (1 - column + left) * self._prior[top, left] + (
            column - left) * self._prior[top, right]
        lower = (1 - column + left) * self._prior[bottom, left] + (
            column - left) * self._prior[bottom, right]
        return float((1 - row + top) * upper + (row - top) * lower)
