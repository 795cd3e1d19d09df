# SPDX-License-Identifier: Apache-2.0
"""Distance along the ground: the eikonal equation on the cells that may be walked on."""

import math

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.compiled import compiled
from psane_planner.discs import Integers, Mask

_SEED_RADIUS = 6
_NEAR_RADIUS = 2


@compiled
def _is_clear(passable: Mask, row: float, column: float, to_row: int, to_column: int) -> bool:
    """Tell whether the straight line between two points crosses passable cells only."""
    steps = int(4.0 * max(abs(to_row - row), abs(to_column - column))) + 1
    for k in range(1, steps + 1):
        r = int(math.floor(row + (to_row - row) * k / steps + 0.5))
        c = int(math.floor(column + (to_column - column) * k / steps + 0.5))
        if r < 0 or c < 0 or r >= passable.shape[0] or c >= passable.shape[1]:
            return False
        if not passable[r, c]:
            return False
    return True


@compiled
def _seed(passable: Mask, row: float, column: float, field: FloatArray, fixed: Mask,
          radius: int) -> int:
    """Write exact distances around the source where it is in plain view; return how many."""
    count = 0
    for r in range(max(0, int(row) - radius), min(passable.shape[0], int(row) + radius + 2)):
        for c in range(max(0, int(column) - radius),
                       min(passable.shape[1], int(column) + radius + 2)):
            distance = math.hypot(r - row, c - column)
            if passable[r, c] and distance <= radius and _is_clear(passable, row, column, r, c):
                field[r, c] = distance
                fixed[r, c] = True
                count += 1
    return count


@compiled
def _wake(cost: FloatArray, fixed: Mask, due: Mask, waiting: Integers, row: int,
          column: int) -> None:
    """Mark the four neighbours of a cell whose value fell as due for another look."""
    for r, c in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)):
        if r < 0 or c < 0 or r >= cost.shape[0] or c >= cost.shape[1]:
            continue
        if not due[r, c] and not fixed[r, c] and cost[r, c] < np.inf:
            due[r, c] = True
            waiting[r] += 1


@compiled
def _sweep(cost: FloatArray, fixed: Mask, field: FloatArray, due: Mask, waiting: Integers,
           down: bool, right: bool) -> None:
    """Relax every cell that is due once, in one of four orders."""
    rows, columns = cost.shape
    for i in range(rows):
        r = i if down else rows - 1 - i
        if waiting[r] == 0:
            continue
        for j in range(columns):
            c = j if right else columns - 1 - j
            if not due[r, c]:
                continue
            due[r, c] = False
            waiting[r] -= 1
            a = min(field[r - 1, c] if r > 0 else np.inf,
                    field[r + 1, c] if r + 1 < rows else np.inf)
            b = min(field[r, c - 1] if c > 0 else np.inf,
                    field[r, c + 1] if c + 1 < columns else np.inf)
            low, high = min(a, b), max(a, b)
            step = cost[r, c]
            value = low + step
            if high < value:
                value = 0.5 * (low + high + math.sqrt(2.0 * step**2 - (high - low) ** 2))
            if value < field[r, c] - 1e-9:
                field[r, c] = value
                _wake(cost, fixed, due, waiting, r, c)


@compiled
def _relax(cost: FloatArray, fixed: Mask, field: FloatArray) -> None:
    """Sweep in the four orders in turn until none of them lowers a value any more.

    A cell is looked at again only once a neighbour has fallen: before that it would stay as it is.
    """
    due = np.zeros(cost.shape, np.bool_)
    waiting = np.zeros(cost.shape[0], np.int64)
    for r in range(cost.shape[0]):
        for c in range(cost.shape[1]):
            if field[r, c] < np.inf:
                _wake(cost, fixed, due, waiting, r, c)
    order = 0
    while waiting.any():
        _sweep(cost, fixed, field, due, waiting, order < 2, order % 2 == 0)
        order = (order + 1) % 4


