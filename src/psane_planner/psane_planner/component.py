# SPDX-License-Identifier: Apache-2.0
"""The connected piece of certified ground that the robot stands on."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, Grid
from psane_planner.window import Window, window_around


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
    if not certified.any():
        return Component(np.zeros(grid.shape, dtype=np.bool_), float('inf'))
    # Beside the window there is nothing, so that the pieces in it are all there are.
    where = window_around(certified, 1) or Window(slice(0, 0), slice(0, 0))
    part = where.of(grid)
    half = grid.resolution / 2.0
    aside_x = np.maximum(np.abs(part.x - position[0]) - half, 0.0)
    aside_y = np.maximum(np.abs(part.y - position[1]) - half, 0.0)
    squared = aside_y[:, None] ** 2 + aside_x[None, :] ** 2
    nearest = int(np.argmin(np.where(certified[where], squared, np.inf)))
    _, labels = cv2.connectedComponents(certified[where].astype(np.uint8), connectivity=4)
    mask = np.zeros(grid.shape, dtype=np.bool_)
    mask[where] = labels == labels.flat[nearest]
    mask.setflags(write=False)
    return Component(mask, float(np.sqrt(squared.flat[nearest])))
