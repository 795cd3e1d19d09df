# SPDX-License-Identifier: Apache-2.0
"""Exact distances to the border of a region, for many small questions per tick."""

import math
from typing import Any, TypeAlias

import numpy as np
import shapely
from numba import njit

from psane_mapping.grid import FloatArray
from psane_reactive.border_index import LISTED, Segments, bucket_of, index_segments, nearest_border

Area: TypeAlias = shapely.Polygon | shapely.MultiPolygon


@njit(cache=True)  # type: ignore[misc]
def outside_distance(segments: Segments, x: float, y: float) -> float:
    """Return the signed distance of (x, y) to the border, negative inside [m]."""
    square, _, _, inside = nearest_border(segments, x, y)
    return -math.sqrt(square) if inside else math.sqrt(square)


@njit(cache=True)  # type: ignore[misc]
def _outside_distances(segments: Segments, points: FloatArray) -> FloatArray:
    distances = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        distances[i] = outside_distance(segments, points[i, 0], points[i, 1])
    return distances


@njit(cache=True)  # type: ignore[misc]
def _cross(ax: float, ay: float, bx: float, by: float) -> float:
    return ax * by - ay * bx


@njit(cache=True)  # type: ignore[misc]
def _square_to(x: float, y: float, ax: float, ay: float, dx: float, dy: float,
               length: float) -> float:
    """Return the squared distance of (x, y) to the segment from a along d, |d|^2 = length."""
    along = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / length))
    return (ax + along * dx - x) ** 2 + (ay + along * dy - y) ** 2


@njit(cache=True)  # type: ignore[misc]
def segment_distance(segments: Segments, px: float, py: float, qx: float, qy: float,
                     cap: float) -> float:
    """Return the distance of the segment p-q to the border, 0 when it crosses, at most `cap`."""
    low_x, high_x = min(px, qx) - cap, max(px, qx) + cap
    low_y, high_y = min(py, qy) - cap, max(py, qy) + cap
    best = cap * cap
    dx, dy = qx - px, qy - py
    length = max(dx * dx + dy * dy, 1e-18)
    ends = segments.ends
    bucket = bucket_of(segments, px, py)
    # All that a short segment can come near is listed in its bucket.
    is_listed = bucket >= 0 and math.sqrt(length) + cap < LISTED
    first = segments.offsets[bucket] if is_listed else 0
    last = segments.offsets[bucket + 1] if is_listed else ends.shape[0]
    for entry in range(first, last):
        i = segments.entries[entry] if is_listed else entry
        ax, ay, bx, by = ends[i, 0], ends[i, 1], ends[i, 2], ends[i, 3]
        if (max(ax, bx) < low_x or min(ax, bx) > high_x
                or max(ay, by) < low_y or min(ay, by) > high_y):
            continue
        ex, ey = bx - ax, by - ay
        side_a = _cross(dx, dy, ax - px, ay - py)
        side_b = _cross(dx, dy, bx - px, by - py)
        side_p = _cross(ex, ey, px - ax, py - ay)
        side_q = _cross(ex, ey, qx - ax, qy - ay)
        if side_a * side_b < 0.0 and side_p * side_q < 0.0:
            return 0.0
        edge = ex * ex + ey * ey
        # Segments that do not cross are nearest at an end of one of them.
        best = min(best, _square_to(px, py, ax, ay, ex, ey, edge),
                   _square_to(qx, qy, ax, ay, ex, ey, edge),
                   _square_to(ax, ay, px, py, dx, dy, length),
                   _square_to(bx, by, px, py, dx, dy, length))
    return math.sqrt(best)


@njit(cache=True)  # type: ignore[misc]
def _ray(segments: FloatArray, x: float, y: float, dx: float, dy: float, reach: float) -> float:
    """Return how far a ray with unit direction (dx, dy) gets before the border [m]."""
    best = reach
    for i in range(segments.shape[0]):
        ax, ay = segments[i, 0] - x, segments[i, 1] - y
        bx, by = segments[i, 2] - x, segments[i, 3] - y
        side_a = _cross(dx, dy, ax, ay)
        side_b = _cross(dx, dy, bx, by)
        if (side_a > 0.0) == (side_b > 0.0):
            continue
        share = side_a / (side_a - side_b)
        along = (ax + share * (bx - ax)) * dx + (ay + share * (by - ay)) * dy
        if 0.0 <= along < best:
            best = along
    return best


class Border:
    """All border segments of a region, with the distances that steering asks for.

    Parameters
    ----------
    area : Polygon or MultiPolygon, map frame [m]
        A valid area that is not empty.
    """

    def __init__(self, area: Area) -> None:
        rings = shapely.get_rings(shapely.get_parts(area))
        points, ring = shapely.get_coordinates(rings, return_index=True)
        segments = np.hstack((points[:-1], points[1:]))
        lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
        # What leads from one ring to the next is none.
        self.segments = index_segments(segments[(ring[:-1] == ring[1:]) & (lengths > 1e-12)])

    def outside_distance(self, point: Any) -> float:
        """Signed distance of a point (2,) [m] to the border; negative inside."""
        return float(outside_distance(self.segments, float(point[0]), float(point[1])))

    def outside_distances(self, points: FloatArray) -> FloatArray:
        """Signed distances of points (n, 2) [m], negative inside, (n,) [m]."""
        distances: FloatArray = _outside_distances(self.segments,
                                                   np.ascontiguousarray(points, dtype=np.float64))
        return distances

    def nearest(self, point: Any) -> FloatArray:
        """Return the border point nearest to a point, (2,) [m]."""
        _, x, y, _ = nearest_border(self.segments, float(point[0]), float(point[1]))
        return np.array((x, y))

    def segment_distance(self, start: Any, end: Any, cap: float) -> float:
        """Distance between a straight segment and the border, 0 when they cross, <= `cap` [m]."""
        return float(segment_distance(self.segments, float(start[0]), float(start[1]),
                                      float(end[0]), float(end[1]), cap))

    def ray(self, point: Any, heading: float, reach: float) -> float:
        """Distance from a point along a heading [rad] to the border, at most `reach` [m]."""
        return float(_ray(self.segments.ends, float(point[0]), float(point[1]), math.cos(heading),
                          math.sin(heading), reach))
