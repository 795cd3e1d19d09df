# SPDX-License-Identifier: Apache-2.0
"""Room for the robots that are in the way: ground near them is not certified."""

from collections.abc import Sequence

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.discs import Mask

ROOM = 0.8
"""Distance between the centres of two robots that is kept, less the clearance of the region [m];
the bodies touch at 0.7 m at the most."""


def taken_cells(grid: Grid, others: Sequence[FloatArray], room: float = ROOM) -> Mask:
    """Return the cells (rows, columns) whose centre is nearer than `room` [m] to another robot.

    Parameters
    ----------
    others : sequence of (2,) float, map frame [m]
    """
    taken = np.zeros(grid.rows * grid.columns, dtype=np.bool_)
    for point in others:
        taken |= np.hypot(*(grid.points - point).T) < room
    return taken.reshape(grid.shape)


def least_distance(ways: Sequence[Sequence[tuple[float, float, float]]]) -> float:
    """Return how near two robots came to each other [m]; infinite for fewer than two.

    Parameters
    ----------
    ways : sequence of sequences of (time, x, y)
        Each robot's way [s], [m]. Before and after it, the robot stands at its end.
    """
    tables = [np.array(way) for way in ways if way]
    nearest = np.inf
    for index, first in enumerate(tables):
        for second in tables[index + 1:]:
            times = np.union1d(first[:, 0], second[:, 0])
            gaps = [np.interp(times, first[:, 0], first[:, axis])
                    - np.interp(times, second[:, 0], second[:, axis]) for axis in (1, 2)]
            nearest = min(nearest, float(np.hypot(*gaps).min()))
    return nearest
