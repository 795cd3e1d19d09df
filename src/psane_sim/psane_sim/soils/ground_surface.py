# SPDX-License-Identifier: Apache-2.0
"""The shape of the ground: slopes that it has, and footprints that the robot leaves in it."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray, Grid
from psane_sim.errors import SimulationError
from psane_sim.soils.strength_field import bilinear

Relief = tuple[FloatArray, FloatArray]
"""Heights (rows, columns) [m] and their place (3,), as in `StrengthField.place`."""

Prints = tuple[FloatArray, FloatArray, FloatArray]
"""Footprints: cells (n, n, 4) (`PIT` to `REFILLED`), settings, clock (1,) [s]."""

PIT, PENDING, TOUCHED, REFILLED = 0, 1, 2, 3
"""Depth of the pit that was left and of the one that is being made [m], when a plate was last
there, and when the pit was last looked at [s]."""

CELL, SHARE, REFILL, COMPACTION = 0, 1, 2, 3
"""Settings: edge of a cell [m], share of a pit that stays open [-], time in which sand flows back
(0: never) [s], and growth of the strength in a pit of `FULL_COMPACTION` [-]."""

FULL_COMPACTION = 0.05
"""Depth of a footprint whose ground is fully compacted [m]."""

_RELEASE = 0.06


def flat_relief() -> Relief:
    """Return ground that is level everywhere."""
    return np.zeros((1, 1)), np.zeros(3)


@dataclass(frozen=True)
class HeightField:
    """Heights of the ground on a grid.

    Parameters
    ----------
    grid : Grid
        At least 2 x 2 cells.
    height : (rows, columns) float [m]
    """

    grid: Grid
    height: FloatArray

    def __post_init__(self) -> None:
        """Check and freeze the heights."""
        height = np.array(self.height, dtype=np.float64)
        if height.shape != self.grid.shape or min(height.shape) < 2:
            raise SimulationError(f'heights have shape {height.shape}, expected {self.grid.shape} '
                                  'with at least 2 x 2 cells')
        if not np.isfinite(height).all():
            raise SimulationError('heights hold a number that is not finite')
        height.setflags(write=False)
        object.__setattr__(self, 'height', height)

    @classmethod
    def incline(cls, grid: Grid, slope_x: float, slope_y: float) -> 'HeightField':
        """Return a plane that rises by the slopes [-] and is at 0 in the middle of the grid."""
        away = grid.points - grid.points.mean(axis=0)
        return cls(grid, (away @ (slope_x, slope_y)).reshape(grid.shape))

    @property
    def relief(self) -> Relief:
        """What the soil's compiled code takes."""
        grid = self.grid
        return (np.array(self.height),
                np.array([grid.origin_x, grid.origin_y, grid.resolution]))


@njit(cache=True, error_model='numpy')
def height_at(relief: Relief, x: float, y: float) -> float:
    """Return the height of the undisturbed ground [m]."""
    height, place = relief
    if height.shape[0] < 2:
        return 0.0
    return bilinear(height, place[0], place[1], place[2], x, y)


@njit(cache=True, error_model='numpy')
def normal_at(relief: Relief, x: float, y: float) -> tuple[float, float, float]:
    """Return the upward unit normal of the undisturbed ground."""
    height, place = relief
    if height.shape[0] < 2:
        return 0.0, 0.0, 1.0
    half = 0.5 * place[2]
    slope_x = (height_at(relief, x + half, y) - height_at(relief, x - half, y)) / place[2]
    slope_y = (height_at(relief, x, y + half) - height_at(relief, x, y - half)) / place[2]
    up = 1.0 / math.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    return -slope_x * up, -slope_y * up, up


def no_prints() -> Prints:
    """Return ground in which nothing is left."""
    return np.zeros((1, 1, 4)), np.zeros(4), np.zeros(1)


def fresh_prints(cell: float, share: float, refill: float, compaction: float,
                 size: float = 10.0) -> Prints:
    """Return ground without footprints that remembers them from now on.

    Parameters
    ----------
    cell : float [m]
    share, refill, compaction : float
        See `SHARE`, `REFILL`, `COMPACTION`.
    size : float
        The field repeats itself after this length, so that a robot may walk on for ever [m].
    """
    count = max(2, round(size / cell))
    cells = np.zeros((count, count, 4))
    cells[:, :, TOUCHED] = -1.0e9
    return cells, np.array([size / count, share, refill, compaction]), np.zeros(1)


@njit(cache=True, inline='always', error_model='numpy')
def pit_at(prints: Prints, x: float, y: float, depth: float) -> float:
    """Return how far the ground at a plate is below where it was; note that the plate is there.

    Parameters
    ----------
    depth : float
        Of the plate below the undisturbed ground [m]; it is in the ground where this exceeds the
        result.
    """
    cells, settings, clock = prints
    count = cells.shape[0]
    column = int(math.floor(x / settings[CELL])) % count
    row = int(math.floor(y / settings[CELL])) % count
    cell = cells[row, column]
    now = clock[0]
    if settings[REFILL] > 0.0 and cell[PIT] > 0.0:
        cell[PIT] *= math.exp((cell[REFILLED] - now) / settings[REFILL])
    cell[REFILLED] = now
    if cell[PENDING] > 0.0 and now - cell[TOUCHED] > _RELEASE:
        # The foot that was here has gone: what it pressed down stays, but for what falls back.
        cell[PIT] = max(cell[PIT], settings[SHARE] * cell[PENDING])
        cell[PENDING] = 0.0
    if depth > cell[PIT]:
        cell[PENDING] = max(cell[PENDING], depth)
        cell[TOUCHED] = now
    return cell[PIT]


@njit(cache=True, inline='always', error_model='numpy')
def compaction_of(prints: Prints, pit: float) -> float:
    """Return the factor by which ground that was pressed down is stronger."""
    return 1.0 + prints[1][COMPACTION] * min(1.0, pit / FULL_COMPACTION)
