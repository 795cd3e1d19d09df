# SPDX-License-Identifier: Apache-2.0
"""Scores a run against the truth, which no other part of the stack ever sees."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from psane_mapping.grid import FloatArray, Grid
from psane_sim.terrains.terrain import Terrain

BoolArray = NDArray[np.bool_]

PATH_STEP = 0.05
"""Path length is summed over moves of at least this [m], so that a stride's sway is left out."""


@dataclass(frozen=True, kw_only=True)
class Score:
    """How a run went, by the truth.

    Parameters
    ----------
    path_m : float
        Length of the way of the body's centre [m].
    unsafe_time_s, unsafe_foot_share : float
        Time that the centre was on ground whose true slip exceeds the threshold [s], and the share
        of foot positions that were [-].
    false_certified_cells : int
        Cells that were certified at any time and are truly unsafe [count].
    certified_cells : int
        Cells certified at the end [count].
    coverage : float
        Certified, as a share of the truly safe cells that can be reached from the start [-].
    """

    path_m: float
    unsafe_time_s: float
    unsafe_foot_share: float
    false_certified_cells: int
    certified_cells: int
    coverage: float


def reachable_safe_cells(terrain: Terrain, grid: Grid, start: FloatArray,
                         threshold: float) -> BoolArray:
    """Mask (rows, columns) of the truly safe cells connected with the start's cell.

    Parameters
    ----------
    start : (2,) float, map frame [m]
    threshold : float
        Largest safe slip [-].
    """
    safe = terrain.true_slip(grid.points).reshape(grid.shape) <= threshold
    labels, _ = ndimage.label(safe)
    row, column = grid.index_of(start)
    label = labels[row, column]
    return np.asarray((labels == label) & (label > 0))


class Scorer:
    """Gathers the truth of a run, and judges it.

    Parameters
    ----------
    terrain : Terrain
        The true ground.
    grid : Grid
        The cells that are certified.
    start : (2,) float, map frame [m]
    threshold : float
        Largest safe slip [-].
    """

    def __init__(self, terrain: Terrain, grid: Grid, start: FloatArray, threshold: float) -> None:
        self._terrain = terrain
        self._threshold = threshold
        self._is_unsafe = terrain.true_slip(grid.points).reshape(grid.shape) > threshold
        self._reachable = reachable_safe_cells(terrain, grid, start, threshold)
        self._certified = np.zeros(grid.shape, dtype=bool)
        self._false = np.zeros(grid.shape, dtype=bool)
        self._last_step = np.asarray(start, dtype=np.float64)
        self._path = 0.0
        self._unsafe_time = 0.0
        self._feet = 0
        self._unsafe_feet = 0

    def observe(self, centre: FloatArray, feet: FloatArray, duration: float,
                slip: FloatArray | None = None) -> None:
        """Take in where the robot truly is.

        Parameters
        ----------
        centre : (2,) float, map frame [m]
        feet : (n, 2) float, map frame [m]
            Feet that press on the ground.
        duration : float
            Time for which this holds [s].
        slip : (1 + n,) float [-], optional
            True slip under centre and feet, where that is known already.
        """
        if slip is None:
            slip = self._terrain.true_slip(np.concatenate((centre[None, :], feet)))
        unsafe = slip > self._threshold
        self._unsafe_time += duration * bool(unsafe[0])
        self._feet += len(feet)
        self._unsafe_feet += int(np.count_nonzero(unsafe[1:]))
        step = math.dist(centre, self._last_step)
        if step >= PATH_STEP:
            self._path += step
            self._last_step = np.array(centre, dtype=np.float64)

    def certified(self, mask: BoolArray) -> None:
        """Take in a new mask (rows, columns) of certified cells."""
        if mask is self._certified and not mask.flags.writeable:
            return
        self._certified = np.asarray(mask, dtype=bool)
        self._false |= self._certified & self._is_unsafe

    @property
    def unsafe_time(self) -> float:
        """Time that the centre was on unsafe ground so far [s]."""
        return self._unsafe_time

    @property
    def false_cells(self) -> BoolArray:
        """Cells (rows, columns) that were certified at any time and are truly unsafe."""
        return self._false.copy()

    def score(self) -> Score:
        """Return the score so far."""
        reachable = int(self._reachable.sum())
        found = int((self._certified & self._reachable).sum())
        return Score(
            path_m=self._path,
            unsafe_time_s=self._unsafe_time,
            unsafe_foot_share=self._unsafe_feet / max(self._feet, 1),
            false_certified_cells=int(self._false.sum()),
            certified_cells=int(self._certified.sum()),
            coverage=found / max(reachable, 1),
        )
