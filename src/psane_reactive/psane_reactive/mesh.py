# SPDX-License-Identifier: Apache-2.0
"""Conforming triangle mesh of a polygon with holes."""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from psane_mapping.grid import FloatArray, IndexArray
from psane_reactive.clearance import Border
from psane_reactive.errors import MeshError
from psane_reactive.mesh_edges import edges_of, flooded, neighbours_across, places_of

# Border vertices between two corners are moved inwards by this share of their edge, so that a
# straight border never makes a triangle without area.
_DENT = 1e-6
_ROUNDS = 14
_LARGEST_LATTICE = 1000000


@dataclass(frozen=True)
class Mesh:
    """Triangles that cover a region, no edge of which crosses its border.

    Parameters
    ----------
    vertices : (n, 2) float, map frame [m]
    triangles : (m, 3) int
        Vertex indices, counter-clockwise.
    rings : tuple of (k,) int
        Border vertices in order with the region on their left: outer ring first, then holes.
    """

    vertices: FloatArray
    triangles: IndexArray
    rings: tuple[IndexArray, ...]

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for array in (self.vertices, self.triangles, *self.rings):
            array.setflags(write=False)


def mesh_region(polygon: shapely.Polygon, edge: float) -> Mesh:
    """Triangulate a polygon with edges of about `edge` [m].

    Raises
    ------
    MeshError
        When border edges stay missing after all rounds of halving.

    Notes
    -----
    Delaunay triangulation of border and interior points; border edges that are missing are halved
    until all are present (Ruppert 1995, without its angle bound).
    """
    rings = [_ring_points(ring, edge, is_hole)
             for ring, is_hole in [(polygon.exterior, False),
                                   *((hole, True) for hole in polygon.interiors)]]
    inner = _interior_points(polygon, edge)
    missing = 0
    for _ in range(_ROUNDS):
        border = np.concatenate(rings)
        points = np.concatenate((border, inner))
        triangles = _delaunay(points)
        starts, ends = _ring_edges(rings)
        is_missing = ~_has_edges(triangles, starts, ends, len(points))
        missing = int(is_missing.sum())
        if missing == 0:
            return _inside_part(points, triangles, rings, starts, ends)
        rings = _halve(rings, is_missing)
    raise MeshError(missing, len(points))


def _ring_points(ring: shapely.LinearRing, edge: float, is_hole: bool) -> FloatArray:
    """Return a ring's points, edges cut to at most `edge`, with the region on the left."""
    corners = np.asarray(ring.coords)[:-1, :2]
    if bool(ring.is_ccw) == is_hole:
        corners = corners[::-1]
    ends = np.roll(corners, -1, axis=0)
    counts = np.maximum(1, np.ceil(np.hypot(*(ends - corners).T) / edge)).astype(int)
    steps = (ends - corners) / counts[:, None]
    of_edge = np.repeat(np.arange(len(corners)), counts)
    along = np.arange(len(of_edge)) - np.repeat(np.cumsum(counts) - counts, counts)
    points: FloatArray = corners[of_edge] + along[:, None] * steps[of_edge]
    between = along > 0
    aside = np.column_stack((-steps[:, 1], steps[:, 0]))[of_edge[between]]
    points[between] += _DENT * aside
    return points


def _interior_points(polygon: shapely.Polygon, edge: float) -> FloatArray:
    """Return points of a hexagonal lattice that keep away from the border, (n, 2) [m]."""
    low_x, low_y, high_x, high_y = polygon.bounds
    edge = max(edge, float(np.sqrt((high_x - low_x) * (high_y - low_y) / _LARGEST_LATTICE)))
    x = np.arange(low_x, high_x + edge, edge)
    y = np.arange(low_y, high_y + edge, edge * 0.75**0.5)
    lattice_x, lattice_y = np.meshgrid(x, y)
    lattice_x[1::2] += edge / 2.0
    points = np.column_stack((lattice_x.ravel(), lattice_y.ravel()))
    # A cheap look at where the polygon is comes before the exact distance.
    points = points[shapely.contains_xy(polygon, points)]
    if len(points) == 0:
        return points
    distances = Border(polygon).outside_distances(points)
    kept: FloatArray = points[distances < -0.55 * edge]
    return kept


def _delaunay(points: FloatArray) -> IndexArray:
    """Return the Delaunay triangles of points, counter-clockwise."""
    try:
        triangles = Delaunay(points - points.mean(axis=0)).simplices.astype(np.int64)
    except (QhullError, ValueError) as error:
        raise MeshError(len(points), len(points)) from error
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[area < 0.0] = triangles[area < 0.0][:, ::-1]
    return triangles


def _ring_edges(rings: list[FloatArray]) -> tuple[IndexArray, IndexArray]:
    """Return start and end index of each border edge, rings numbered one after the other."""
    starts, ends = [], []
    first = 0
    for ring in rings:
        index = first + np.arange(len(ring))
        starts.append(index)
        ends.append(np.roll(index, -1))
        first += len(ring)
    return np.concatenate(starts), np.concatenate(ends)


def _has_edges(triangles: IndexArray, starts: IndexArray, ends: IndexArray,
               count: int) -> NDArray[np.bool_]:
    """Tell which of the edges start-end are edges of a triangle, in either direction."""
    edges = edges_of(triangles, count)
    return np.asarray((places_of(edges, starts, ends) >= 0)
                      | (places_of(edges, ends, starts) >= 0))


def _halve(rings: list[FloatArray], is_missing: NDArray[np.bool_]) -> list[FloatArray]:
    """Put a vertex into the middle of each missing border edge."""
    halved = []
    first = 0
    for ring in rings:
        chosen = np.flatnonzero(is_missing[first:first + len(ring)])
        step = np.roll(ring, -1, axis=0)[chosen] - ring[chosen]
        middle = ring[chosen] + 0.5 * step + _DENT * np.column_stack((-step[:, 1], step[:, 0]))
        halved.append(np.insert(ring, chosen + 1, middle, axis=0))
        first += len(ring)
    return halved


def _inside_part(points: FloatArray, triangles: IndexArray, rings: list[FloatArray],
                 starts: IndexArray, ends: IndexArray) -> Mesh:
    """Keep the triangles on the left of the border, found by flooding up to border edges."""
    count = len(points)
    edges = edges_of(triangles, count)
    neighbours = neighbours_across(edges, triangles)
    on_left, on_right = places_of(edges, starts, ends), places_of(edges, ends, starts)
    on_left = on_left[on_left >= 0]
    neighbours.ravel()[on_left] = -1
    neighbours.ravel()[on_right[on_right >= 0]] = -1
    inside = flooded(neighbours, on_left // 3)
    bounds = np.cumsum([0, *(len(ring) for ring in rings)])
    indices = tuple(np.arange(low, high)
                    for low, high in zip(bounds[:-1], bounds[1:], strict=True))
    used = np.zeros(count, dtype=bool)
    used[triangles[inside].ravel()] = True
    if not used.all():
        raise MeshError(int((~used).sum()), count)
    return Mesh(points, triangles[inside], indices)
