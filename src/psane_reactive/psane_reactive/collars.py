# SPDX-License-Identifier: Apache-2.0
"""Choose centre and collar of each piece of a purging transformation."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, IndexArray
from psane_reactive.convex_pieces import Piece
from psane_reactive.errors import MapError

# Segments that enter a collar by less than this only touch it [m].
_TOUCH = 1e-10
# The collar keeps to this share of the room there is, the centre and the disk likewise [-].
_KEPT = 0.8
_TRIES = 60
_SHRINK = 0.7


class Collar(NamedTuple):
    """Where and around what one piece is purged.

    Parameters
    ----------
    centre : (2,) float, map frame [m]
    edge : (3,) float
        See `purge.Chain.edges`.
    faces, collar_faces : (k, 3) float
        Half-planes of the piece's free sides, and of the collar (see `purge.Chain.faces`).
    corners : (k, 2) float, map frame [m]
        Corners of the collar.
    """

    centre: FloatArray
    edge: FloatArray
    faces: FloatArray
    collar_faces: FloatArray
    corners: FloatArray


@njit(cache=True)  # type: ignore[misc]
def half_planes(corners: FloatArray, count: int) -> FloatArray:
    """Return the half-planes (count, 3) on the left of the first sides of a polygon (k, 2) [m]."""
    faces = np.empty((count, 3))
    for k in range(count):
        following = (k + 1) % corners.shape[0]
        dx, dy = corners[following, 0] - corners[k, 0], corners[following, 1] - corners[k, 1]
        length = math.hypot(dx, dy)
        faces[k, 0], faces[k, 1] = -dy / length, dx / length
        faces[k, 2] = faces[k, 0] * corners[k, 0] + faces[k, 1] * corners[k, 1]
    return faces


@njit(cache=True)  # type: ignore[misc]
def _reach(faces: FloatArray, point: FloatArray, direction: FloatArray) -> float:
    """Return how far a ray from a point stays in all half-planes [m]."""
    least = np.inf
    for k in range(faces.shape[0]):
        rate = faces[k, 0] * direction[0] + faces[k, 1] * direction[1]
        if rate < -1e-12:
            value = faces[k, 0] * point[0] + faces[k, 1] * point[1] - faces[k, 2]
            least = min(least, value / -rate)
    return least


@njit(cache=True)  # type: ignore[misc]
def _meets(faces: FloatArray, segments: FloatArray, alive: NDArray[np.bool_]) -> bool:
    """Tell whether a segment has a stretch inside a convex polygon (Cyrus & Beck 1978)."""
    for i in range(segments.shape[0]):
        if not alive[i]:
            continue
        low, high = 0.0, 1.0
        for k in range(faces.shape[0]):
            a = faces[k, 0] * segments[i, 0] + faces[k, 1] * segments[i, 1] - faces[k, 2] - _TOUCH
            b = faces[k, 0] * segments[i, 2] + faces[k, 1] * segments[i, 3] - faces[k, 2] - _TOUCH
            if a <= 0.0 and b <= 0.0:
                high = -1.0
                break
            if a < 0.0:
                low = max(low, a / (a - b))
            elif b < 0.0:
                high = min(high, a / (a - b))
        if low < high:
            return True
    return False


@njit(cache=True)  # type: ignore[misc]
def _scaled(centre: FloatArray, corners: FloatArray, growth: float,
            fixed: int) -> tuple[FloatArray, FloatArray]:
    """Return corners and faces of a polygon grown from the centre but for `fixed` end corners."""
    count = corners.shape[0]
    grown = np.empty((count + fixed // 2, 2))
    for k in range(count):
        is_end = fixed > 0 and (k == 0 or k == count - 1)
        scale = 1.0 if is_end else 1.0 + growth
        for axis in range(2):
            grown[k, axis] = centre[axis] + scale * (corners[k, axis] - centre[axis])
    if fixed > 0:
        grown[count] = centre
    return grown, half_planes(grown, grown.shape[0])


@njit(cache=True)  # type: ignore[misc]
def _widest(centre: FloatArray, corners: FloatArray, fixed: int, largest: float,
            segments: FloatArray, alive: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Return the widest grown polygon that no segment enters; no corners where there is none."""
    growth = largest
    for _ in range(_TRIES):
        grown, faces = _scaled(centre, corners, growth, fixed)
        if not _meets(faces, segments, alive):
            return _scaled(centre, corners, _KEPT * growth, fixed)
        growth *= _SHRINK
    return np.empty((0, 2)), np.empty((0, 3))


def collar_of(piece: Piece, parent: FloatArray | None, width: float, segments: FloatArray,
              owners: IndexArray, is_purged: NDArray[np.bool_], own: int,
              parent_number: int) -> Collar:
    """Return the collar of a piece with an edge to its parent.

    Parameters
    ----------
    parent : (2-D array of corners) or None
        None where the piece is pushed out of the hull.
    width : float
        How far the collar reaches at most [m].
    segments : (s, 4) float, map frame [m]
        Sides of all pieces and of the hull.
    owners : (s,) int
        Piece of each segment.
    is_purged : (n,) bool
        Pieces that are out of the way; sides of the piece and its parent are so, too.

    Notes
    -----
    The centre lies on the ray from the piece's centre of mass through the middle of the shared
    edge, in the parent, and so near that all free sides of the piece are seen from behind. The
    collar is the hull of the centre, both ends of the edge and the other corners moved away from
    the centre; that is convex, and a ray from the centre leaves piece and collar once each, in
    this order - which makes the transformation one to one.
    """
    corners = piece.corners
    first, last = corners[0], corners[-1]
    middle = 0.5 * (first + last)
    inward = _unit(middle - corners.mean(axis=0))
    faces = half_planes(corners, len(corners) - 1)
    limit = _reach(faces, middle, inward)
    if parent is not None:
        sides = half_planes(parent, len(parent))
        limit = min(limit, _reach(sides, middle + 1e-9 * inward, inward))
    centre = middle + 0.5 * min(limit, 2.0 * width) * inward
    along = _unit(first - last)
    normal = np.array((-along[1], along[0]))
    alive = ~is_purged[owners] & (owners != own) & (owners != parent_number)
    largest = width / max(float(np.hypot(*(corners[1:-1] - centre).T).max()), 1e-9)
    grown, collar_faces = _widest(centre, corners, 2, largest, segments, alive)
    if len(grown) == 0 or limit <= 1e-9:
        raise MapError('there is no room for the collar of an obstacle')
    edge = np.array((*normal, float((first - centre) @ normal)))
    return Collar(centre, edge, faces, collar_faces, grown)


def disk_of(piece: Piece, width: float, segments: FloatArray, owners: IndexArray,
            is_purged: NDArray[np.bool_], own: int) -> Collar:
    """Return the collar of a root that becomes a disk inside itself."""
    corners = piece.corners
    faces = half_planes(corners, len(corners))
    centre = corners.mean(axis=0)
    radius = _KEPT * float((faces[:, :2] @ centre - faces[:, 2]).min())
    alive = ~is_purged[owners] & (owners != own)
    largest = width / float(np.hypot(*(corners - centre).T).max())
    grown, collar_faces = _widest(centre, corners, 0, largest, segments, alive)
    if len(grown) == 0 or radius <= 0.0:
        raise MapError('there is no room for the collar of an obstacle')
    return Collar(centre, np.array((0.0, 0.0, radius)), faces, collar_faces, grown)


def _unit(vector: FloatArray) -> FloatArray:
    return vector / max(float(np.hypot(*vector)), 1e-12)
