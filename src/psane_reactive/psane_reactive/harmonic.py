# SPDX-License-Identifier: Apache-2.0
"""Harmonic map of a region onto a disk with a small star-shaped hole for each of its holes."""

import math

import numpy as np
import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.embedding import Embedding, doubled_areas, embed
from psane_reactive.errors import MapError
from psane_reactive.mesh import Mesh, mesh_region
from psane_reactive.mesh_distance import MeshDistance, passes_other_side, points_within
from psane_reactive.model_map import Way
from psane_reactive.trace import (
    barycentric,
    fill_buckets,
    locate,
    neighbours_of,
    owners_of,
    pull_back_line,
)

# Images thinner than this are lost in rounding: coordinates in the disk are known to 1e-16.
_THINNEST = 1e-12
# Triangles of the region below this doubled area have no direction [m^2].
_SMALLEST = 1e-13
# A point farther from the mesh than this lies in a part that smoothing has cut off [m].
_FARTHEST = 0.05


class HarmonicMap:
    """One-to-one, piecewise affine map of a region onto the punctured unit disk.

    Parameters
    ----------
    polygon : Polygon, map frame [m]
        Without pinch points or cusps (see `smooth_parts`).
    edge : float
        Edge of the mesh [m].
    stiffness : float
        Pull of a hole on its border [-].
    longest_detour : float
        How many times the shortest way along the mesh the map's way may be long [-].

    Raises
    ------
    ReactiveError
        When the region cannot be meshed or mapped.
    """

    def __init__(self, polygon: shapely.Polygon, edge: float = 0.1,
                 stiffness: float = 1.0, longest_detour: float = 1.1) -> None:
        self.polygon = polygon
        self._longest_detour = longest_detour
        self.mesh: Mesh = mesh_region(self.polygon, edge)
        self.embedding = self._best_embedding(stiffness)
        self.is_usable = self._usable_triangles()
        self._edge_starts = np.concatenate(self.mesh.rings)
        self._edge_ends = np.concatenate([np.roll(ring, -1) for ring in self.mesh.rings])
        self._edge_triangles = owners_of(self.mesh.triangles, self._edge_starts, self._edge_ends)
        self._neighbours = neighbours_of(self.embedding.triangles)
        self._distance = MeshDistance(self.mesh) if self.polygon.interiors else None
        self._hole_points = np.array([
            shapely.Polygon(hole).representative_point().coords[0]
            for hole in self.polygon.interiors]).reshape(-1, 2)
        self._corner = self.mesh.vertices.min(axis=0) - 1e-6
        extent = self.mesh.vertices.max(axis=0) - self._corner + 1e-6
        self._size = edge
        self._columns, self._rows = (int(n) + 1 for n in extent / edge)
        self._offsets, self._entries = fill_buckets(
            self.mesh.vertices, self.mesh.triangles, self._corner[0], self._corner[1],
            self._size, self._columns, self._rows)

    def _best_embedding(self, stiffness: float) -> Embedding:
        """Use mean-value weights, or equal ones where those turn more triangles over."""
        first = embed(self.mesh, stiffness)
        flipped = int((first.doubled_area <= 0.0).sum())
        if flipped == 0:
            return first
        second = embed(self.mesh, stiffness, is_uniform=True)
        return second if int((second.doubled_area <= 0.0).sum()) < flipped else first

    def _usable_triangles(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Tell which triangles of the mesh have an image that rounding does not swallow."""
        model, triangles = self.embedding.model, self.mesh.triangles
        area = self.embedding.doubled_area[:len(triangles)]
        corners = model[triangles]
        longest = np.max(np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2), axis=1)
        usable = area > _THINNEST * np.maximum(longest, _THINNEST)
        usable &= doubled_areas(self.mesh.vertices, triangles) > _SMALLEST
        if not usable.any():
            raise MapError('no triangle keeps its orientation, expected all to; '
                           'the region is too long and thin for this map')
        return usable

    @property
    def unusable_share(self) -> float:
        """Share of the region's area whose image is lost in rounding, 0 for a perfect map."""
        areas = doubled_areas(self.mesh.vertices, self.mesh.triangles)
        return float(areas[~self.is_usable].sum() / areas.sum())

    def triangle_at(self, point: FloatArray) -> int:
        """Return the index of the mesh triangle that holds a point (2,) [m], -1 if none does."""
        return int(locate(self.mesh.vertices, self.mesh.triangles, self._offsets, self._entries,
                          self._corner, self._size, self._columns, self._rows,
                          float(point[0]), float(point[1])))

    def nearest_inside(self, point: FloatArray) -> tuple[FloatArray, int]:
        """Return the point of the mesh nearest to a point (2,) [m], and its triangle."""
        triangle = self.triangle_at(point)
        if triangle >= 0:
            return point, triangle
        starts = self.mesh.vertices[self._edge_starts]
        along = self.mesh.vertices[self._edge_ends] - starts
        share = np.einsum('ij,ij->i', point - starts, along) / np.einsum('ij,ij->i', along, along)
        places = starts + np.clip(share, 0.0, 1.0)[:, None] * along
        nearest = int(np.argmin(((places - point) ** 2).sum(axis=1)))
        return places[nearest], int(self._edge_triangles[nearest])

    def to_model(self, points: FloatArray) -> FloatArray:
        """Map points (n, 2), map frame [m], to the disk (n, 2) [-]."""
        images = [self._image(*self.nearest_inside(point)) for point in np.asarray(points)]
        return np.array(images).reshape(-1, 2)

    def jacobian(self, point: FloatArray) -> FloatArray:
        """Return d(model)/d(point) at a point (2,) [m], (2, 2) [1/m]."""
        corners = self.mesh.triangles[self.nearest_inside(np.asarray(point))[1]]
        physical, model = self.mesh.vertices[corners], self.embedding.model[corners]
        jacobian: FloatArray = np.linalg.solve(physical[1:] - physical[0], model[1:] - model[0]).T
        return jacobian

    def way(self, position: FloatArray, goal: FloatArray, reach: float) -> Way | None:
        """Pull the straight line between the images of position and goal, (2,) [m], back.

        Returns
        -------
        The first `reach` metres; None where rounding has swallowed the map.

        Notes
        -----
        The line passes some holes on their long side. Where the shortest way along the mesh
        passes one on the other side and is that much shorter, it is taken.
        """
        start_point, start = self.nearest_inside(position)
        goal_point, end = self.nearest_inside(goal)
        if not (self.is_usable[start] and self.is_usable[end]):
            return None
        if max(math.dist(start_point, position), math.dist(goal_point, goal)) > _FARTHEST:
            return None
        points, kept, length = pull_back_line(
            self.mesh.vertices, self.embedding.model, self.embedding.triangles, self._neighbours,
            len(self.mesh.vertices), start, self._inner_image(start_point, start), end,
            self._inner_image(goal_point, end), start_point, reach)
        if kept < 0:
            return None
        other = self._other_side(points, length, start_point, start, goal_point, end)
        if other is not None:
            points, kept = other, points_within(other, start_point, reach)
        if kept < len(points):
            return Way(points[:kept], ends_at_goal=False)
        return Way(np.concatenate((points, goal[None, :])), ends_at_goal=True)

    def _other_side(self, points: FloatArray, length: float, start_point: FloatArray, start: int,
                    goal_point: FloatArray, end: int) -> FloatArray | None:
        """Return the way along the mesh where the line takes the long side of a hole."""
        if self._distance is None:
            return None
        corners, goal_corners = self.mesh.triangles[start], self.mesh.triangles[end]
        least, first = self._distance.way(start_point, corners, goal_point, goal_corners)
        if length <= self._longest_detour * least:
            return None
        along = self._distance.along(first, goal_point, goal_corners)
        is_other = passes_other_side(points, along, start_point, goal_point, self._hole_points)
        return along if is_other else None

    def _image(self, point: FloatArray, triangle: int) -> FloatArray:
        """Map a point (2,) [m] of a known triangle."""
        corners = self.mesh.triangles[triangle]
        shares = barycentric(self.mesh.vertices, corners, float(point[0]), float(point[1]))
        image: FloatArray = np.array(shares) @ self.embedding.model[corners]
        return image

    def _inner_image(self, point: FloatArray, triangle: int) -> FloatArray:
        """Map a point, moved off the sides of its triangle so that a walk can start there."""
        corners = self.mesh.triangles[triangle]
        shares = [max(share, 1e-6) for share in barycentric(
            self.mesh.vertices, corners, float(point[0]), float(point[1]))]
        image: FloatArray = np.array(shares) @ self.embedding.model[corners] / sum(shares)
        return image
