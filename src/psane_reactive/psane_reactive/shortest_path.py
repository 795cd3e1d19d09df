# SPDX-License-Identifier: Apache-2.0
"""Exact shortest path inside a polygon with holes: the yardstick for what steering drives."""

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from psane_mapping.grid import FloatArray


class ShortestPath:
    """Visibility graph of a region's inward corners.

    Parameters
    ----------
    polygon : Polygon, map frame [m]
        A valid polygon of a few hundred corners; the graph grows with their square.

    Notes
    -----
    A shortest path bends at inward corners only (Lozano-Perez and Wesley 1979).
    """

    def __init__(self, polygon: shapely.Polygon) -> None:
        self._polygon = polygon
        shapely.prepare(polygon)
        self._corners = _inward_corners(shapely.geometry.polygon.orient(polygon))
        first, second = np.triu_indices(len(self._corners), k=1)
        seen = self._sees(self._corners[first], self._corners[second])
        self._first, self._second = first[seen], second[seen]

    def length(self, start: FloatArray, goal: FloatArray) -> float:
        """Return the length between two points (2,) of the region, infinite without a path [m]."""
        if bool(self._sees(start[None, :], goal[None, :])[0]):
            return float(np.hypot(*(goal - start)))
        nodes = np.concatenate((self._corners, start[None, :], goal[None, :]))
        count = len(self._corners)
        heads, tails = [self._first], [self._second]
        for number, point in ((count, start), (count + 1, goal)):
            seen = np.flatnonzero(self._sees(np.broadcast_to(point, self._corners.shape),
                                             self._corners))
            heads.append(np.full(len(seen), number))
            tails.append(seen)
        head, tail = np.concatenate(heads), np.concatenate(tails)
        lengths = np.hypot(*(nodes[head] - nodes[tail]).T)
        graph = coo_array((lengths, (head, tail)), shape=(count + 2, count + 2)).tocsr()
        return float(dijkstra(graph, directed=False, indices=count)[count + 1])

    def _sees(self, starts: FloatArray, ends: FloatArray) -> np.ndarray[tuple[int],
                                                                        np.dtype[np.bool_]]:
        """Tell which straight lines between points (n, 2) stay inside the region."""
        lines = shapely.linestrings(np.stack((starts, ends), axis=1))
        return np.asarray(shapely.covers(self._polygon, lines))


def _inward_corners(polygon: shapely.Polygon) -> FloatArray:
    """Return the corners of an oriented polygon at which it turns away from itself, (n, 2) [m]."""
    corners = []
    for ring in (polygon.exterior, *polygon.interiors):
        points = np.asarray(ring.coords)[:-1, :2]
        into, out = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
        turn = into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0]
        corners.append(points[turn < 0.0])
    return np.concatenate(corners)
