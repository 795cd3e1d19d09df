# SPDX-License-Identifier: Apache-2.0
"""Cones over cells, in whole numbers: where bound + L * distance stays below the threshold.

The cells x' with ``bound(x) + L |x - x'| <= h`` form a disc around x. Squared distances between
cells are whole numbers, so the disc is known by one whole number, its largest squared radius.
The union of such discs is where the power distance ``min (|x - x'|^2 - radius^2)`` is not
positive, and that minimum separates into one pass over columns and one over rows.
"""

import math

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_planner.compiled import compiled

Mask = NDArray[np.bool_]
Integers = NDArray[np.int64]
NO_DISC = -1
_FAR = np.int64(2**40)


@compiled
def squared_radii(bound: FloatArray, threshold: float, slope: float, resolution: float,
                  limit: int) -> Integers:
    """Return the largest m with ``bound + slope * (resolution * sqrt(m)) <= threshold``.

    Parameters
    ----------
    bound : (n,) float [-], slip ratio
    threshold : float [-], slip ratio
    slope : float [1/m]
    resolution : float [m]
    limit : int [cells^2]
        Largest radius that is told apart.

    Returns
    -------
    (n,) int [cells^2], `NO_DISC` where even m = 0 is too much (or `bound` is NaN).

    Notes
    -----
    The quotient only starts the search; the comparison itself is evaluated, so that the result
    agrees with testing every pair of cells to the last bit.
    """
    result = np.empty(bound.size, np.int64)
    for k in range(bound.size):
        start = (threshold - bound[k]) / (slope * resolution)
        if not start >= -1.0:
            result[k] = -1
            continue
        m = limit if start * start >= limit else int(start * start)
        while m < limit and bound[k] + slope * (resolution * math.sqrt(m + 1.0)) <= threshold:
            m += 1
        while m >= 0 and not bound[k] + slope * (resolution * math.sqrt(float(m))) <= threshold:
            m -= 1
        result[k] = m
    return result


@compiled
def _lower_envelope(values: Integers, result: Integers, vertex: Integers,
                    start: FloatArray) -> None:
    """Write ``min_q (p - q)^2 + values[q]`` for every p (Felzenszwalb & Huttenlocher 2012).

    The meeting point of two parabolas is a quotient of whole numbers far below 2^53: it is
    exact when whole, and otherwise too far from a whole number to be rounded across it.
    """
    top = -1
    for q in range(values.size):
        if values[q] >= _FAR:
            continue
        meet = -np.inf
        while top >= 0:
            v = vertex[top]
            meet = ((values[q] + q * q) - (values[v] + v * v)) / (2.0 * (q - v))
            if meet > start[top]:
                break
            top -= 1
            meet = -np.inf
        top += 1
        vertex[top] = q
        start[top] = meet
    piece = 0
    for p in range(values.size):
        if top < 0:
            result[p] = _FAR
            continue
        while piece < top and start[piece + 1] < p:
            piece += 1
        result[p] = (p - vertex[piece]) ** 2 + values[vertex[piece]]


@compiled
def union_of_discs(radii: Integers) -> Mask:
    """Return the cells covered by at least one disc.

    Parameters
    ----------
    radii : (rows, columns) int [cells^2]
        Squared radius of the disc around each cell, `NO_DISC` for none.
    """
    rows, columns = radii.shape
    size = max(rows, columns)
    vertex, start = np.empty(size, np.int64), np.empty(size, np.float64)
    line, best = np.empty(size, np.int64), np.empty(size, np.int64)
    columnwise = np.empty((rows, columns), np.int64)
    covered = np.empty((rows, columns), np.bool_)
    for c in range(columns):
        for r in range(rows):
            line[r] = -radii[r, c] if radii[r, c] >= 0 else _FAR
        _lower_envelope(line[:rows], best[:rows], vertex, start)
        for r in range(rows):
            columnwise[r, c] = best[r]
    for r in range(rows):
        _lower_envelope(columnwise[r], best[:columns], vertex, start)
        for c in range(columns):
            covered[r, c] = best[c] <= 0
    return covered


@compiled
def count_in_discs(targets: Mask | Integers, cells: Integers, radii: Integers) -> Integers:
    """Count target cells in the disc around each of some cells.

    Parameters
    ----------
    targets : (rows, columns) bool or int
        Numbers are added up.
    cells : (n, 2) int
        Row and column of the centres.
    radii : (n,) int [cells^2]

    Returns
    -------
    (n,) int [-], count.
    """
    rows, columns = targets.shape
    before = np.zeros((rows, columns + 1), np.int64)
    for r in range(rows):
        for c in range(columns):
            before[r, c + 1] = before[r, c] + targets[r, c]
    counts = np.zeros(cells.shape[0], np.int64)
    for k in range(cells.shape[0]):
        if radii[k] < 0:
            continue
        reach = int(math.sqrt(float(radii[k])))
        for r in range(max(0, cells[k, 0] - reach), min(rows, cells[k, 0] + reach + 1)):
            half = int(math.sqrt(float(radii[k] - (r - cells[k, 0]) ** 2)))
            left = max(0, cells[k, 1] - half)
            right = min(columns, cells[k, 1] + half + 1)
            counts[k] += before[r, right] - before[r, left]
    return counts
