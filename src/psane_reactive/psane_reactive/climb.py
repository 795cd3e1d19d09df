# SPDX-License-Identifier: Apache-2.0
"""Climb a field over cells, from neighbour to neighbour, without crossing a border."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, IndexArray

Mask = NDArray[np.bool_]

_STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1))


@njit(cache=True)  # type: ignore[misc]
def _is_link(row: int, column: int, down: int, right: int, open_right: Mask,
             open_up: Mask) -> bool:
    """Tell whether a step along a row or a column stays inside the region."""
    first_row, first_column = row + min(down, 0), column + min(right, 0)
    if first_row < 0 or first_column < 0:
        return False
    links = open_up if down != 0 else open_right
    return bool(links[first_row, first_column])


@njit(cache=True)  # type: ignore[misc]
def _is_open(row: int, column: int, down: int, right: int, open_right: Mask,
             open_up: Mask) -> bool:
    """Tell whether a step to one of the eight neighbours stays inside the region."""
    if down == 0 or right == 0:
        return bool(_is_link(row, column, down, right, open_right, open_up))
    return bool(_is_link(row, column, down, 0, open_right, open_up)
                and _is_link(row, column, 0, right, open_right, open_up)
                and _is_link(row + down, column, 0, right, open_right, open_up)
                and _is_link(row, column + right, down, 0, open_right, open_up))


@njit(cache=True)  # type: ignore[misc]
def _uphill(here: int, values: FloatArray, cells: IndexArray, number: IndexArray,
            open_right: Mask, open_up: Mask) -> int:
    """Return the neighbour with the steepest rise of log u, -1 when there is none."""
    row, column = cells[here]
    best, steepest = -1, 0.0
    for down, right in _STEPS:
        if not _is_open(row, column, down, right, open_right, open_up):
            continue
        other = number[row + down, column + right]
        rise = math.log(values[other] / values[here]) / math.sqrt(down * down + right * right)
        if rise > steepest:
            best, steepest = other, rise
    return best


@njit(cache=True)  # type: ignore[misc]
def climb(values: FloatArray, here: int, end: int, reach: float, centres: FloatArray,
          cells: IndexArray, number: IndexArray, open_right: Mask, open_up: Mask) -> IndexArray:
    """Return the cells on the steepest way up from a cell, the first one included.

    Parameters
    ----------
    values : (n,) float
        The field u of each inside cell; above 0 at `here`.
    here, end : int
        Indices of inside cells.
    reach : float
        The way ends once it is this long [m], or at `end`.
    centres : (n, 2) float, map frame [m]
    cells : (n, 2) int
        Row and column.
    number : (rows, columns) int
        Index of each inside cell.
    open_right, open_up : (rows, columns) bool
        Cells that can be left to the right and upwards.

    Returns
    -------
    (k,) int, empty where the way comes to a halt before its end.
    """
    steps = np.empty(values.size + 1, np.int64)
    steps[0], count, length = here, 1, 0.0
    while here != end and length < reach:
        following = _uphill(here, values, cells, number, open_right, open_up)
        if following < 0:
            return steps[:0]
        length += math.hypot(centres[following, 0] - centres[here, 0],
                             centres[following, 1] - centres[here, 1])
        here = following
        steps[count] = here
        count += 1
    return steps[:count]
