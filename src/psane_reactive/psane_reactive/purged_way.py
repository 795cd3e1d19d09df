# SPDX-License-Identifier: Apache-2.0
"""Follow the disk world's law back in the region, compiled."""

import math

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray
from psane_reactive.border_index import Segments, nearest_border
from psane_reactive.clearance import segment_distance
from psane_reactive.free_space import local_goal
from psane_reactive.purge import Chain, purge

# Steps along the way, and how near to the edge they are let [m].
_STEP = 0.04
_SMALLEST_STEP = 0.0002
_EDGE = 0.005
_MOST_STEPS = 1000
_FINE_STEP = 0.01
_MEMORY = 12


@njit(cache=True)  # type: ignore[misc]
def direction(chain: Chain, hull: FloatArray, disks: FloatArray, x: float, y: float,
              goal_image: FloatArray, jacobian: FloatArray) -> tuple[float, float, float]:
    """Return the unit direction of the pulled-back law, (0, 0) where there is none.

    Returns
    -------
    Direction, and the distance of the point's image to the goal's [m].

    Notes
    -----
    x' = J^-1 (y* - y); the determinant is positive, so the adjugate has the same direction.
    """
    u, v = purge(chain, x, y, jacobian)
    target_u, target_v = local_goal(hull, disks, u, v, goal_image[0], goal_image[1])
    du, dv = target_u - u, target_v - v
    dx = jacobian[1, 1] * du - jacobian[0, 1] * dv
    dy = jacobian[0, 0] * dv - jacobian[1, 0] * du
    length = math.hypot(dx, dy)
    left = math.hypot(goal_image[0] - u, goal_image[1] - v)
    if not length > 1e-200:
        return 0.0, 0.0, left
    return dx / length, dy / length, left


@njit(cache=True)  # type: ignore[misc]
def _kept_inside(border: Segments, x: float, y: float) -> tuple[float, float, bool]:
    """Return a point, moved to the edge's inner side where it lies on or just beyond the edge."""
    square, edge_x, edge_y, inside = nearest_border(border, x, y)
    distance = math.sqrt(square)
    if inside and distance >= _EDGE:
        return x, y, True
    if distance < 1e-12 or distance > _STEP:
        return x, y, inside
    scale = (_EDGE if inside else -_EDGE) / distance
    moved_x, moved_y = edge_x + scale * (x - edge_x), edge_y + scale * (y - edge_y)
    _, _, _, is_inside = nearest_border(border, moved_x, moved_y)
    return (moved_x, moved_y, True) if is_inside else (x, y, inside)


@njit(cache=True)  # type: ignore[misc]
def follow(chain: Chain, hull: FloatArray, disks: FloatArray, border: Segments,
           start: FloatArray, goal: FloatArray, goal_image: FloatArray, reach: float,
           ) -> tuple[FloatArray, bool]:
    """Return the way (k, 2) [m] without its start, and whether it ends at the goal.

    Notes
    -----
    Midpoint rule with steps that are halved until they stay inside the region and bring the
    image nearer to the goal's than it was some steps ago: in the disk world the law does so
    everywhere (Arslan & Koditschek 2016). Next to the edge, where the map changes within less
    than a step, a fine one is taken all the same.
    """
    way, jacobian = np.empty((_MOST_STEPS, 2)), np.empty((2, 2))
    x, y = start[0], start[1]
    dx, dy, left = direction(chain, hull, disks, x, y, goal_image, jacobian)
    lefts = np.full(_MEMORY, 1.01 * left)
    count, length, step = 0, 0.0, _STEP
    while count < _MOST_STEPS and length < reach and step >= _SMALLEST_STEP:
        away = math.hypot(goal[0] - x, goal[1] - y)
        if away <= _STEP and segment_distance(border, x, y, goal[0], goal[1], 1e-6) > 0.0:
            return way[:count], True
        mx, my, _ = direction(chain, hull, disks, x + 0.5 * step * dx, y + 0.5 * step * dy,
                              goal_image, jacobian)
        next_x, next_y, inside = _kept_inside(border, x + step * mx, y + step * my)
        moved = math.hypot(next_x - x, next_y - y)
        if not inside or segment_distance(border, x, y, next_x, next_y, 1e-9) == 0.0:
            step *= 0.5
            continue
        next_dx, next_dy, next_left = direction(chain, hull, disks, next_x, next_y, goal_image,
                                                jacobian)
        if next_left >= lefts.max() and step > _FINE_STEP:
            step *= 0.5
            continue
        lefts[count % _MEMORY] = next_left
        way[count, 0], way[count, 1] = next_x, next_y
        count += 1
        length += moved
        x, y, dx, dy = next_x, next_y, next_dx, next_dy
        step = min(_STEP, 2.0 * step)
    return way[:count], False
