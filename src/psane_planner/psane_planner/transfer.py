# SPDX-License-Identifier: Apache-2.0
"""Carry what is known of cells over to a grid of another extent, as when the map has grown."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import Grid

# So far off a whole number of cells two grids may lie, in cells.
_TOLERANCE = 1e-3


class Transfer(NamedTuple):
    """How cells of an old grid are numbered on a new one.

    Parameters
    ----------
    rows, columns : int
        What is added to the old row and column [cells].
    shape : (int, int)
        Rows and columns of the new grid.
    """

    rows: int
    columns: int
    shape: tuple[int, int]

    def of(self, array: NDArray[Any], filling: Any) -> NDArray[Any]:
        """Return an array (rows, columns) on the new grid, with `filling` where nothing was."""
        moved = np.full(self.shape, filling, dtype=array.dtype)
        new_rows, old_rows = _overlap(self.rows, array.shape[0], self.shape[0])
        new_columns, old_columns = _overlap(self.columns, array.shape[1], self.shape[1])
        moved[new_rows, new_columns] = array[old_rows, old_columns]
        return moved


def transfer_between(old: Grid, new: Grid) -> Transfer | None:
    """Return how to carry cells over, or None when the cells of the grids do not coincide."""
    if abs(new.resolution - old.resolution) > 1e-9:
        return None
    rows = (old.origin_y - new.origin_y) / new.resolution
    columns = (old.origin_x - new.origin_x) / new.resolution
    if max(abs(rows - round(rows)), abs(columns - round(columns))) > _TOLERANCE:
        return None
    return Transfer(round(rows), round(columns), new.shape)


def _overlap(offset: int, old: int, new: int) -> tuple[slice, slice]:
    """Return the cells in both grids, along one axis, counted on the new and on the old one."""
    first, last = max(0, offset), max(max(0, offset), min(new, old + offset))
    return slice(first, last), slice(first - offset, last - offset)
