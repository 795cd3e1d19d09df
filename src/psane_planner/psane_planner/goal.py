# SPDX-License-Identifier: Apache-2.0
"""Where a goal may lie, and the nearest place where it might when it does not."""

from typing import NamedTuple

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.discs import Mask


class Refusal(NamedTuple):
    """Why a goal is not taken, and what would be.

    Parameters
    ----------
    cause, remedy : str
    nearest : (2,) float, map frame [m], or None
        Nearest goal that would be taken.
    """

    cause: str
    remedy: str
    nearest: FloatArray | None


def refuse_goal(goal: FloatArray, grid: Grid, admissible: Mask, lower: FloatArray,
                threshold: float, tolerance: float) -> Refusal | None:
    """Return why `goal` cannot be taken, or None when it can.

    Parameters
    ----------
    goal : (2,) float, map frame [m]
    admissible : (rows, columns) bool
        Cells that may be certified.
    lower : (rows, columns) float [-], slip ratio
        Lower ends of the confidence intervals; above `threshold` ground is known to be unsafe.
    tolerance : float [m]
        Distance at which a goal counts as reached.
    """
    inside = bool(grid.contains(goal))
    row, column = grid.index_of(goal)
    if not inside:
        return _refusal(goal, 'lies outside the workspace', grid, admissible)
    if not admissible[row, column]:
        return _refusal(goal, 'lies in the border of the workspace or in keep-out ground',
                        grid, admissible)
    possible = admissible & ~(lower > threshold)
    if possible[row, column]:
        return None
    nearest = _nearest(goal, grid, possible)
    if nearest is not None and np.hypot(*(nearest - goal)) <= tolerance:
        return None
    return _refusal(goal, 'lies in ground that is known to be unsafe', grid, possible)


def _refusal(goal: FloatArray, why: str, grid: Grid, allowed: Mask) -> Refusal:
    nearest = _nearest(goal, grid, allowed)
    cause = f'the goal ({goal[0]:.2f}, {goal[1]:.2f}) m {why}'
    if nearest is None:
        return Refusal(cause, 'no cell of the workspace may be walked on; '
                       'check the border width and the keep-out mask', None)
    return Refusal(cause, f'set a goal that may be certified; the nearest is '
                   f'({nearest[0]:.2f}, {nearest[1]:.2f}) m', nearest)


def _nearest(goal: FloatArray, grid: Grid, allowed: Mask) -> FloatArray | None:
    cells = np.argwhere(allowed)
    if cells.size == 0:
        return None
    points = grid.point_of(cells)
    nearest: FloatArray = points[np.argmin(((points - goal) ** 2).sum(axis=1))]
    return nearest