@compiled
def _solve(cost: FloatArray, row: float, column: float, radius: int) -> FloatArray:
    field = np.full(cost.shape, np.inf)
    fixed = np.zeros(cost.shape, np.bool_)
    passable = cost < np.inf
    at_row, at_column, beside = int(math.floor(row + 0.5)), int(math.floor(column + 0.5)), 0.0
    if _seed(passable, row, column, field, fixed, radius) == 0:
        nearest = np.inf
        for r in range(cost.shape[0]):
            for c in range(cost.shape[1]):
                distance = math.hypot(r - row, c - column)
                if passable[r, c] and distance < nearest:
                    nearest, at_row, at_column = distance, r, c
        if nearest == np.inf:
            return field
        _seed(passable, float(at_row), float(at_column), field, fixed, radius)
        beside = nearest
    at_row = min(max(at_row, 0), cost.shape[0] - 1)
    at_column = min(max(at_column, 0), cost.shape[1] - 1)
    # Close to the source the ground is taken to be as its own cell is.
    own = cost[at_row, at_column] if passable[at_row, at_column] else 1.0
    field = own * field + beside
    _relax(cost, fixed, field)
    return field


def distance_along(passable: Mask, grid: Grid, source: FloatArray) -> FloatArray:
    """Return the length of the shortest way over passable cells from a point to every cell.

    Parameters
    ----------
    passable : (rows, columns) bool
    source : (2,) float, map frame [m]
        Where it does not lie on a passable cell, the way begins with a straight step to the
        nearest one.

    Returns
    -------
    (rows, columns) float [m], infinite where no way leads.

    Notes
    -----
    Fast sweeping (Zhao 2005) of the first-order upwind scheme; cells in plain view of the source
    within six cells are exact, which keeps the scheme's error near a point source away.
    """
    cost = np.where(passable, 1.0, np.inf)
    return _solve(cost, *_place(grid, source), _SEED_RADIUS) * grid.resolution


def least_cost(cost: FloatArray, grid: Grid, source: FloatArray) -> FloatArray:
    """Return the least cost of a way from a point to every cell, over ground of uneven cost.

    Parameters
    ----------
    cost : (rows, columns) float [1/m]
        Of a metre, infinite where there is no way.
    source : (2,) float, map frame [m]
        As in `distance_along`.

    Returns
    -------
    (rows, columns) float [-], infinite where no way leads.
    """
    return _solve(cost, *_place(grid, source), _NEAR_RADIUS) * grid.resolution


def travel_time(slowness: FloatArray, grid: Grid, source: FloatArray) -> FloatArray:
    """Return the least time from a point to every cell over ground that slows the robot.

    Parameters
    ----------
    slowness : (rows, columns) float [s/m]
        Time for a metre, infinite where there is no way.
    source : (2,) float, map frame [m]
        Lies in the grid; where it is not on passable ground, there is no way.

    Returns
    -------
    (rows, columns) float [s], infinite where no way leads.
    """
    row, column = grid.index_of(source)
    if not np.isfinite(slowness[row, column]):
        return np.full(grid.shape, np.inf)
    return least_cost(slowness, grid, source)


def _place(grid: Grid, point: FloatArray) -> tuple[float, float]:
    """Return row and column of a point (2,) [m] as real numbers, whole at centres of cells."""
    return (float((point[1] - grid.origin_y) / grid.resolution - 0.5),
            float((point[0] - grid.origin_x) / grid.resolution - 0.5))


@compiled
def _reach_out(field: FloatArray, cells: Integers, reach: float) -> FloatArray:
    rows, columns = field.shape
    window = int(reach)
    aside = np.full((2 * window + 1, 2 * window + 1), np.inf)
    for i in range(-window, window + 1):
        for j in range(-window, window + 1):
            away = math.hypot(i, j)
            if away <= reach:
                aside[i + window, j + window] = away
    result = np.full(cells.shape[0], np.inf)
    for k in range(cells.shape[0]):
        row, column, least = cells[k, 0], cells[k, 1], np.inf
        for r in range(max(0, row - window), min(rows, row + window + 1)):
            for c in range(max(0, column - window), min(columns, column + window + 1)):
                least = min(least, field[r, c] + aside[r - row + window, c - column + window])
        result[k] = least
    return result


def distance_within_reach(field: FloatArray, cells: Integers, grid: Grid,
                          reach: float) -> FloatArray:
    """Extend a distance to cells that lie up to `reach` beside the ground it was solved on.

    Parameters
    ----------
    field : (rows, columns) float [m]
    cells : (n, 2) int
    reach : float [m]

    Returns
    -------
    (n,) float [m], infinite where nothing walked on comes within reach.
    """
    return _reach_out(field / grid.resolution, cells, reach / grid.resolution) * grid.resolution
