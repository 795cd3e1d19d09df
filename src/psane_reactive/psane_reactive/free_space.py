# SPDX-License-Identifier: Apache-2.0
"""Local free space in a disk world: the robot's cell of the power diagram, compiled."""

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray


@njit(cache=True)  # type: ignore[misc]
def clip_polygon(polygon: FloatArray, count: int, a: float, b: float, c: float,
                 result: FloatArray) -> int:
    """Write the part of a convex polygon with a x + b y <= c to `result`; return its size."""
    size = 0
    for k in range(count):
        following = (k + 1) % count
        here = a * polygon[k, 0] + b * polygon[k, 1] - c
        there = a * polygon[following, 0] + b * polygon[following, 1] - c
        if here <= 0.0:
            result[size] = polygon[k]
            size += 1
        if (here < 0.0 < there) or (there < 0.0 < here):
            share = here / (here - there)
            result[size] = polygon[k] + share * (polygon[following] - polygon[k])
            size += 1
    return size


@njit(cache=True)  # type: ignore[misc]
def nearest_in(polygon: FloatArray, count: int, x: float, y: float) -> tuple[float, float]:
    """Return the point of a convex counter-clockwise polygon nearest to (x, y)."""
    best, best_x, best_y, inside = np.inf, x, y, True
    for k in range(count):
        following = (k + 1) % count
        ax, ay = polygon[k, 0], polygon[k, 1]
        dx, dy = polygon[following, 0] - ax, polygon[following, 1] - ay
        if dx * (y - ay) - dy * (x - ax) < 0.0:
            inside = False
        square = dx * dx + dy * dy
        if square == 0.0:
            continue
        along = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / square))
        px, py = ax + along * dx, ay + along * dy
        distance = (px - x) ** 2 + (py - y) ** 2
        if distance < best:
            best, best_x, best_y = distance, px, py
    return (x, y) if inside else (best_x, best_y)


@njit(cache=True)  # type: ignore[misc]
def _is_cut_off(disks: FloatArray, x: float, y: float, goal_x: float, goal_y: float) -> bool:
    """Tell whether the robot's cell ends before the goal."""
    from_goal = (goal_x - x) ** 2 + (goal_y - y) ** 2
    for k in range(disks.shape[0]):
        from_disk = (goal_x - disks[k, 0]) ** 2 + (goal_y - disks[k, 1]) ** 2
        if from_goal > from_disk - disks[k, 2] ** 2:
            return True
    return False


@njit(cache=True)  # type: ignore[misc]
def local_goal(hull: FloatArray, disks: FloatArray, x: float, y: float, goal_x: float,
               goal_y: float) -> tuple[float, float]:
    """Return the point of the robot's local free space that is nearest to the goal.

    Parameters
    ----------
    hull : (h, 2) float [m]
        Corners of the convex workspace, counter-clockwise.
    disks : (d, 3) float [m]
        Centres and radii.

    Notes
    -----
    Arslan & Koditschek (2016): the cell of a point robot is { q : |q - x|^2 <= |q - c|^2 - r^2 }
    for all disks; moving towards the projected goal reaches it from almost everywhere.
    """
    size = hull.shape[0]
    if not _is_cut_off(disks, x, y, goal_x, goal_y):
        return nearest_in(hull, size, goal_x, goal_y)
    polygon = np.empty((size + disks.shape[0] + 2, 2))
    spare = np.empty_like(polygon)
    polygon[:size] = hull
    for k in range(disks.shape[0]):
        cx, cy, radius = disks[k, 0], disks[k, 1], disks[k, 2]
        c = cx * cx + cy * cy - radius * radius - x * x - y * y
        size = clip_polygon(polygon, size, 2.0 * (cx - x), 2.0 * (cy - y), c, spare)
        polygon, spare = spare, polygon
        if size < 3:
            return x, y
    return nearest_in(polygon, size, goal_x, goal_y)
