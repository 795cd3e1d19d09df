# SPDX-License-Identifier: Apache-2.0
"""The connected piece of certified ground that the robot stands on."""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, Grid
from psane_planner.compiled import compiled
from psane_planner.window import window_around


class Component(NamedTuple):
    """Connected certified cells around the robot.

    Parameters
    ----------
    mask : (rows, columns) bool
        Cells joined edge to edge (4-connected: two cells that meet at a corner leave no ground
        with clearance between them).
    outside_distance : float [m]
        Distance of the robot to the nearest certified square, 0 on it, infinite without any.
    """

    mask: NDArray[np.bool_]
    outside_distance: float


def component_around(certified: NDArray[np.bool_], grid: Grid,
                     position: FloatArray) -> Component:
    """Return the piece of `certified` that holds, or lies nearest to, `position` (2,) [m]."""
    return Components(certified, grid).around(position)


class Components:
    """The connected pieces of certified ground.

    Parameters
    ----------
    certified : (rows, columns) bool
        Must not be changed any more.
    grid : Grid
    """

    def __init__(self, certified: NDArray[np.bool_], grid: Grid) -> None:
        self.certified = certified
        self._grid = grid
        self._masks: dict[int, NDArray[np.bool_]] = {}
        # Beside the window there is nothing, so that the pieces in it are all there are.
        self._where = window_around(certified, 1)
        if self._where is not None:
            _, labels = cv2.connectedComponents(
                certified[self._where].astype(np.uint8), connectivity=4)
            self._labels = np.asarray(labels, dtype=np.int32)
            self._part = self._where.of(grid)
            self._lines = self._part.x, self._part.y

    def around(self, position: FloatArray) -> Component:
        """Return the piece that holds, or lies nearest to, `position` (2,) [m]."""
        if self._where is None:
            return Component(np.zeros(self._grid.shape, dtype=np.bool_), float('inf'))
        cell, squared = _nearest(self._labels, *self._lines, float(position[0]),
                                 float(position[1]), self._grid.resolution / 2.0)
        label = int(self._labels.flat[cell])
        if label not in self._masks:
            mask = np.zeros(self._grid.shape, dtype=np.bool_)
            mask[self._where] = self._labels == label
            mask.setflags(write=False)
            self._masks[label] = mask
        return Component(self._masks[label], math.sqrt(squared))


@compiled
def _nearest(labels: NDArray[np.int32], x: FloatArray, y: FloatArray, at_x: float, at_y: float,
             half: float) -> tuple[int, float]:
    """Return the first labelled square nearest to a point, and its squared distance."""
    best, least = 0, np.inf
    for r in range(y.size):
        aside = max(abs(y[r] - at_y) - half, 0.0)
        in_row = aside * aside
        if in_row >= least:
            continue
        for c in range(x.size):
            if labels[r, c] == 0:
                continue
            aside = max(abs(x[c] - at_x) - half, 0.0)
            squared = in_row + aside * aside
            if squared < least:
                best, least = r * x.size + c, squared
    return best, least
