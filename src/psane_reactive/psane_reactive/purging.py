# SPDX-License-Identifier: Apache-2.0
"""Purging map: obstacles are folded away piece by piece until only disks in a convex hull remain.

Source: Vasilopoulos, Pavlakos, Schmeckpeper, Daniilidis and Koditschek (2020).
"""

import numpy as np
import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.clearance import Border
from psane_reactive.collars import Collar, collar_of, disk_of
from psane_reactive.convex_pieces import Piece, pieces_of
from psane_reactive.errors import MapError
from psane_reactive.model_map import Way
from psane_reactive.purge import Chain, purge_all
from psane_reactive.purged_way import follow

SWITCHES = ('scale_free', 'exponential')
PIECES = ('convex', 'triangles')

# A point outside is taken for one this far inside [m], farther out than the next there is no way.
_DEPTH = 1e-3
# What is nearer to the hull than this counts as on it [m].
_FLAT = 1e-7
_FARTHEST = 0.05
# mu_1 and mu_2 of the published switch, as published.
_DECAY_OUTSIDE, _DECAY_COLLAR = 1.0, 0.01


class PurgingMap:
    """Diffeomorphism of a region onto a convex polygon with a disk for each hole.

    Parameters
    ----------
    polygon : Polygon, map frame [m]
        Without pinch points (see `smooth_parts`).
    switch : str
        'scale_free' or 'exponential', the published one.
    pieces : str
        'convex' or 'triangles': what obstacles are cut into.
    width : float
        How far from an obstacle the map differs from the identity, at most [m].

    Raises
    ------
    MapError
        When an obstacle cannot be cut into pieces or a piece has no room for its collar.

    Notes
    -----
    Obstacles are the hull of the region less the region. Where the region touches its hull its
    border stays what it is; a bay between two such places is pushed out through the hull's edge.
    With the published switch the determinant is positive everywhere and yet some of the border
    is not purged, because the layer in which it happens is thinner than rounding.
    """

    def __init__(self, polygon: shapely.Polygon, switch: str = 'scale_free',
                 pieces: str = 'convex', width: float = 0.5) -> None:
        self.polygon = shapely.geometry.polygon.orient(polygon)
        self.border = Border(self.polygon)
        ring = np.asarray(self.polygon.exterior.coords)[:-1, :2]
        on_hull = _on_hull(ring)
        self.hull: FloatArray = ring[on_hull]
        obstacles = [pieces_of(bay, True, pieces == 'convex') for bay in _bays(ring, on_hull)]
        obstacles += [pieces_of(np.asarray(shapely.Polygon(hole).exterior.coords)[:-1][::-1, :2]
                                if not hole.is_ccw else np.asarray(hole.coords)[:-1, :2],
                                False, pieces == 'convex') for hole in self.polygon.interiors]
        is_bay = [True] * (len(obstacles) - len(self.polygon.interiors))
        is_bay += [False] * len(self.polygon.interiors)
        collars = _collars(obstacles, is_bay, self.hull, width)
        self.chain = _chain(collars, switch, width)
        self.disks: FloatArray = np.array(
            [(*collar.centre, collar.edge[2]) for collar in collars
             if not collar.edge[:2].any()]).reshape(-1, 3)

    @property
    def piece_count(self) -> int:
        """Number of convex pieces that are purged."""
        return len(self.chain.centres)

    def to_model(self, points: FloatArray) -> FloatArray:
        """Map points (n, 2) of the region, map frame [m], to the disk world (n, 2) [m]."""
        images: FloatArray = purge_all(self.chain, np.array(points, dtype=np.float64))[0]
        return images

    def jacobian(self, point: FloatArray) -> FloatArray:
        """Return d(model)/d(point) at a point (2,) of the region, (2, 2) [-]."""
        jacobians: FloatArray = purge_all(self.chain,
                                          np.array(point, dtype=np.float64)[None, :])[1]
        return jacobians[0]

    def way(self, position: FloatArray, goal: FloatArray, reach: float) -> Way | None:
        """Pull the way of the disk world from a position to a goal, (2,) [m], back.

        Returns
        -------
        Its first `reach` metres; None where the law does not get away from the position.
        """
        start, end = self._inside(position), self._inside(goal)
        if max(np.hypot(*(start - position)), np.hypot(*(end - goal))) > _FARTHEST:
            return None
        goal_image = self.to_model(end[None, :])[0]
        points, has_ended = follow(self.chain, self.hull, self.disks, self.border.segments, start,
                                   end, goal_image, reach)
        if len(points) == 0:
            return None
        if has_ended:
            return Way(np.concatenate((points, goal[None, :])), ends_at_goal=True)
        return Way(points, ends_at_goal=False)

    def _inside(self, point: FloatArray) -> FloatArray:
        """Return a point, or where it is outside or on the edge the nearest one inside."""
        outside = self.border.outside_distance(point)
        if outside <= -_DEPTH:
            return np.array(point, dtype=np.float64)
        edge = self.border.nearest(point)
        away = (edge - point) / max(abs(outside), 1e-12)
        for depth in (_DEPTH, 0.1 * _DEPTH):
            moved = edge + (depth if outside > 0.0 else -depth) * away
            if self.border.outside_distance(moved) < 0.0:
                return moved
        return edge


