# SPDX-License-Identifier: Apache-2.0
"""Where a robot fits: safe ground with room around it, and a start and goal in it."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from psane_mapping.grid import FloatArray, Grid
from psane_planner.compiled import compiled

SAFE_SLIP = 0.5
"""Slip below which ground is called safe when terrains are made [-]."""

ROBOT_ROOM = 0.4
"""Distance that a robot's centre keeps from unsafe ground when terrains are made [m]."""


BORDER_ROOM = 1.0
"""Distance that a start or goal keeps from the workspace's edge when terrains are made [m]."""


def roomy(slip: FloatArray, grid: Grid, room: float = ROBOT_ROOM) -> NDArray[np.bool_]:
    """Return where a robot fits: further than `room` [m] from slip above `SAFE_SLIP`."""
    safe = np.pad(slip <= SAFE_SLIP, 1)
    distance = ndimage.distance_transform_edt(safe)[1:-1, 1:-1] * grid.resolution
    return np.asarray(distance > room)


def connected(slip: FloatArray, grid: Grid, start: tuple[float, float],
              goal: tuple[float, float], room: float = ROBOT_ROOM) -> bool:
    """Tell whether a robot fits at start and goal and all along some way between them."""
    parts, _ = ndimage.label(roomy(slip, grid, room))
    cells = grid.index_of(np.array([start, goal]))
    if not grid.contains(np.array([start, goal])).all():
        return False
    first, second = (int(parts[row, column]) for row, column in cells)
    return first == second and first > 0


def choose_endpoints(slip: FloatArray, grid: Grid
                     ) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Return two distant points of the largest roomy part, or None where nothing is roomy.

    Both keep away from the workspace's edge, whose ground is never certified. The goal is the
    point of that part farthest from its left-most point, along the part's own cells; the start
    is the one farthest from the goal.
    """
    inner = grid.distance_to_border() >= BORDER_ROOM
    for room in (ROBOT_ROOM, 0.2, 0.0):
        parts, count = ndimage.label(roomy(slip, grid, room) & inner)
        if count:
            sizes = ndimage.sum_labels(np.ones_like(parts), parts, np.arange(1, count + 1))
            part = parts == 1 + int(np.argmax(sizes))
            cells = np.argwhere(part)
            goal = _farthest(part, cells[np.argmin(cells[:, 1])])
            start = _farthest(part, goal)
            ends = grid.point_of(np.array([start, goal]))
            return (tuple(ends[0].tolist()), tuple(ends[1].tolist()))
    return None


def _farthest(part: NDArray[np.bool_], seed: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a cell of the part that is reached last when it is flooded from the seed."""
    steps = _flood(part, int(seed[0]), int(seed[1]))
    return np.argwhere(steps == steps.max())[0]


@compiled
def _flood(part: NDArray[np.bool_], row: int, column: int) -> NDArray[np.int64]:
    """Return steps from edge to edge to each cell of the part, -1 where none lead."""
    rows, columns = part.shape
    steps = np.full((rows, columns), -1, np.int64)
    queue = np.empty((rows * columns, 2), np.int64)
    queue[0, 0], queue[0, 1] = row, column
    steps[row, column] = 0
    first, last = 0, 1
    while first < last:
        r, c = queue[first, 0], queue[first, 1]
        first += 1
        for i, j in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)):
            if 0 <= i < rows and 0 <= j < columns and part[i, j] and steps[i, j] < 0:
                steps[i, j] = steps[r, c] + 1
                queue[last, 0], queue[last, 1] = i, j
                last += 1
    return steps
