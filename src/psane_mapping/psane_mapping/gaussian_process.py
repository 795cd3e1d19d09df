# SPDX-License-Identifier: Apache-2.0
"""Gaussian-process posterior over the cells of a grid, updated in place by each measurement.

Notes
-----
The grid is served by windows (`tiling`, `windows`): each holds the exact posterior of its own
cells given every measurement within the kernel's reach of them. So

- a measurement costs the same however large the map and however long the history (RBF);
- the posterior is a function of the set of measurements, whatever their order, up to round-off
  (1e-8 is asserted; 1e-12 is typical);
- what lies beyond the reach is ignored, not guessed. Windows of a large map are therefore less
  certain than the dense process, modes left out aside (measured at the default tolerance: below
  its deviation by 6e-4 at most), and their mean differs by a few per cent of the deviation.

`tolerance` alone trades error against speed. It is the share of prior variance below which a mode
is left out (a hundred times that in blocks), and the share that a measurement just beyond the reach
could have taken away; 0 keeps everything in one window, and equals the dense process to round-off.
"""

import math
from array import array
from collections import OrderedDict
from typing import NamedTuple

import numpy as np

from psane_mapping.basis import RectangleBasis
from psane_mapping.errors import ParameterError, ShapeError
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.kalman import assimilate
from psane_mapping.kernels import Kernel, RadialBasis
from psane_mapping.tiling import Tiling
from psane_mapping.windows import DenseWindow, SpectralWindow, Window

_LEAST_NOISE = 1e-6
_MERGE_SHARE = 0.1
_RESIDENT_BYTES = 40e6
_FEWEST_RESIDENT = 16
_RECORD = 4

