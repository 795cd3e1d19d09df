# SPDX-License-Identifier: Apache-2.0
"""Where the ground has been riskier than the map had promised, the map promises less.

A Gaussian process knows how densely the ground was felt, not whether it is as smooth as the
kernel. A soft strip that is narrower than the lengthscale, between firm ground on both sides, is
smoothed over and called certain. Stances on its edge contradict the map before the robot's centre
gets there; here that is remembered in place.
"""

import math

import numba
import numpy as np

from psane_mapping.gaussian_process import Innovation
from psane_mapping.grid import FloatArray, Grid

_FAR = 3.0
# A single stance that went wrong counts as no more than four standard deviations.
_MOST = 16.0


class SurpriseMap:
    """Factor by which the deviation of slip is too small, cell by cell.

    Parameters
    ----------
    grid : Grid
    reach : float
        Distance over which a surprise tells of the ground [m]; 0 keeps the factor at 1.
    trust : float
        Stances without a surprise that the map is believed to have had everywhere [count].
    allowance : float
        The local mean square up to which the factor stays at 1 [-].

    Notes
    -----
    The square of the factor is a local mean of squared normalised innovations (Birge 1932 scales
    the errors of a fit in the same way), each stance weighted by a Gaussian of its distance. Only
    slip above its prediction counts, twice, since for an honest map that is half of the stances:
    ground that is firmer than predicted is no risk. The factor is never below 1.
    """

    def __init__(self, grid: Grid, reach: float, trust: float, allowance: float) -> None:
        self.grid = grid
        self._reach = reach
        self._trust = trust
        self._allowance = allowance
        self.clear()

    def clear(self) -> None:
        """Forget all stances."""
        self._weight = np.zeros(self.grid.shape)
        self._square = np.zeros(self.grid.shape)

    def move(self, grid: Grid) -> None:
        """Go on on a grid that has grown by whole cells."""
        row, column = (-self.grid.index_of(grid.point_of(np.zeros(2, dtype=np.int64)))).tolist()
        old, rows, columns = (self._weight, self._square), *self.grid.shape
        self.grid = grid
        self.clear()
        for kept, array in zip(old, (self._weight, self._square), strict=True):
            array[row:row + rows, column:column + columns] = kept

    def add(self, point: FloatArray, innovation: Innovation, common: float) -> None:
        """Take in how far a stance was from its prediction.

        Parameters
        ----------
        point : (2,) float, map frame [m]
        innovation : Innovation
        common : float
            Deviation that all stances share, which the process leaves out [-].
        """
        if self._reach == 0.0 or not math.isfinite(innovation.value):
            return
        grid = self.grid
        variance = innovation.deviation**2 + common**2
        square = min(innovation.value**2 / variance, _MOST) if innovation.value > 0.0 else 0.0
        _spread(self._weight, self._square, (float(point[0]) - grid.origin_x) / grid.resolution,
                (float(point[1]) - grid.origin_y) / grid.resolution,
                self._reach / grid.resolution, 2.0 * square)

    def factor(self) -> FloatArray:
        """Return the factor (rows, columns) [-], at least 1."""
        ratio = (self._trust + self._square) / (self._trust + self._weight)
        return np.sqrt(np.maximum(ratio / self._allowance, 1.0))


@numba.njit(cache=True)
def _spread(weight: FloatArray, square: FloatArray, x: float, y: float, reach: float,
            value: float) -> None:
    """Add a stance at x, y [cells] to the sums (rows, columns) of weights and squares."""
    rows, columns = weight.shape
    far = _FAR * reach
    for row in range(max(0, int(y - far)), min(rows, int(y + far) + 1)):
        for column in range(max(0, int(x - far)), min(columns, int(x + far) + 1)):
            away = (row + 0.5 - y) ** 2 + (column + 0.5 - x) ** 2
            share = math.exp(-0.5 * away / reach**2)
            weight[row, column] += share
            square[row, column] += share * value
