# SPDX-License-Identifier: Apache-2.0
"""Cut an obstacle into convex pieces whose adjacency is a tree, and say in which order they go."""

import math
from dataclasses import dataclass

import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.errors import MapError

Corners = list[int]
Edge = tuple[int, int]

# A corner of a piece turns by at least this much, or two pieces are not joined there [rad].
_LEAST_TURN = 0.02


@dataclass(frozen=True)
class Piece:
    """A convex piece of an obstacle.

    Parameters
    ----------
    corners : (k, 2) float, map frame [m]
        Counter-clockwise; the edge that leads to the parent runs from the last to the first.
        A root that is not pushed out has no such edge.
    is_root : bool
    """

    corners: FloatArray
    is_root: bool


def pieces_of(ring: FloatArray, is_pushed_out: bool, is_merged: bool) -> list[Piece]:
    """Cut a simple polygon into pieces, every piece after all that hang on it.

    Parameters
    ----------
    ring : (n, 2) float, map frame [m]
        Counter-clockwise, not closed.
    is_pushed_out : bool
        True when the root is to leave through the edge from the last to the first corner.
    is_merged : bool
        False leaves the triangles as they are.

    Notes
    -----
    Constrained Delaunay triangles, joined across a diagonal as long as the union stays convex
    (Hertel & Mehlhorn 1983). The dual graph of a triangulated simple polygon is a tree, and
    joining neighbours keeps it one.
    """
    pieces = _triangles(ring)
    if is_merged:
        pieces = _merged(ring, pieces)
    own: Edge = (len(ring) - 1, 0)
    root = (_owner(pieces, own) if is_pushed_out
            else max(range(len(pieces)), key=lambda k: _area(ring, pieces[k])))
    ordered = _from_the_root(pieces, root, own if is_pushed_out else None)
    return [Piece(ring[_led_by(pieces[k], edge)], is_root=k == root)
            for k, edge in reversed(ordered)]


def _triangles(ring: FloatArray) -> list[Corners]:
    """Triangulate a simple polygon; corner indices counter-clockwise."""
    number = {(x, y): k for k, (x, y) in enumerate(ring.tolist())}
    found = []
    try:
        parts = shapely.constrained_delaunay_triangles(shapely.Polygon(ring))
        for part in shapely.get_parts(parts):
            a, b, c = (number[x, y] for x, y in list(part.exterior.coords)[:3])
            is_turned = not part.exterior.is_ccw
            found.append([a, c, b] if is_turned else [a, b, c])
    except (KeyError, shapely.errors.GEOSException) as error:
        raise MapError('an obstacle cannot be cut into triangles at its corners') from error
    if len(found) != len(ring) - 2:
        raise MapError(f'an obstacle of {len(ring)} corners was cut into {len(found)} '
                       f'triangles, expected {len(ring) - 2}')
    return found


def _merged(ring: FloatArray, triangles: list[Corners]) -> list[Corners]:
    """Join neighbouring pieces while their union stays convex."""
    pieces: dict[int, Corners] = dict(enumerate(triangles))
    owner = {edge: k for k, piece in pieces.items() for edge in _edges(piece)}
    diagonals = [edge for edge in owner if edge[0] < edge[1] and edge[::-1] in owner]
    points = [(x, y) for x, y in ring.tolist()]
    # Long diagonals first: across them the stoutest pieces are joined.
    diagonals.sort(key=lambda edge: -math.dist(points[edge[0]], points[edge[1]]))
    for edge in diagonals:
        first, second = owner[edge], owner[edge[::-1]]
        left, right = _led_by(pieces[first], edge), _led_by(pieces[second], edge[::-1])
        # `left` runs from the end of the edge round to its start.
        union = left + right[1:-1]
        if not (_turns_left(points, union, 0) and _turns_left(points, union, len(left) - 1)):
            continue
        pieces[first] = union
        del pieces[second], owner[edge], owner[edge[::-1]]
        owner.update(dict.fromkeys(_edges(union), first))
    return list(pieces.values())


def _edges(piece: Corners) -> list[Edge]:
    return list(zip(piece, piece[1:] + piece[:1], strict=True))


def _owner(pieces: list[Corners], edge: Edge) -> int:
    """Return the piece that has an edge in this direction."""
    for number, piece in enumerate(pieces):
        if edge in _edges(piece):
            return number
    raise MapError('no piece of an obstacle has its outer edge')


def _led_by(piece: Corners, edge: Edge | None) -> Corners:
    """Return the corners turned so that `edge` runs from the last to the first of them."""
    if edge is None:
        return piece
    place = piece.index(edge[1])
    return piece[place:] + piece[:place]


def _from_the_root(pieces: list[Corners], root: int,
                   own: Edge | None) -> list[tuple[int, Edge | None]]:
    """Return pieces and their edges to the parent, parents first."""
    owner = {edge: k for k, piece in enumerate(pieces) for edge in _edges(piece)}
    ordered: list[tuple[int, Edge | None]] = [(root, own)]
    seen = {root}
    for number, _ in ordered:
        for start, end in _edges(pieces[number]):
            child = owner.get((end, start), -1)
            if child >= 0 and child not in seen:
                seen.add(child)
                ordered.append((child, (end, start)))
    if len(ordered) != len(pieces):
        raise MapError('the pieces of an obstacle do not hang together')
    return ordered


def _area(ring: FloatArray, piece: Corners) -> float:
    return float(shapely.Polygon(ring[piece]).area)


def _turns_left(points: list[tuple[float, float]], piece: Corners, place: int) -> bool:
    """Tell whether a polygon turns left, and clearly so, at one of its corners."""
    here_x, here_y = points[piece[place]]
    before_x, before_y = points[piece[place - 1]]
    after_x, after_y = points[piece[(place + 1) % len(piece)]]
    into_x, into_y = here_x - before_x, here_y - before_y
    out_x, out_y = after_x - here_x, after_y - here_y
    return math.atan2(into_x * out_y - into_y * out_x,
                      into_x * out_x + into_y * out_y) > _LEAST_TURN
