# SPDX-License-Identifier: Apache-2.0
"""Pick the point to drive at: the farthest one on the way that can be driven at straight."""

import math

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray
from psane_reactive.border_index import Segments, nearest_border
from psane_reactive.clearance import Border, segment_distance
from psane_reactive.model_map import Way

_SPACING = 0.08
# A straight line from a place that is closer to the edge than the margin keeps this share of it.
_KEPT = 0.9


@njit(cache=True)  # type: ignore[misc]
def _resample(way: FloatArray, x: float, y: float, reach: float, spacing: float) -> FloatArray:
    """Return points of a way every `spacing` metres up to `reach`, its end included."""
    points = np.empty((int(reach / spacing) + 2, 2))
    count, left = 0, spacing
    travelled = 0.0
    for i in range(way.shape[0]):
        length = math.hypot(way[i, 0] - x, way[i, 1] - y)
        while left <= length and travelled + left <= reach and count < points.shape[0] - 1:
            x += (way[i, 0] - x) * left / length
            y += (way[i, 1] - y) * left / length
            length -= left
            travelled += left
            left = spacing
            points[count, 0], points[count, 1] = x, y
            count += 1
        if travelled + left > reach:
            return points[:count]
        travelled += length
        left -= length
        x, y = way[i, 0], way[i, 1]
    points[count, 0], points[count, 1] = x, y
    return points[:count + 1]


@njit(cache=True)  # type: ignore[misc]
def _push_inside(segments: Segments, points: FloatArray, count: int, margin: float) -> None:
    """Move the first `count` points away from the edge up to the margin, where there is room."""
    for i in range(count):
        x, y = points[i, 0], points[i, 1]
        square, edge_x, edge_y, inside = nearest_border(segments, x, y)
        depth = math.sqrt(square) if inside else -math.sqrt(square)
        if depth >= margin or abs(depth) < 1e-9:
            continue
        scale = (margin - depth) / depth
        for share in (1.0, 0.5, 0.25):
            new_x, new_y = x + share * scale * (x - edge_x), y + share * scale * (y - edge_y)
            new_square, _, _, new_inside = nearest_border(segments, new_x, new_y)
            if new_inside and math.sqrt(new_square) > depth:
                points[i, 0], points[i, 1] = new_x, new_y
                break


@njit(cache=True)  # type: ignore[misc]
def _is_clear(segments: Segments, x: float, y: float, own: float, target_x: float,
              target_y: float, margin: float) -> bool:
    """Tell whether a straight line keeps the margin, or as much of it as its ends have."""
    square, _, _, inside = nearest_border(segments, target_x, target_y)
    if not inside:
        return False
    wanted = min(margin, _KEPT * own, _KEPT * math.sqrt(square))
    return segment_distance(segments, x, y, target_x, target_y, wanted + 1e-9) >= wanted > 0.0


@njit(cache=True)  # type: ignore[misc]
def _farthest_clear(segments: Segments, x: float, y: float, points: FloatArray,
                    margin: float) -> int:
    """Return the last point that is clear and not where the robot is already, -1 for none."""
    square, _, _, _ = nearest_border(segments, x, y)
    own = math.sqrt(square)
    for i in range(points.shape[0] - 1, -1, -1):
        if (math.hypot(points[i, 0] - x, points[i, 1] - y) > 0.5 * _SPACING
                and _is_clear(segments, x, y, own, points[i, 0], points[i, 1], margin)):
            return i
    return -1


@njit(cache=True)  # type: ignore[misc]
def _choose(segments: Segments, x: float, y: float, way: FloatArray, ends_at_goal: bool,
            reach: float, margin: float) -> tuple[float, float]:
    """Return the farthest point of a way that is clear, with less and less margin."""
    points = _resample(way, x, y, reach, _SPACING)
    pushed = points.copy()
    goal_included = (ends_at_goal and points.shape[0] > 0
                     and points[-1, 0] == way[-1, 0] and points[-1, 1] == way[-1, 1])
    _push_inside(segments, pushed, points.shape[0] - (1 if goal_included else 0), margin)
    for share in (1.0, 0.4, 0.1):
        chosen = _farthest_clear(segments, x, y, pushed, share * margin)
        if chosen >= 0:
            return pushed[chosen, 0], pushed[chosen, 1]
    chosen = _farthest_clear(segments, x, y, points, 0.1 * margin)
    if chosen >= 0:
        return points[chosen, 0], points[chosen, 1]
    # Too near the edge to see along the way: a step inwards comes first.
    here = np.array([[x, y]])
    _push_inside(segments, here, 1, margin)
    if math.hypot(here[0, 0] - x, here[0, 1] - y) > 0.1 * margin:
        return here[0, 0], here[0, 1]
    for i in range(points.shape[0]):
        if math.hypot(points[i, 0] - x, points[i, 1] - y) > 0.25 * _SPACING:
            return points[i, 0], points[i, 1]
    return way[-1, 0], way[-1, 1]


def is_visible(border: Border, position: FloatArray, goal: FloatArray, margin: float) -> bool:
    """Tell whether the straight line to a goal, (2,) [m], keeps `margin` [m] from the edge."""
    own = -border.outside_distance(position)
    return own > 0.0 and bool(_is_clear(border.segments, float(position[0]), float(position[1]),
                                        own, float(goal[0]), float(goal[1]), margin))


def aim_along(border: Border, position: FloatArray, way: Way, reach: float,
              margin: float) -> FloatArray:
    """Return the point (2,) [m] to drive at.

    Parameters
    ----------
    position : (2,) float, map frame [m]
    reach : float
        How far along the way to look [m].
    margin : float
        Distance to keep from the edge where there is room [m].
    """
    points = np.ascontiguousarray(way.points, dtype=np.float64)
    return np.array(_choose(border.segments, float(position[0]), float(position[1]), points,
                            way.ends_at_goal, reach, margin))
