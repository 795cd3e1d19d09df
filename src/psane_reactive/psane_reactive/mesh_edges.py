# SPDX-License-Identifier: Apache-2.0
"""Find edges and neighbours in a mesh of triangles: each edge is looked up at its first vertex."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from psane_mapping.grid import IndexArray


class Edges(NamedTuple):
    """The directed edges (k, k + 1) of triangles, sorted by their first vertex.

    Parameters
    ----------
    first : (n + 1,) int
        Where the edges of each of the n vertices begin.
    ends : (3 m,) int
        Second vertex.
    places : (3 m,) int
        Three times the triangle, plus k.
    """

    first: IndexArray
    ends: IndexArray
    places: IndexArray


@njit(cache=True)  # type: ignore[misc]
def _sorted_edges(triangles: IndexArray, count: int
                  ) -> tuple[IndexArray, IndexArray, IndexArray]:
    first = np.zeros(count + 1, np.int64)
    for triangle in range(triangles.shape[0]):
        for k in range(3):
            first[triangles[triangle, k] + 1] += 1
    for vertex in range(count):
        first[vertex + 1] += first[vertex]
    used = first[:count].copy()
    ends = np.empty(3 * triangles.shape[0], np.int64)
    places = np.empty(3 * triangles.shape[0], np.int64)
    for triangle in range(triangles.shape[0]):
        for k in range(3):
            at = used[triangles[triangle, k]]
            used[triangles[triangle, k]] += 1
            ends[at] = triangles[triangle, (k + 1) % 3]
            places[at] = 3 * triangle + k
    return first, ends, places


def edges_of(triangles: IndexArray, count: int) -> Edges:
    """Return the edges of triangles (m, 3) over `count` vertices."""
    return Edges(*_sorted_edges(np.ascontiguousarray(triangles), count))


@njit(cache=True)  # type: ignore[misc]
def _place_of(first: IndexArray, ends: IndexArray, places: IndexArray, start: int,
              end: int) -> int:
    for at in range(first[start], first[start + 1]):
        if ends[at] == end:
            return int(places[at])
    return -1


@njit(cache=True)  # type: ignore[misc]
def places_of(edges: Edges, starts: IndexArray, ends: IndexArray) -> IndexArray:
    """Return the place of each directed edge start-end, (k,) int, -1 where there is none."""
    found = np.empty(starts.size, np.int64)
    for k in range(starts.size):
        found[k] = _place_of(edges.first, edges.ends, edges.places, starts[k], ends[k])
    return found


@njit(cache=True)  # type: ignore[misc]
def neighbours_across(edges: Edges, triangles: IndexArray) -> IndexArray:
    """Return the triangle across edge (k, k + 1) of each triangle, -1 where none is, (m, 3)."""
    found = np.empty(triangles.shape, np.int64)
    for triangle in range(triangles.shape[0]):
        for k in range(3):
            place = _place_of(edges.first, edges.ends, edges.places,
                              triangles[triangle, (k + 1) % 3], triangles[triangle, k])
            found[triangle, k] = place // 3 if place >= 0 else -1
    return found


@njit(cache=True)  # type: ignore[misc]
def flooded(neighbours: IndexArray, seeds: IndexArray) -> NDArray[np.bool_]:
    """Return the triangles (m,) bool that are joined to any of the seeds, those included."""
    reached = np.zeros(neighbours.shape[0], np.bool_)
    stack = np.empty(neighbours.shape[0], np.int64)
    height = 0
    for seed in seeds:
        if not reached[seed]:
            reached[seed] = True
            stack[height] = seed
            height += 1
    while height > 0:
        height -= 1
        triangle = stack[height]
        for k in range(3):
            other = neighbours[triangle, k]
            if other >= 0 and not reached[other]:
                reached[other] = True
                stack[height] = other
                height += 1
    return reached