Index = tuple[int, int]


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
    prior_mean : float or (rows, columns) float
        Constant, or a prior map.
    tolerance : float
        Bound on what is left out, as a share of the prior variance [-]; 0 for the dense process.
    grows : bool
        Whether `grow` will be called. The grid is then rounded up to whole blocks.
    """

    def __init__(self, grid: Grid, kernel: Kernel, prior_mean: float | FloatArray = 0.0,
                 tolerance: float = 1e-8, grows: bool = False) -> None:
        if not (math.isfinite(tolerance) and 0.0 <= tolerance <= 1e-2):
            raise ParameterError('tolerance', tolerance, 'a finite value in [0, 0.01]')
        self.kernel = kernel
        self._tolerance = tolerance
        self.tiling = Tiling.cheapest(grid, kernel, tolerance, grows)
        self._basis = self._make_basis()
        self.reset(prior_mean)

    @property
    def grid(self) -> Grid:
        """The cells; another one after `grow`."""
        return self.tiling.grid

    def reset(self, prior_mean: float | FloatArray | None = None) -> None:
        """Forget every measurement, and take another prior mean if one is given."""
        if prior_mean is not None:
            self._prior = self._checked_prior(prior_mean)
        self._mean = self._prior.copy()
        self._variance = np.full(self.grid.shape, self.kernel.deviation**2)
        self._windows: OrderedDict[Index, Window] = OrderedDict()
        self._records: dict[Index, array[float]] = {}
        self.count = 0

    def grow(self, point: FloatArray, prior_mean: Callable[[Grid], float | FloatArray]) -> None:
        """Add blocks of cells, so that the grid holds a point; what was measured stays.

        Parameters
        ----------
        point : (2,) float, map frame [m]
        prior_mean : callable
            Returns the prior mean of all cells of the larger grid.
        """
        self.tiling, (south, west) = self.tiling.grown_to_hold(point)
        rows, columns = self._mean.shape
        first_row, first_column = south * self.tiling.tile_rows, west * self.tiling.tile_columns
        kept = (slice(first_row, first_row + rows), slice(first_column, first_column + columns))
        self._prior = self._checked_prior(prior_mean(self.grid))
        mean, variance = self._prior.copy(), np.full(self.grid.shape, self.kernel.deviation**2)
        mean[kept], variance[kept] = self._mean, self._variance
        self._mean, self._variance = mean, variance
        self._windows = OrderedDict(((row + south, column + west), window)
                                    for (row, column), window in self._windows.items())
        self._records = {(row + south, column + west): records
                         for (row, column), records in self._records.items()}
        self._hear_of_old_measurements(point)

    def _checked_prior(self, prior_mean: float | FloatArray) -> FloatArray:
        """Return the prior mean (rows, columns), read-only; a constant takes no memory."""
        values = np.array(prior_mean, dtype=np.float64)
        if not np.isfinite(values).all():
            raise ShapeError('prior_mean holds a number that is not finite')
        return np.broadcast_to(values, self.grid.shape)

    @property
    def mean(self) -> FloatArray:
        """Posterior mean, (rows, columns), a copy."""
        return self._mean.copy()

    @property
    def std(self) -> FloatArray:
        """Posterior standard deviation, (rows, columns), never above the prior's."""
        return np.sqrt(self._variance)

    def condition(self, point: FloatArray, value: float, deviation: float) -> Innovation:
        """Take in one measurement.

        Parameters
        ----------
        point : (2,) float, map frame [m]
            Inside the grid.
        value : float
        deviation : float
            Standard deviation of the measurement's noise, above 0; below a millionth of the
            prior's it counts as that, to stay clear of round-off.

        Raises
        ------
        ShapeError
            For a number that is not finite or a point outside the grid; nothing is changed.
        """
        point = self._checked(point, value, deviation)
        variance = max(deviation, _LEAST_NOISE * self.kernel.deviation) ** 2
        excess = value - self._prior_at(point)
        innovation = Innovation(math.nan, math.nan)
        home = tuple((self.grid.index_of(point)
                      // (self.tiling.tile_rows, self.tiling.tile_columns)).tolist())
        for index in self.tiling.reached_from(point):
            tile = self.tiling.tile(index)
            window = self._window(index)
            x, y = (point - tile.corner).tolist()
            evidence = window.observe(x, y, excess, variance)
            self._record(index, (x, y, excess, variance))
            rows, columns = slice(*tile.rows), slice(*tile.columns)
            assimilate(self._mean[rows, columns], self._variance[rows, columns], *evidence)
            if index == home:
                innovation = Innovation(evidence.innovation,
                                        math.sqrt(evidence.innovation_variance))
        self.count += 1
        return innovation

    def gradient(self, point: FloatArray) -> FloatArray:
        """Return the slope of the mean at a point (2,) [m], map frame: (d/dx, d/dy) [1/m]."""
        row, column = np.clip(self.grid.index_of(point), 0, np.array(self.grid.shape) - 1)
        slopes = []
        for values, index in ((self._mean[row], column), (self._mean[:, column], row)):
            low, high = max(index - 1, 0), min(index + 1, values.size - 1)
            rise = values[high] - values[low]
            slopes.append(rise / ((high - low) * self.grid.resolution) if high > low else 0.0)
        return np.array(slopes)

    def _checked(self, point: FloatArray, value: float, deviation: float) -> FloatArray:
        point = np.asarray(point, dtype=np.float64)
        if point.shape != (2,) or not np.isfinite(point).all():
            raise ShapeError(f'point = {point}, expected two finite coordinates [m]')
        if not math.isfinite(value):
            raise ShapeError(f'value = {value}, expected a finite number')
        if not (math.isfinite(deviation) and deviation > 0.0):
            raise ShapeError(f'deviation = {deviation}, expected a finite number above 0')
        if not self.grid.contains(point):
            raise ShapeError(f'point = {point} m lies outside the grid')
        return point

    def _prior_at(self, point: FloatArray) -> float:
        """Interpolate the prior map bilinearly between cell centres."""
        grid = self.grid
        row = np.clip((point[1] - grid.origin_y) / grid.resolution - 0.5, 0, grid.rows - 1)
        column = np.clip((point[0] - grid.origin_x) / grid.resolution - 0.5, 0, grid.columns - 1)
        top, left = int(row), int(column)
        bottom, right = min(top + 1, grid.rows - 1), min(left + 1, grid.columns - 1)
        upper = (1 - column + left) * self._prior[top, left] + (
            column - left) * self._prior[top, right]
        lower = (1 - column + left) * self._prior[bottom, left] + (
            column - left) * self._prior[bottom, right]
        return float((1 - row + top) * upper + (row - top) * lower)

    def _make_basis(self) -> RectangleBasis | None:
        if not isinstance(self.kernel, RadialBasis):
            return None
        return RectangleBasis.spanning(self.tiling.window_size, self.tiling.cells_in_window(),
                                       self.kernel.lengthscale, self._tolerance)

    def _new_window(self, index: tuple[int, int]) -> Window:
        shape = self.tiling.tile(index).shape
        if self._basis is not None:
            return SpectralWindow(self._basis, self.kernel.deviation, shape)
        along_y, along_x = self.tiling.cells_in_window()
        y, x = np.meshgrid(along_y[:shape[0]], along_x[:shape[1]], indexing='ij')
        merge = _MERGE_SHARE * self.kernel.lengthscale if self._tolerance > 0.0 else 0.0
        return DenseWindow(self.kernel, np.column_stack((x.ravel(), y.ravel())), shape, merge)

    def _window(self, index: tuple[int, int]) -> Window:
        """Return a window, made or rebuilt if need be, as the most recently used."""
        window = self._windows.get(index)
        if window is None:
            window = self._windows[index] = self._new_window(index)
            records = self._records.get(index)
            if records and isinstance(window, SpectralWindow):
                window.restore(np.array(records))
            self._let_go()
        self._windows.move_to_end(index)
        return window

    def _record(self, index: tuple[int, int],
                record: tuple[float, float, float, float]) -> None:
        """Remember what a window was told, as long as that is less than the window itself."""
        if self._basis is None or self.tiling.is_whole:
            return
        records = self._records.setdefault(index, [])
        if len(records) <= self._basis.count:
            records.append(record)

    def _let_go(self) -> None:
        """Drop the longest unused windows that can be rebuilt from their records."""
        if self._basis is None or self.tiling.is_whole:
            return
        most = max(_FEWEST_RESIDENT, int(_RESIDENT_BYTES / (8 * self._basis.count**2)))
        for index in list(self._windows)[:-_FEWEST_RESIDENT]:
            if len(self._windows) <= most:
                return
            if len(self._records.get(index, ())) <= self._basis.count:
                del self._windows[index]
