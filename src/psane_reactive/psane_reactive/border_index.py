# SPDX-License-Identifier: Apache-2.0
"""Border segments in buckets, compiled: nearest border point and inside or outside, exactly."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, IndexArray

# Distance up to which a bucket lists the border around it, and the edge of a bucket [m], longer
# where a region would need more than so many along one side.
LISTED = 0.3
_SIZE = 0.25
_MOST = 300


class Segments(NamedTuple):
    """Border segments, and for each square bucket those that are near it.

    Parameters
    ----------
    ends : (n, 4) float, map frame [m]
        Start x, y and end x, y.
    corner : (2,) float, map frame [m]
        Lower corner of bucket (0, 0).
    size : float
        Edge of a bucket [m].
    anchors_inside : (rows, columns) bool
        Whether a fixed point of each bucket lies inside the region.
    offsets : (rows * columns + 1,) int
    entries : (k,) int
        Segments listed for each bucket.
    """

    ends: FloatArray
    corner: FloatArray
    size: float
    anchors_inside: NDArray[np.bool_]
    offsets: IndexArray
    entries: IndexArray


@njit(cache=True)  # type: ignore[misc]
def bucket_of(segments: Segments, x: float, y: float) -> int:
    """Return the number of the bucket that holds (x, y), -1 outside all of them."""
    rows, columns = segments.anchors_inside.shape
    column = math.floor((x - segments.corner[0]) / segments.size)
    row = math.floor((y - segments.corner[1]) / segments.size)
    if 0 <= row < rows and 0 <= column < columns:
        return row * columns + column
    return -1


@njit(cache=True)  # type: ignore[misc]
def _anchor(corner: FloatArray, size: float, row: int, column: int) -> tuple[float, float]:
    """Return a bucket's anchor; its uneven place avoids the lines on which borders often lie."""
    return corner[0] + (column + 0.5012347) * size, corner[1] + (row + 0.4987659) * size


@njit(cache=True)  # type: ignore[misc]
def _crosses_level(a: float, b: float, a_other: float, b_other: float, level: float, low: float,
                   high: float) -> bool:
    """Tell whether a segment crosses the line at `level` between `low` and `high` along it."""
    if (a > level) == (b > level):
        return False
    place = a_other + (level - a) / (b - a) * (b_other - a_other)
    return low < place <= high


@njit(cache=True)  # type: ignore[misc]
def _square_distance(ends: FloatArray, i: int, x: float, y: float) -> tuple[float, float, float]:
    """Return squared distance to segment i and the nearest point on it."""
    ax, ay = ends[i, 0], ends[i, 1]
    dx, dy = ends[i, 2] - ax, ends[i, 3] - ay
    along = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)))
    px, py = ax + along * dx, ay + along * dy
    return (px - x) ** 2 + (py - y) ** 2, px, py


@njit(cache=True)  # type: ignore[misc]
def nearest_by_all(ends: FloatArray, x: float, y: float) -> tuple[float, float, float, bool]:
    """Return squared distance, nearest border point and whether (x, y) is inside (even-odd)."""
    best, best_x, best_y, inside = np.inf, np.nan, np.nan, False
    for i in range(ends.shape[0]):
        if _crosses_level(ends[i, 1], ends[i, 3], ends[i, 0], ends[i, 2], y, x, np.inf):
            inside = not inside
        square, px, py = _square_distance(ends, i, x, y)
        if square < best:
            best, best_x, best_y = square, px, py
    return best, best_x, best_y, inside


