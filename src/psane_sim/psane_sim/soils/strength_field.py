# SPDX-License-Identifier: Apache-2.0
"""Strength of the ground as a function of place, quick enough for every element at 1 kHz."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray, Grid


@njit(cache=True, error_model='numpy')
def bilinear(values: FloatArray, origin_x: float, origin_y: float, resolution: float, x: float,
             y: float) -> float:
    """Interpolate between cell centres; beyond the outermost ones the nearest value holds.

    Parameters
    ----------
    values : (rows, columns) float
    origin_x, origin_y : float
        Corner of cell (0, 0), map frame [m].
    resolution : float
        Edge of a cell [m].
    x, y : float
        Map frame [m].
    """
    rows, columns = values.shape
    column = min(max((x - origin_x) / resolution - 0.5, 0.0), columns - 1.0)
    row = min(max((y - origin_y) / resolution - 0.5, 0.0), rows - 1.0)
    c0 = min(int(column), columns - 2)
    r0 = min(int(row), rows - 2)
    fx, fy = column - c0, row - r0
    low = values[r0, c0] * (1.0 - fx) + values[r0, c0 + 1] * fx
    high = values[r0 + 1, c0] * (1.0 - fx) + values[r0 + 1, c0 + 1] * fx
    return low * (1.0 - fy) + high * fy


@njit(cache=True, error_model='numpy')
def _interpolate(values: FloatArray, origin_x: float, origin_y: float, resolution: float,
                 points: FloatArray) -> FloatArray:
    result = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        result[i] = bilinear(values, origin_x, origin_y, resolution, points[i, 0], points[i, 1])
    return result


@njit(cache=True, error_model='numpy')
def strength_at(log_strength: FloatArray, place: FloatArray, x: float, y: float) -> float:
    """Return the strength at a point (see `StrengthField.place`) [-]."""
    return math.exp(bilinear(log_strength, place[0], place[1], place[2], x, y))


def interpolate(grid: Grid, values: FloatArray, points: FloatArray) -> FloatArray:
    """Interpolate values on a grid (rows, columns) at points (..., 2), map frame [m]."""
    points = np.asarray(points, dtype=np.float64)
    flat = np.ascontiguousarray(points.reshape(-1, 2))
    result = _interpolate(values, grid.origin_x, grid.origin_y, grid.resolution, flat)
    return result.reshape(points.shape[:-1])


@dataclass(frozen=True)
class StrengthField:
    """Log-strength on a grid.

    Parameters
    ----------
    grid : Grid
        At least 2 x 2 cells.
    log_strength : (rows, columns) float
        Natural logarithm of the strength [-].
    """

    grid: Grid
    log_strength: FloatArray

    def __post_init__(self) -> None:
        """Freeze the values."""
        values = np.array(self.log_strength, dtype=np.float64)
        values.setflags(write=False)
        object.__setattr__(self, 'log_strength', values)

    @property
    def place(self) -> FloatArray:
        """Origin x, origin y and resolution, (3,) [m], as `strength_at` wants them."""
        return np.array([self.grid.origin_x, self.grid.origin_y, self.grid.resolution])

    def strength(self, points: FloatArray) -> FloatArray:
        """Return the strength at points (..., 2), map frame [m]."""
        return np.exp(interpolate(self.grid, self.log_strength, points))
