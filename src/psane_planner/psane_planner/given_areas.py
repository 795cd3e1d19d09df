# SPDX-License-Identifier: Apache-2.0
"""Ground that is known beforehand: areas to keep out of, and areas that are safe."""

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.discs import Mask

# So far inside its square a corner is looked up, that it does not fall into the next cell.
_INSET = 1e-6


def touched(grid: Grid, other: Grid, mask: Mask) -> Mask:
    """Return the cells of `grid` that a marked cell of another grid touches.

    Parameters
    ----------
    grid : Grid
    other : Grid
        Of any resolution and extent, in the same frame.
    mask : (rows, columns) bool
        On the other grid.

    Returns
    -------
    (rows, columns) bool, on `grid`.
    """
    coarser = np.zeros(grid.shape, dtype=np.bool_)
    _mark(coarser, grid, other.point_of(np.argwhere(mask)), other.resolution)
    # Where the other cells are the larger ones, the corners of this grid's cells find them.
    half = 0.5 * grid.resolution * (1.0 - _INSET)
    finer = np.zeros(grid.shape, dtype=np.bool_)
    for x, y in ((0.0, 0.0), (-half, -half), (-half, half), (half, -half), (half, half)):
        points = grid.points + (x, y)
        inside = other.contains(points)
        cells = other.index_of(points[inside])
        finer.ravel()[inside] |= mask[cells[:, 0], cells[:, 1]]
    return coarser | finer


def _mark(marked: Mask, grid: Grid, centres: FloatArray, edge: float) -> None:
    """Mark the cells of `grid` that hold the centre or a corner of squares."""
    half = 0.5 * edge * (1.0 - _INSET)
    for x, y in ((0.0, 0.0), (-half, -half), (-half, half), (half, -half), (half, half)):
        points = centres + (x, y)
        cells = grid.index_of(points[grid.contains(points)])
        marked[cells[:, 0], cells[:, 1]] = True


def covered(grid: Grid, other: Grid, mask: Mask) -> Mask:
    """Return the cells of `grid` that lie wholly in marked cells of another grid."""
    half = 0.5 * grid.resolution * (1.0 - _INSET)
    inside = np.ones(grid.shape, dtype=np.bool_)
    for x, y in ((-half, -half), (-half, half), (half, -half), (half, half)):
        inside &= np.asarray(other.contains(grid.points + (x, y))).reshape(grid.shape)
    return inside & ~touched(grid, other, ~mask)