def _on_hull(ring: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the indices of a counter-clockwise ring's corners that lie on its hull, in order."""
    hull = shapely.MultiPoint(ring).convex_hull
    if not isinstance(hull, shapely.Polygon):
        raise MapError('the hull of the region has no area')
    # Corners between those of the hull, on its edges, part bays from each other as well.
    distances = shapely.distance(hull.exterior, shapely.points(ring))
    return np.flatnonzero(distances <= _FLAT)


def _bays(ring: FloatArray, on_hull: np.ndarray[tuple[int], np.dtype[np.int64]],
          ) -> list[FloatArray]:
    """Return what lies between a ring and its hull, counter-clockwise, the mouth last."""
    bays = []
    count = len(ring)
    for first, last in zip(on_hull, np.roll(on_hull, -1), strict=True):
        steps = int((last - first) % count)
        bay = ring[(first + np.arange(steps, -1, -1)) % count]
        mouth = shapely.LineString((bay[0], bay[-1]))
        if steps > 1 and shapely.distance(mouth, shapely.points(bay)).max() > _FLAT:
            bays.append(bay)
    return bays


def _collars(obstacles: list[list[Piece]], is_bay: list[bool], hull: FloatArray,
             width: float) -> list[Collar]:
    """Return the collars of all pieces in the order in which they are purged."""
    pieces = [piece for obstacle in obstacles for piece in obstacle]
    is_pushed_out = np.repeat(is_bay, [len(obstacle) for obstacle in obstacles])
    sides = [np.hstack((piece.corners, np.roll(piece.corners, -1, axis=0))) for piece in pieces]
    hull_sides = np.hstack((hull, np.roll(hull, -1, axis=0)))
    segments = np.ascontiguousarray(np.concatenate((*sides, hull_sides)))
    # The hull belongs to no piece; its last number stays not purged.
    owners = np.concatenate((np.repeat(np.arange(len(pieces)), [len(side) for side in sides]),
                             np.full(len(hull), len(pieces))))
    parents = _parents(pieces)
    is_purged = np.zeros(len(pieces) + 1, dtype=np.bool_)
    collars = []
    for number, piece in enumerate(pieces):
        if piece.is_root and not is_pushed_out[number]:
            collar = disk_of(piece, width, segments, owners, is_purged, number)
        elif piece.is_root:
            mouth = np.concatenate((piece.corners[-1], piece.corners[0]))
            kept = ~(segments == mouth).all(axis=1)
            collar = collar_of(piece, None, width, segments[kept], owners[kept], is_purged,
                               number, number)
        else:
            collar = collar_of(piece, pieces[parents[number]].corners, width, segments, owners,
                               is_purged, number, parents[number])
        # What is left of a disk's piece stays in the way of the others.
        is_purged[number] = bool(collar.edge[:2].any())
        collars.append(collar)
    return collars


def _parents(pieces: list[Piece]) -> list[int]:
    """Return for each piece the one that shares its last edge, -1 for roots."""
    owner = {(*start, *end): number for number, piece in enumerate(pieces)
             for start, end in zip(piece.corners.tolist(),
                                   np.roll(piece.corners, -1, axis=0).tolist(), strict=True)}
    return [-1 if piece.is_root else owner[*piece.corners[0].tolist(),
                                           *piece.corners[-1].tolist()] for piece in pieces]


def _chain(collars: list[Collar], switch: str, width: float) -> Chain:
    """Pack collars into arrays."""
    faces = [faces for collar in collars for faces in (collar.faces, collar.collar_faces)]
    ends = np.cumsum([0, *(len(part) for part in faces)])
    spans = np.column_stack((ends[:-1], ends[1:])).reshape(-1, 2, 2)
    corners = [collar.corners for collar in collars]
    return Chain(
        centres=np.array([collar.centre for collar in collars]).reshape(-1, 2),
        edges=np.array([collar.edge for collar in collars]).reshape(-1, 3),
        boxes=np.array([(*part.min(axis=0), *part.max(axis=0)) for part in corners]
                       ).reshape(-1, 4),
        faces=np.concatenate(faces) if faces else np.empty((0, 3)),
        piece_faces=np.ascontiguousarray(spans[:, 0]),
        collar_faces=np.ascontiguousarray(spans[:, 1]),
        is_exponential=switch == 'exponential', width=width, decay_outside=_DECAY_OUTSIDE,
        decay_collar=_DECAY_COLLAR)