@njit(cache=True)  # type: ignore[misc]
def nearest_border(segments: Segments, x: float, y: float) -> tuple[float, float, float, bool]:
    """Do the same through the buckets: exact, and cheap near the border.

    Notes
    -----
    Inside is counted from the bucket's anchor, along y and then along x: that way stays within
    the bucket, so that all segments which it can cross are listed.
    """
    ends = segments.ends
    bucket = bucket_of(segments, x, y)
    if bucket < 0:
        return nearest_by_all(ends, x, y)
    row, column = divmod(bucket, segments.anchors_inside.shape[1])
    anchor_x, anchor_y = _anchor(segments.corner, segments.size, row, column)
    inside = segments.anchors_inside[row, column]
    best, best_x, best_y = np.inf, np.nan, np.nan
    for entry in range(segments.offsets[bucket], segments.offsets[bucket + 1]):
        i = segments.entries[entry]
        ax, ay, bx, by = ends[i, 0], ends[i, 1], ends[i, 2], ends[i, 3]
        if _crosses_level(ax, bx, ay, by, anchor_x, min(y, anchor_y), max(y, anchor_y)):
            inside = not inside
        if _crosses_level(ay, by, ax, bx, y, min(x, anchor_x), max(x, anchor_x)):
            inside = not inside
        square, px, py = _square_distance(ends, i, x, y)
        if square < best:
            best, best_x, best_y = square, px, py
    if best > LISTED * LISTED:
        best, best_x, best_y, inside = nearest_by_all(ends, x, y)
    return best, best_x, best_y, inside


@njit(cache=True)  # type: ignore[misc]
def _index(ends: FloatArray, corner: FloatArray, size: float, rows: int, columns: int,
           ) -> tuple[NDArray[np.bool_], IndexArray, IndexArray]:
    """Return anchors inside, offsets and entries of the buckets (see `Segments`)."""
    anchors_inside = np.zeros((rows, columns), dtype=np.bool_)
    for i in range(ends.shape[0]):
        x0, y0, x1, y1 = ends[i, 0], ends[i, 1], ends[i, 2], ends[i, 3]
        low, high = min(y0, y1), max(y0, y1)
        # One row more on each side than round-off can need.
        for row in range(max(0, math.floor((low - corner[1]) / size) - 1),
                         min(rows, math.floor((high - corner[1]) / size) + 2)):
            for column in range(columns):
                x, y = _anchor(corner, size, row, column)
                if not _crosses_level(y0, y1, x0, x1, y, x, np.inf):
                    break
                anchors_inside[row, column] = not anchors_inside[row, column]
    offsets = np.zeros(rows * columns + 1, dtype=np.int64)
    entries = np.empty(0, dtype=np.int64)
    for is_second in range(2):
        filled = offsets[:-1].copy()
        for i in range(ends.shape[0]):
            x0, x1 = min(ends[i, 0], ends[i, 2]) - LISTED, max(ends[i, 0], ends[i, 2]) + LISTED
            y0, y1 = min(ends[i, 1], ends[i, 3]) - LISTED, max(ends[i, 1], ends[i, 3]) + LISTED
            for row in range(max(0, math.floor((y0 - corner[1]) / size)),
                             min(rows, math.floor((y1 - corner[1]) / size) + 1)):
                for column in range(max(0, math.floor((x0 - corner[0]) / size)),
                                    min(columns, math.floor((x1 - corner[0]) / size) + 1)):
                    bucket = row * columns + column
                    if is_second == 1:
                        entries[filled[bucket]] = i
                        filled[bucket] += 1
                    else:
                        offsets[bucket + 1] += 1
        if is_second == 0:
            offsets = np.cumsum(offsets)
            entries = np.empty(offsets[-1], dtype=np.int64)
    return anchors_inside, offsets, entries


@njit(cache=True)  # type: ignore[misc]
def _extent(ends: FloatArray) -> tuple[float, float, float, float]:
    """Return the least and the largest x, then those of y."""
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    for i in range(ends.shape[0]):
        low_x, high_x = min(low_x, ends[i, 0], ends[i, 2]), max(high_x, ends[i, 0], ends[i, 2])
        low_y, high_y = min(low_y, ends[i, 1], ends[i, 3]), max(high_y, ends[i, 1], ends[i, 3])
    return low_x, high_x, low_y, high_y


def index_segments(ends: FloatArray) -> Segments:
    """Sort border segments (n, 4) [m] into buckets."""
    low_x, high_x, low_y, high_y = _extent(ends)
    corner = np.array((low_x - LISTED, low_y - LISTED))
    width, height = high_x + LISTED - corner[0], high_y + LISTED - corner[1]
    size = max(_SIZE, float(max(width, height)) / _MOST)
    columns, rows = int(width / size) + 1, int(height / size) + 1
    return Segments(ends, corner, size, *_index(ends, corner, size, rows, columns))
