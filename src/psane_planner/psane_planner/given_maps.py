# SPDX-License-Identifier: Apache-2.0
"""Maps of ground that is known beforehand, as they come, and as masks on the planner's grid."""

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import Grid
from psane_planner.discs import Mask
from psane_planner.given_areas import covered, touched

OCCUPIED = 50
"""Least cell value of an OccupancyGrid that counts as marked."""

Cells = NDArray[np.int8]


class GivenMaps:
    """Keeps the last map of either kind; masks are made anew only for another grid or map.

    Notes
    -----
    A cell of the planner is to be kept out of when anything marked touches it, and is known to be
    safe only when all of it is marked so.
    """

    def __init__(self) -> None:
        """Start with nothing known."""
        self._keep_out: tuple[Grid, Mask] | None = None
        self._known_safe: tuple[Grid, Mask] | None = None
        self._made: tuple[Grid, Mask | None, Mask | None] | None = None

    def take_keep_out(self, grid: Grid, cells: Cells) -> None:
        """Take in ground to keep out of: cells (rows, columns) of at least `OCCUPIED`."""
        self._keep_out = (grid, cells >= OCCUPIED)
        self._made = None

    def take_known_safe(self, grid: Grid, cells: Cells) -> None:
        """Take in ground that is safe: cells (rows, columns) of at least `OCCUPIED`."""
        self._known_safe = (grid, cells >= OCCUPIED)
        self._made = None

    def masks_on(self, grid: Grid) -> tuple[Mask | None, Mask | None]:
        """Return keep-out and known-safe cells of `grid`; None where no map was taken."""
        if self._made is None or self._made[0] != grid:
            keep_out = None if self._keep_out is None else touched(grid, *self._keep_out)
            safe = None if self._known_safe is None else covered(grid, *self._known_safe)
            self._made = (grid, keep_out, safe)
        return self._made[1:]
