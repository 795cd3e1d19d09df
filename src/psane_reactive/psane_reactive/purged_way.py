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
_SMALLEST_STEP = 0.0005
_EDGE = 0.001
_MOST_STEPS = 400


@njit(cache=True)  # type: ignore[misc]
def direction(chain: Chain, hull: FloatArray, disks: FloatArray, x: float, y: float,
              goal_image: FloatArray, jacobian: FloatArray) -> tuple[float, float]:
    """Return the unit direction of the pulled-back law, (0, 0) where there is none.

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
    if not length > 1e-200:
        return 0.0, 0.0
    return dx / length, dy / length


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
    Midpoint rule with steps that are halved until they stay inside the region.
    """
    way, jacobian = np.empty((_MOST_STEPS, 2)), np.empty((2, 2))
    x, y = start[0], start[1]
    count, length, step = 0, 0.0, _STEP
    for _ in range(3 * _MOST_STEPS):
        if count == _MOST_STEPS or length >= reach or step < _SMALLEST_STEP:
            break
        away = math.hypot(goal[0] - x, goal[1] - y)
        if away <= _STEP and segment_distance(border, x, y, goal[0], goal[1], 1e-6) > 0.0:
            return way[:count], True
        dx, dy = direction(chain, hull, disks, x, y, goal_image, jacobian)
        middle_x, middle_y = x + 0.5 * step * dx, y + 0.5 * step * dy
        mx, my = direction(chain, hull, disks, middle_x, middle_y, goal_image, jacobian)
        if dx * mx + dy * my <= 0.0:
            mx, my = dx, dy
            step *= 0.5
        next_x, next_y, inside = _kept_inside(border, x + step * mx, y + step * my)
        if not inside or segment_distance(border, x, y, next_x, next_y, 1e-9) == 0.0:
            step *= 0.5
            continue
        moved = math.hypot(next_x - x, next_y - y)
        if moved < _SMALLEST_STEP:
            break
        way[count, 0], way[count, 1] = next_x, next_y
        count += 1
        length += moved
        x, y, step = next_x, next_y, min(_STEP, 2.0 * step)
    return way[:count], False
