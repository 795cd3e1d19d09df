# SPDX-License-Identifier: Apache-2.0
"""Walk through a triangle mesh, compiled: find points and pull straight lines back."""

import math

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray, IndexArray
from psane_reactive.mesh_edges import edges_of, neighbours_across, places_of


def neighbours_of(triangles: IndexArray) -> IndexArray:
    """Return the triangle across edge (k, k + 1) of each triangle, -1 at the border, (m, 3)."""
    edges = edges_of(triangles, int(triangles.max()) + 1)
    found: IndexArray = neighbours_across(edges, triangles)
    return found


def owners_of(triangles: IndexArray, starts: IndexArray, ends: IndexArray) -> IndexArray:
    """Return the triangle that has each directed edge start-end, (k,)."""
    edges = edges_of(triangles, int(triangles.max()) + 1)
    owners: IndexArray = places_of(edges, starts, ends) // 3
    return owners


@njit(cache=True, error_model='numpy')  # type: ignore[misc]
def barycentric(points: FloatArray, triangle: IndexArray, x: float, y: float,
                ) -> tuple[float, float, float]:
    """Return the barycentric coordinates of (x, y) [-]; not finite in one without area."""
    ax, ay = points[triangle[0], 0], points[triangle[0], 1]
    bx, by = points[triangle[1], 0] - ax, points[triangle[1], 1] - ay
    cx, cy = points[triangle[2], 0] - ax, points[triangle[2], 1] - ay
    area = bx * cy - by * cx
    second = ((x - ax) * cy - (y - ay) * cx) / area
    third = (bx * (y - ay) - by * (x - ax)) / area
    return 1.0 - second - third, second, third


@njit(cache=True)  # type: ignore[misc]
def fill_buckets(points: FloatArray, triangles: IndexArray, low_x: float, low_y: float,
                 size: float, columns: int, rows: int) -> tuple[IndexArray, IndexArray]:
    """List the triangles whose box touches each square bucket: offsets and indices."""
    offsets = np.zeros(columns * rows + 1, dtype=np.int64)
    entries = np.empty(0, dtype=np.int64)
    for is_second in range(2):
        filled = offsets[:-1].copy()
        for t in range(triangles.shape[0]):
            x0, x1, y0, y1 = np.inf, -np.inf, np.inf, -np.inf
            for k in range(3):
                x, y = points[triangles[t, k], 0], points[triangles[t, k], 1]
                x0, x1, y0, y1 = min(x0, x), max(x1, x), min(y0, y), max(y1, y)
            for row in range(int((y0 - low_y) / size), int((y1 - low_y) / size) + 1):
                for column in range(int((x0 - low_x) / size), int((x1 - low_x) / size) + 1):
                    bucket = row * columns + column
                    if is_second:
                        entries[filled[bucket]] = t
                        filled[bucket] += 1
                    else:
                        offsets[bucket + 1] += 1
        if not is_second:
            offsets = np.cumsum(offsets)
            entries = np.empty(offsets[-1], dtype=np.int64)
    return offsets, entries


@njit(cache=True)  # type: ignore[misc]
def locate(points: FloatArray, triangles: IndexArray, offsets: IndexArray, entries: IndexArray,
           corner: FloatArray, size: float, columns: int, rows: int, x: float, y: float) -> int:
    """Return the triangle that holds (x, y), -1 when none does."""
    column, row = math.floor((x - corner[0]) / size), math.floor((y - corner[1]) / size)
    if column < 0 or row < 0 or column >= columns or row >= rows:
        return -1
    best, depth = -1, -1e-9
    bucket = row * columns + column
    for entry in range(offsets[bucket], offsets[bucket + 1]):
        t = entries[entry]
        first, second, third = barycentric(points, triangles[t], x, y)
        inside = min(first, second, third)
        if inside > depth:
            best, depth = t, inside
    return best


@njit(cache=True)  # type: ignore[misc]
def pull_back_line(vertices: FloatArray, model: FloatArray, triangles: IndexArray,
                   neighbours: IndexArray, hubs_from: int, start: int, start_model: FloatArray,
                   goal: int, goal_model: FloatArray, position: FloatArray, reach: float,
                   ) -> tuple[FloatArray, int, float]:
    """Pull the straight line between two points of the disk back into the region.

    Returns
    -------
    The way (k, 2) [m] without its start, to the goal's triangle; how many of its points the first
    `reach` [m] take, -1 when the walk failed; and the length of all of it [m].

    Notes
    -----
    Only the sides of the line on which vertices lie decide where the walk goes. Where it crosses
    a fan edge, between a hub and the border of a hole, the way goes through that border vertex:
    so it slides along the hole on the side on which the line passes the hub.
    """
    way = np.empty((2 * triangles.shape[0] + 8, 2))
    count, kept, length, came_from, t = 0, 0, 0.0, -1, start
    x, y = position[0], position[1]
    dx, dy = goal_model[0] - start_model[0], goal_model[1] - start_model[1]
    for _ in range(2 * triangles.shape[0] + 4):
        if length < reach:
            kept = count
        if t == goal:
            return way[:count], min(count, kept + 1), length
        exit_edge = -1
        side_i, side_j = 0.0, 0.0
        for k in range(3):
            i, j = triangles[t, k], triangles[t, (k + 1) % 3]
            side_i = dx * (model[i, 1] - start_model[1]) - dy * (model[i, 0] - start_model[0])
            side_j = dx * (model[j, 1] - start_model[1]) - dy * (model[j, 0] - start_model[0])
            if side_i < 0.0 <= side_j and (neighbours[t, k] != came_from or came_from < 0):
                exit_edge = k
                break
        if exit_edge < 0 or neighbours[t, exit_edge] < 0:
            return way[:count], -1, length
        i, j = triangles[t, exit_edge], triangles[t, (exit_edge + 1) % 3]
        if i >= hubs_from:
            next_x, next_y = vertices[j, 0], vertices[j, 1]
        elif j >= hubs_from:
            next_x, next_y = vertices[i, 0], vertices[i, 1]
        else:
            share = side_i / (side_i - side_j)
            next_x = vertices[i, 0] + share * (vertices[j, 0] - vertices[i, 0])
            next_y = vertices[i, 1] + share * (vertices[j, 1] - vertices[i, 1])
        step = math.hypot(next_x - x, next_y - y)
        if step > 1e-9:
            way[count, 0], way[count, 1] = next_x, next_y
            count += 1
            length += step
        x, y = next_x, next_y
        came_from, t = t, neighbours[t, exit_edge]
    return way[:count], -1, length
