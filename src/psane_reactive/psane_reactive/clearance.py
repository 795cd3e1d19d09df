# SPDX-License-Identifier: Apache-2.0
"""Exact distances to the border of a region, compiled, for many small questions per tick."""

import math
from typing import Any

import numpy as np
import shapely
from numba import njit
from psane_mapping.grid import FloatArray

Area = shapely.Polygon | shapely.MultiPolygon


@njit(cache=True)  # type: ignore[misc]
def _nearest(segments: FloatArray, x: float, y: float) -> tuple[float, float, float, bool]:
    """Return squared distance, nearest border point and whether (x, y) is inside (even-odd)."""
    best = np.inf
    best_x = np.nan
    best_y = np.nan
    inside = False
    for i in range(segments.shape[0]):
        ax, ay, bx, by = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
        dx, dy = bx - ax, by - ay
        if (ay > y) != (by > y) and x < ax + (y - ay) / dy * dx:
            inside = not inside
        along = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)
        along = min(1.0, max(0.0, along))
        px, py = ax + along * dx, ay + along * dy
        square = (px - x) ** 2 + (py - y) ** 2
        if square < best:
            best, best_x, best_y = square, px, py
    return best, best_x, best_y, inside


@njit(cache=True)  # type: ignore[misc]
def _outside_distances(segments: FloatArray, points: FloatArray) -> FloatArray:
    """Return signed distances, negative inside, (n,) [m]."""
    distances = np.empty(points.shape[0])
    for i in range(points.shape[0]):
        square, _, _, inside = _nearest(segments, points[i, 0], points[i, 1])
        distances[i] = -math.sqrt(square) if inside else math.sqrt(square)
    return distances


@njit(cache=True)  # type: ignore[misc]
def _cross(ax: float, ay: float, bx: float, by: float) -> float:
    return ax * by - ay * bx


@njit(cache=True)  # type: ignore[misc]
def _segment_distance(segments: FloatArray, px: float, py: float, qx: float, qy: float,
                      cap: float) -> float:
    """Return the distance of the segment p-q to the border, 0 when it crosses, at most `cap`."""
    low_x, high_x = min(px, qx) - cap, max(px, qx) + cap
    low_y, high_y = min(py, qy) - cap, max(py, qy) + cap
    best = cap * cap
    dx, dy = qx - px, qy - py
    length = max(dx * dx + dy * dy, 1e-18)
    for i in range(segments.shape[0]):
        ax, ay, bx, by = segments[i, 0], segments[i, 1], segments[i, 2], segments[i, 3]
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
        for k in range(4):
            # End points of one segment against the other one.
            if k < 2:
                sx, sy = (px, py) if k == 0 else (qx, qy)
                t = min(1.0, max(0.0, ((sx - ax) * ex + (sy - ay) * ey) / edge))
                gap = (ax + t * ex - sx) ** 2 + (ay + t * ey - sy) ** 2
            else:
                sx, sy = (ax, ay) if k == 2 else (bx, by)
                t = min(1.0, max(0.0, ((sx - px) * dx + (sy - py) * dy) / length))
                gap = (px + t * dx - sx) ** 2 + (py + t * dy - sy) ** 2
            best = min(best, gap)
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
        parts = area.geoms if isinstance(area, shapely.MultiPolygon) else (area,)
        rings = [ring for part in parts for ring in (part.exterior, *part.interiors)]
        pieces = [_ring_segments(np.asarray(ring.coords)[:, :2]) for ring in rings]
        self.segments = np.ascontiguousarray(np.concatenate(pieces), dtype=np.float64)
        self.segments.setflags(write=False)

    def outside_distance(self, point: Any) -> float:
        """Signed distance of a point (2,) [m] to the border; negative inside."""
        square, _, _, inside = _nearest(self.segments, float(point[0]), float(point[1]))
        distance = math.sqrt(square)
        return -distance if inside else distance

    def outside_distances(self, points: FloatArray) -> FloatArray:
        """Signed distances of points (n, 2) [m], negative inside, (n,) [m]."""
        distances: FloatArray = _outside_distances(self.segments,
                                                   np.ascontiguousarray(points, dtype=np.float64))
        return distances

    def nearest(self, point: Any) -> FloatArray:
        """Return the border point nearest to a point, (2,) [m]."""
        _, x, y, _ = _nearest(self.segments, float(point[0]), float(point[1]))
        return np.array((x, y))

    def segment_distance(self, start: Any, end: Any, cap: float) -> float:
        """Distance between a straight segment and the border, 0 when they cross, <= `cap` [m]."""
        return float(_segment_distance(self.segments, float(start[0]), float(start[1]),
                                       float(end[0]), float(end[1]), cap))

    def ray(self, point: Any, heading: float, reach: float) -> float:
        """Distance from a point along a heading [rad] to the border, at most `reach` [m]."""
        return float(_ray(self.segments, float(point[0]), float(point[1]), math.cos(heading),
                          math.sin(heading), reach))


def _ring_segments(ring: FloatArray) -> FloatArray:
    """Return the segments (n, 4) of a closed ring of coordinates, those without length left out."""
    segments = np.hstack((ring[:-1], ring[1:]))
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    kept: FloatArray = segments[lengths > 1e-12]
    return kept
