# SPDX-License-Identifier: Apache-2.0
"""What is believed of the ground before it was felt, as a map.

It moves the mean, not the deviation: ground that nothing but a prior map calls firm is as
uncertain as any other that was not felt, and is not certified by it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from psane_mapping.errors import ShapeError
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.slip import SlipModel

_STRENGTHS = (1e-3, 1e3)


@dataclass(frozen=True, kw_only=True)
class PriorMap:
    """Slip and log-strength expected of ground that was not felt.

    Parameters
    ----------
    grid : Grid
        Any; it need not be that of the posterior.
    slip, log_strength : (rows, columns) float [-]
        NaN where nothing is known.
    """

    grid: Grid
    slip: FloatArray
    log_strength: FloatArray

    def __post_init__(self) -> None:
        """Check the shapes and freeze the arrays."""
        for name in ('slip', 'log_strength'):
            values = np.array(getattr(self, name), dtype=np.float64)
            if values.shape != self.grid.shape:
                raise ShapeError(f'{name} has shape {values.shape}, expected {self.grid.shape}')
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    @classmethod
    def of_slip(cls, grid: Grid, slip: FloatArray, model: SlipModel) -> 'PriorMap':
        """Return the prior of slip ratios (rows, columns) [-]; NaN where nothing is known."""
        slip = np.clip(np.where(np.isfinite(slip), slip, np.nan), 0.0, 1.0)
        strength = np.clip(model.inverse(slip), *_STRENGTHS)
        return cls(grid=grid, slip=slip,
                   log_strength=np.where(np.isnan(slip), np.nan, np.log(strength)))

    @classmethod
    def of_strength(cls, grid: Grid, strength: FloatArray, model: SlipModel) -> 'PriorMap':
        """Return the prior of strengths (rows, columns) above 0 [-]; NaN where unknown."""
        known = np.isfinite(strength) & (strength > 0.0)
        strength = np.clip(np.where(known, strength, 1.0), *_STRENGTHS)
        slip = np.clip(model.slip(strength), 0.0, 1.0)
        return cls(grid=grid, slip=np.where(known, slip, np.nan),
                   log_strength=np.where(known, np.log(strength), np.nan))

    def equals(self, other: 'PriorMap | None') -> bool:
        """Tell whether another prior map says the same."""
        return (other is not None and self.grid == other.grid
                and np.array_equal(self.slip, other.slip, equal_nan=True)
                and np.array_equal(self.log_strength, other.log_strength, equal_nan=True))

    def mean_of_slip(self, otherwise: float) -> Callable[[Grid], FloatArray]:
        """Return a function that gives the mean of slip over a grid; `otherwise` if unknown."""
        return lambda grid: self._over(grid, self.slip, otherwise)

    def mean_of_log_strength(self, otherwise: float) -> Callable[[Grid], FloatArray]:
        """Return the same of log-strength."""
        return lambda grid: self._over(grid, self.log_strength, otherwise)

    def _over(self, grid: Grid, values: FloatArray, otherwise: float) -> FloatArray:
        """Interpolate bilinearly between the prior map's cell centres."""
        known = np.where(np.isnan(values), otherwise, values)
        rows = (grid.y - self.grid.origin_y) / self.grid.resolution - 0.5
        columns = (grid.x - self.grid.origin_x) / self.grid.resolution - 0.5
        row, column = np.meshgrid(rows, columns, indexing='ij')
        mean = map_coordinates(known, (row, column), order=1, mode='nearest')
        # A map reaches to the edges of its outermost cells, half a cell beyond their centres.
        inside = ((row >= -0.5) & (row <= self.grid.rows - 0.5)
                  & (column >= -0.5) & (column <= self.grid.columns - 0.5))
        return np.where(inside, mean, otherwise)
