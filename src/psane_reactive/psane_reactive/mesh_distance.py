# SPDX-License-Identifier: Apache-2.0
"""Shortest ways along the edges of a mesh, compiled: which side of a hole is the short one."""

import heapq
import math

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray, IndexArray
from psane_reactive.mesh import Mesh
from psane_reactive.trace import neighbours_of


@njit(cache=True)  # type: ignore[misc]
def _spread(offsets: IndexArray, ends: IndexArray, lengths: FloatArray, sources: IndexArray,
            begin: FloatArray) -> tuple[FloatArray, IndexArray]:
    """Return the distance of each vertex to the sources [m], and the next vertex on the way."""
    count = offsets.shape[0] - 1
    distance, following = np.full(count, np.inf), np.full(count, -1)
    waiting = [(0.0, -1)]
    for k in range(sources.shape[0]):
        distance[sources[k]] = begin[k]
        heapq.heappush(waiting, (begin[k], sources[k]))
    while len(waiting) > 0:
        so_far, vertex = heapq.heappop(waiting)
        if vertex < 0 or so_far > distance[vertex]:
            continue
        for entry in range(offsets[vertex], offsets[vertex + 1]):
            other = ends[entry]
            through = so_far + lengths[entry]
            if through < distance[other]:
                distance[other], following[other] = through, vertex
                heapq.heappush(waiting, (through, other))
    return distance, following


def _across(mesh: Mesh) -> IndexArray:
    """Return the vertex pairs (k, 2) that face each other across an edge and see each other."""
    triangles, points = mesh.triangles, mesh.vertices
    neighbours = neighbours_of(triangles)
    pairs = []
    for k in range(3):
        own = np.flatnonzero(neighbours[:, k] > np.arange(len(triangles)))
        first, second = triangles[own, k], triangles[own, (k + 1) % 3]
        apex = triangles[own, (k + 2) % 3]
        other = triangles[neighbours[own, k]]
        facing = other.sum(axis=1) - first - second
        sees = (_turn(points, apex, first, facing) > 0.0) & (
            _turn(points, apex, second, facing) < 0.0)
        pairs.append(np.column_stack((apex, facing))[sees])
    found: IndexArray = np.concatenate(pairs)
    return found


def _turn(points: FloatArray, start: IndexArray, middle: IndexArray, end: IndexArray,
          ) -> FloatArray:
    """Return on which side of the line from start to middle the end is, > 0 on the left."""
    to_middle, to_end = points[middle] - points[start], points[end] - points[start]
    side: FloatArray = to_middle[:, 0] * to_end[:, 1] - to_middle[:, 1] * to_end[:, 0]
    return side


@njit(cache=True)  # type: ignore[misc]
def _nearest(vertices: FloatArray, distance: FloatArray, corners: IndexArray, x: float, y: float,
             ) -> tuple[float, int]:
    """Return the least way from (x, y) by way of a corner [m], and that corner."""
    best, first = np.inf, corners[0]
    for corner in corners:
        length = distance[corner] + math.hypot(vertices[corner, 0] - x, vertices[corner, 1] - y)
        if length < best:
            best, first = length, corner
    return best, first


@njit(cache=True)  # type: ignore[misc]
def points_within(points: FloatArray, start: FloatArray, reach: float) -> int:
    """Return how many points (k, 2) of a way from `start` (2,) its first `reach` metres take."""
    x, y, length = start[0], start[1], 0.0
    for k in range(points.shape[0]):
        if length >= reach:
            return k
        length += math.hypot(points[k, 0] - x, points[k, 1] - y)
        x, y = points[k, 0], points[k, 1]
    return points.shape[0]


@njit(cache=True)  # type: ignore[misc]
def passes_other_side(first: FloatArray, second: FloatArray, start: FloatArray,
                      goal: FloatArray, holes: FloatArray) -> bool:
    """Tell whether one of the points `holes` (h, 2) lies between two ways from start to goal.

    Parameters
    ----------
    first, second : (k, 2) float [m]
        Ways without their ends.

    Notes
    -----
    Even-odd rule on the loop that goes along the first way and back along the second.
    """
    loop = np.concatenate((np.expand_dims(start, 0), first, np.expand_dims(goal, 0),
                           second[::-1]))
    count = loop.shape[0]
    for hole in range(holes.shape[0]):
        x, y = holes[hole, 0], holes[hole, 1]
        inside = False
        for k in range(count):
            ax, ay = loop[k, 0], loop[k, 1]
            bx, by = loop[(k + 1) % count, 0], loop[(k + 1) % count, 1]
            if (ay > y) != (by > y) and ax + (y - ay) / (by - ay) * (bx - ax) > x:
                inside = not inside
        if inside:
            return True
    return False


class MeshDistance:
    """Distances along a mesh to one goal at a time.

    Parameters
    ----------
    mesh : Mesh

    Notes
    -----
    Dijkstra (1959) on the edges and across them, from corner to corner of two triangles: twelve
    directions, so that a way is at most 4 % longer than it could be where the mesh is regular.
    """

    def __init__(self, mesh: Mesh) -> None:
        self._vertices = mesh.vertices
        sides = np.concatenate([mesh.triangles[:, (k, (k + 1) % 3)] for k in range(3)])
        across = _across(mesh)
        links = np.concatenate((sides, sides[:, ::-1], across, across[:, ::-1]))
        count = len(mesh.vertices)
        keys = np.sort(links[:, 0] * count + links[:, 1])
        keys = keys[np.append(True, keys[1:] != keys[:-1])]
        starts, self._ends = np.divmod(keys, count)
        self._offsets = np.searchsorted(starts, np.arange(count + 1))
        self._lengths = np.hypot(*(mesh.vertices[starts] - mesh.vertices[self._ends]).T)
        self._solved: tuple[bytes, FloatArray, IndexArray] | None = None

    def _solve(self, goal: FloatArray, corners: IndexArray) -> tuple[FloatArray, IndexArray]:
        """Return distances to a goal in the triangle with these corners, kept until it moves."""
        key = goal.tobytes()
        if self._solved is None or self._solved[0] != key:
            begin = np.hypot(*(self._vertices[corners] - goal).T)
            self._solved = (key, *_spread(self._offsets, self._ends, self._lengths, corners,
                                          begin))
        return self._solved[1:]

    def way(self, position: FloatArray, corners: IndexArray, goal: FloatArray,
            goal_corners: IndexArray) -> tuple[float, int]:
        """Return the length of the shortest way [m] and the vertex at which it begins."""
        distance, _ = self._solve(goal, goal_corners)
        length, first = _nearest(self._vertices, distance, corners, float(position[0]),
                                 float(position[1]))
        return float(length), int(first)

    def along(self, first: int, goal: FloatArray, goal_corners: IndexArray) -> FloatArray:
        """Return the vertices (k, 2) [m] from the first on to one of the goal's triangle."""
        _, following = self._solve(goal, goal_corners)
        chain, vertex = [first], int(following[first])
        while vertex >= 0:
            chain.append(vertex)
            vertex = int(following[vertex])
        return self._vertices[chain]
