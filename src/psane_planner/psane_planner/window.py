# SPDX-License-Identifier: Apache-2.0
"""The part of a grid where something is: what lies outside of it needs no work."""

from typing import NamedTuple

import numpy as np

from psane_mapping.grid import Grid
from psane_planner.discs import Integers, Mask


class Window(NamedTuple):
    """A rectangle of cells; index an array with it to see that part of the array."""

    rows: slice
    columns: slice

    def of(self, grid: Grid) -> Grid:
        """Return the cells of `grid` in the window, as a grid in the same frame."""
        return Grid(origin_x=grid.origin_x + self.columns.start * grid.resolution,
                    origin_y=grid.origin_y + self.rows.start * grid.resolution,
                    resolution=grid.resolution, rows=self.rows.stop - self.rows.start,
                    columns=self.columns.stop - self.columns.start)


def window_around(mask: Mask, margin: int) -> Window | None:
    """Return the least window with all marked cells and `margin` more on each side.

    It is cut at the grid's edge; None when nothing is marked.
    """
    rows = np.flatnonzero(mask.any(axis=1))
    if rows.size == 0:
        return None
    columns = np.flatnonzero(mask[rows[0]:rows[-1] + 1].any(axis=0))
    return Window(_widened(rows, margin, mask.shape[0]), _widened(columns, margin, mask.shape[1]))


def _widened(indices: Integers, margin: int, size: int) -> slice:
    return slice(max(0, int(indices[0]) - margin), min(size, int(indices[-1]) + margin + 1))
