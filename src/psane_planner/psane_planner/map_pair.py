# SPDX-License-Identifier: Apache-2.0
"""Pairs the mean and the standard deviation of one and the same map."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, Grid
from psane_mapping.map_cells import slip_of_cells
from psane_planner.errors import MapError

Cells = NDArray[np.int8]


@dataclass(frozen=True)
class SlipMap:
    """Slip mean and standard deviation (rows, columns) [-] on a grid, at one time [s]."""

    grid: Grid
    time: float
    mean: FloatArray
    std: FloatArray


class MapPair:
    """Waits until mean, standard deviation and scale of one stamp are there."""

    def __init__(self) -> None:
        self._mean: tuple[Grid, float, Cells] | None = None
        self._std: tuple[Grid, float, Cells] | None = None
        self._scale: float | None = None

    def take_mean(self, grid: Grid, time: float, cells: Cells) -> None:
        """Take in the cells of the mean, stamped `time` [s]."""
        self._mean = (grid, time, cells)

    def take_std(self, grid: Grid, time: float, cells: Cells) -> None:
        """Take in the cells of the standard deviation, stamped `time` [s]."""
        self._std = (grid, time, cells)

    def take_scale(self, std_scale: float) -> None:
        """Take in one step of the standard deviation [-]."""
        self._scale = std_scale

    def pair(self) -> SlipMap | None:
        """Return the map if all its parts are there and of the same time.

        Raises
        ------
        MapError
            When mean and standard deviation of the same time have different grids.
        """
        if self._mean is None or self._std is None or self._scale is None:
            return None
        (grid, time, mean), (other, std_time, std) = self._mean, self._std
        if time != std_time:
            return None
        if grid != other:
            raise MapError(f'slip/mean has the grid {grid}, slip/std has {other}')
        return SlipMap(grid, time, *slip_of_cells(mean, std, self._scale))
