# SPDX-License-Identifier: Apache-2.0
"""How likely uncertified ground will turn out to be safe, and what counting on it costs."""

import math

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.compiled import compiled
from psane_planner.confidence import Bounds
from psane_planner.discs import Integers, Mask
from psane_planner.geodesic import least_cost
from psane_planner.window import Window

WHOLE = 256
"""Weight of a cell that is safe for certain [-]."""

_MOST_CELLS = 256
_HALF_SQUARE = math.sqrt(0.5)


@compiled
def _chances(lower: FloatArray, upper: FloatArray, deviations: float, threshold: float,
             chances: FloatArray) -> None:
    """Write the probability of slip below the threshold, 0 where the interval excludes it."""
    for r in range(lower.shape[0]):
        for c in range(lower.shape[1]):
            low, high = lower[r, c], upper[r, c]
            if low > threshold:
                chances[r, c] = 0.0
            elif high <= threshold:
                chances[r, c] = 1.0
            elif low == -np.inf or high == np.inf or deviations == 0.0:
                chances[r, c] = 0.5
            else:
                std = 0.5 * (high - low) / deviations
                aside = (threshold - 0.5 * (low + high)) / std
                chances[r, c] = 0.5 * math.erfc(-aside * _HALF_SQUARE)


class Prospects:
    """The probability of each cell to be safe, by its confidence interval; kept up to date.

    Parameters
    ----------
    grid : Grid
    confidence_scale : float
        beta: the intervals reach sqrt(beta) standard deviations to either side [-].
    threshold : float
        Slip ratio h above which ground is unsafe [-].
    """

    def __init__(self, grid: Grid, confidence_scale: float, threshold: float) -> None:
        self._grid = grid
        self._deviations = math.sqrt(confidence_scale)
        self._threshold = threshold
        self._chances = np.zeros(grid.shape)
        self._version = 0
        self._block = max(1, math.ceil(max(grid.shape) / _MOST_CELLS))
        self._costs: tuple[int, Mask, FloatArray] | None = None
        self._field: tuple[FloatArray, FloatArray, FloatArray] | None = None

    def weights(self, bounds: Bounds, open_ground: Mask) -> Integers:
        """Return for each cell (rows, columns) of `open_ground` how likely it is safe.

        Parameters
        ----------
        bounds : Bounds
        open_ground : (rows, columns) bool
            Cells that count.

        Returns
        -------
        (rows, columns) int [-], probability times `WHOLE`, 0 elsewhere.
        """
        self._update(bounds)
        return _weights(self._chances, open_ground)

    def way_to(self, goal: FloatArray, bounds: Bounds, admissible: Mask, cells: Integers
               ) -> FloatArray:
        """Return the way from cells to the goal, each metre counted as often as it may fail.

        Parameters
        ----------
        goal : (2,) float, map frame [m]
        admissible : (rows, columns) bool
            Cells that may be certified.
        cells : (n, 2) int

        Returns
        -------
        (n,) float [m], infinite where only ground known to be unsafe leads there.

        Notes
        -----
        A metre over ground that is safe with probability p costs 1 / p metres, as though one had
        to try that often. On a large grid blocks of cells are taken together: a block can be
        passed where any of its cells can.
        """
        costs = self._costs_of(bounds, admissible)
        known = self._field
        if known is None or known[0] is not costs or not np.array_equal(known[1], goal):
            coarse = Grid(origin_x=self._grid.origin_x, origin_y=self._grid.origin_y,
                          resolution=self._grid.resolution * self._block,
                          rows=costs.shape[0], columns=costs.shape[1])
            known = self._field = (costs, np.array(goal), least_cost(costs, coarse, goal))
        blocks = cells // self._block
        return np.asarray(known[2][blocks[:, 0], blocks[:, 1]])

    def _costs_of(self, bounds: Bounds, admissible: Mask) -> FloatArray:
        """Return the cost of a metre on each block of cells [m/m]."""
        known = self._costs
        if known is None or known[0] != bounds.version or known[1] is not admissible:
            self._update(bounds)
            known = (bounds.version, admissible,
                     _block_costs(self._chances, admissible, self._block))
            self._costs = known
        return known[2]

    def _update(self, bounds: Bounds) -> None:
        """Bring the probabilities up to date where an interval changed."""
        if bounds.version == self._version:
            return
        window = bounds.changed
        if window is None or bounds.version != self._version + 1:
            window = Window(slice(0, self._grid.rows), slice(0, self._grid.columns))
        _chances(bounds.lower[window], bounds.upper[window], self._deviations, self._threshold,
                 self._chances[window])
        self._version = bounds.version


@compiled
def _weights(chances: FloatArray, open_ground: Mask) -> Integers:
    weights = np.zeros(chances.shape, np.int64)
    for r in range(chances.shape[0]):
        for c in range(chances.shape[1]):
            if open_ground[r, c]:
                weights[r, c] = int(math.ceil(256.0 * chances[r, c]))
    return weights


@compiled
def _block_costs(chances: FloatArray, admissible: Mask, block: int) -> FloatArray:
    """Return 1 / probability, averaged over the cells of each block that can be passed."""
    rows, columns = chances.shape
    costs = np.full(((rows + block - 1) // block, (columns + block - 1) // block), np.inf)
    for r in range(costs.shape[0]):
        for c in range(costs.shape[1]):
            total, count = 0.0, 0
            for i in range(r * block, min(rows, (r + 1) * block)):
                for j in range(c * block, min(columns, (c + 1) * block)):
                    if admissible[i, j] and chances[i, j] > 0.0:
                        total += 1.0 / chances[i, j]
                        count += 1
            if count > 0:
                costs[r, c] = total / count
    return costs
