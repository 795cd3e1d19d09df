# SPDX-License-Identifier: Apache-2.0
"""Certified cells to the polygon in which the robot may be steered."""

import math
from typing import NamedTuple, cast

import contourpy
import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon
from shapely.geometry.polygon import orient

from psane_mapping.grid import FloatArray, Grid
from psane_planner.discs import Mask

# What rounding to float32 in the distance transform may add [m].
_ROUNDING = 1e-4
# Distance of the lines on which the contour's vertices are kept [m].
_ANCHOR_SPACING = 0.5


class Region(NamedTuple):
    """Where the robot may be steered.

    Parameters
    ----------
    polygon : shapely Polygon, map frame [m]
        Outer ring counter-clockwise, holes clockwise.
    cells : (rows, columns) bool
        Cells that the polygon reaches into, to measure ways along it.
    """

    polygon: Polygon
    cells: Mask


class _Lattice(NamedTuple):
    """Points on the corners, edges and centres of a window of cells."""

    distance: NDArray[np.float32]
    spacing: float
    origin_x: float
    origin_y: float
    subdivision: int
    rows: slice
    columns: slice


class _Drawing(NamedTuple):
    """What was drawn for one set of cells; regions are finished when first asked for."""

    certified: Mask
    component: Mask
    lattice: _Lattice
    outlines: list[Polygon]
    regions: dict[int, Region]


class RegionBuilder:
    """Erode certified ground by a clearance and draw its edge below the size of a cell.

    Notes
    -----
    On a lattice that holds the corners of the cells, the point of a square nearest to a lattice
    point is a lattice point too, so one exact distance transform (Felzenszwalb & Huttenlocher)
    gives the distance to the uncertified squares themselves, not to their centres.

    The contour is drawn at clearance + tolerance. Distance to a set is the least of cones, and at
    distance r a cone bends by 1 / r at most: interpolation between lattice points s apart
    overestimates it by at most s^2 / (8 r), and the straight piece of contour across a mesh, at
    most sqrt(2) s long, by s^2 / (4 r) more. The rest of the tolerance goes to the
    simplification (Douglas & Peucker 1973), which moves the edge by no more than that; as
    distance changes no faster than position, what comes out keeps the clearance everywhere.
    """

    def __init__(self, grid: Grid, clearance: float, tolerance: float) -> None:
        """Make the lattice so fine that interpolation takes at most half of the tolerance."""
        self._grid = grid
        self._level = clearance + tolerance
        finest = math.sqrt(2.0 * clearance * tolerance)
        self._subdivision = max(2, math.ceil(grid.resolution / finest))
        spacing = grid.resolution / self._subdivision
        interpolation = 3.0 * spacing**2 / (8.0 * clearance)
        self._simplification = max(0.0, tolerance - interpolation - _ROUNDING)
        self._drawn: _Drawing | None = None

    def build(self, certified: Mask, component: Mask, position: FloatArray,
              nearest_within: float) -> Region | None:
        """Return the region that holds the robot, or the nearest one.

        Parameters
        ----------
        certified, component : (rows, columns) bool
            All certified cells, and those joined to the robot.
        position : (2,) float, map frame [m]
        nearest_within : float [m]
            How far off the region may lie.

        Returns
        -------
        Region or None
            None where erosion leaves nothing within that distance.
        """
        if not component.any():
            return None
        drawn = self._drawing_of(certified, component)
        if not drawn.outlines:
            return None
        here = shapely.Point(position[0], position[1])
        gaps = [outline.distance(here) for outline in drawn.outlines]
        nearest = int(np.argmin(gaps))
        if gaps[nearest] > nearest_within:
            return None
        if nearest not in drawn.regions:
            outline = drawn.outlines[nearest]
            drawn.regions[nearest] = Region(self._simplify(outline),
                                            self._cells_of(drawn.lattice, outline))
        return drawn.regions[nearest]

    def _drawing_of(self, certified: Mask, component: Mask) -> _Drawing:
        """Return the outlines, those of the last call where the cells are the same."""
        last = self._drawn
        if last is None or not (_is_same(last.certified, certified)
                                and _is_same(last.component, component)):
            lattice = self._measure(certified, component)
            outlines = [piece for piece in self._outline(lattice)
                        if self._is_within(component, piece)]
            shapely.prepare(outlines)
            last = _Drawing(_kept(certified), _kept(component), lattice, outlines, {})
            self._drawn = last
        return last

    def _measure(self, certified: Mask, component: Mask) -> _Lattice:
        grid, fine = self._grid, self._subdivision
        margin = math.ceil(self._level / grid.resolution) + 1
        rows = _window(np.asarray(component.any(axis=1)), margin)
        columns = _window(np.asarray(component.any(axis=0)), margin)
        blocked = np.pad(~certified[rows, columns], 1, constant_values=True)
        free = np.ones((blocked.shape[0] * fine + 1, blocked.shape[1] * fine + 1), np.uint8)
        for i in range(fine + 1):
            for j in range(fine + 1):
                free[i:i + fine * blocked.shape[0]:fine,
                     j:j + fine * blocked.shape[1]:fine][blocked] = 0
        spacing = grid.resolution / fine
        distance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        return _Lattice(np.asarray(distance * np.float32(spacing), dtype=np.float32), spacing,
                        grid.origin_x + (columns.start - 1) * grid.resolution,
                        grid.origin_y + (rows.start - 1) * grid.resolution, fine, rows, columns)

    def _outline(self, lattice: _Lattice) -> list[Polygon]:
        rows, columns = shape = lattice.distance.shape
        # Left to itself, contourpy would fill two arrays with these.
        tracer = contourpy.contour_generator(
            np.broadcast_to(np.arange(columns, dtype=np.float64), shape),
            np.broadcast_to(np.arange(rows, dtype=np.float64)[:, None], shape),
            lattice.distance, fill_type=contourpy.FillType.OuterOffset)
        filled = tracer.filled(self._level, float('inf'))
        points, offsets = cast('tuple[list[FloatArray], list[NDArray[np.uint32]]]', filled)
        pieces = []
        for path, ends in zip(points, offsets, strict=True):
            path = path * lattice.spacing + (lattice.origin_x, lattice.origin_y)
            rings = [path[a:b] for a, b in zip(ends[:-1], ends[1:], strict=True)]
            piece = Polygon(rings[0], rings[1:]) if len(rings[0]) > 3 else Polygon()
            if piece.area > 0.0:
                pieces.append(piece)
        return pieces

    def _is_within(self, component: Mask, piece: Polygon) -> bool:
        row, column = self._grid.index_of(np.asarray(piece.exterior.coords[0]))
        return bool(component[row, column])

    def _simplify(self, piece: Polygon) -> Polygon:
        """Drop vertices; where that makes rings cross, in the slow way that never does."""
        simple = _without_needless_vertices(piece, self._simplification)
        if not _is_like(simple, piece):
            sound = _largest(piece)
            # As a polygon's, the closing vertex may go too, after which twice the tolerance
            # is what an edge may have moved by.
            simple = sound.simplify(self._simplification / 2.0, preserve_topology=True)
            simple = simple if _is_like(simple, sound) else sound
        return orient(simple, sign=1.0)

    def _cells_of(self, lattice: _Lattice, piece: Polygon) -> Mask:
        """Return the cells with a lattice point inside the outline."""
        painted = np.zeros(lattice.distance.shape, np.uint8)
        rings = [np.asarray(ring.coords) for ring in (piece.exterior, *piece.interiors)]
        scale = 2.0**8 / lattice.spacing
        corner = (lattice.origin_x, lattice.origin_y)
        pixels = [np.round((ring - corner) * scale).astype(np.int32) for ring in rings]
        cv2.fillPoly(painted, pixels, 1, shift=8)
        inside = (painted > 0) & (lattice.distance >= self._level)
        fine = lattice.subdivision
        shape = (lattice.rows.stop - lattice.rows.start, lattice.columns.stop
                 - lattice.columns.start)
        window = np.zeros(shape, dtype=np.bool_)
        for i in range(fine, 2 * fine + 1):
            for j in range(fine, 2 * fine + 1):
                window |= inside[i:i + fine * shape[0]:fine, j:j + fine * shape[1]:fine]
        cells = np.zeros(self._grid.shape, dtype=np.bool_)
        cells[lattice.rows, lattice.columns] = window
        return cells


def _kept(mask: Mask) -> Mask:
    """Return a mask that nobody changes: itself where it is frozen."""
    return mask.copy() if mask.flags.writeable else mask


def _is_same(one: Mask, other: Mask) -> bool:
    return one is other or bool(np.array_equal(one, other))


def _window(used: NDArray[np.bool_], margin: int) -> slice:
    indices = np.flatnonzero(used)
    return slice(max(0, int(indices[0]) - margin), min(used.size, int(indices[-1]) + margin + 1))


def _without_needless_vertices(piece: Polygon, tolerance: float) -> Polygon:
    """Simplify each ring in stretches between fixed lines."""
    outer, *holes = (_simplified(np.asarray(ring.coords), tolerance)
                     for ring in (piece.exterior, *piece.interiors))
    is_flat = any(len(ring) < 4 for ring in (outer, *holes))
    return Polygon() if is_flat else Polygon(outer, holes)


def _simplified(ring: FloatArray, tolerance: float) -> FloatArray:
    """Drop vertices of a closed ring (n, 2), stretch by stretch.

    A vertex of the contour lies on a line of the lattice. Those on every `_ANCHOR_SPACING` are
    kept, and what lies between two of them is simplified for itself, so that a change in one place
    moves no vertex in another.
    """
    lines_away = ring / _ANCHOR_SPACING
    on_line = np.any(np.abs(lines_away - np.round(lines_away)) < 1e-6, axis=1)
    anchors = np.flatnonzero(np.asarray(on_line)[:-1])
    if anchors.size:
        # Begin at an anchor: the contour's own beginning would be a vertex like no other.
        ring = np.vstack((ring[anchors[0]:-1], ring[:anchors[0] + 1]))
        anchors = np.append(anchors - anchors[0], len(ring) - 1)
    else:
        anchors = np.array((0, len(ring) - 1))
    stretches = [ring[a:b + 1] for a, b in zip(anchors[:-1], anchors[1:], strict=True)]
    sizes = [len(stretch) for stretch in stretches]
    lines = shapely.linestrings(np.vstack(stretches),
                                indices=np.repeat(np.arange(len(sizes)), sizes))
    simple = shapely.simplify(lines, tolerance, preserve_topology=False)
    points, of_line = shapely.get_coordinates(simple, return_index=True)
    is_end = np.append(of_line[1:] != of_line[:-1], False)
    return np.asarray(points[~is_end])


def _is_like(shape: Polygon, original: Polygon) -> bool:
    """Tell whether `shape` is a sound polygon with as many holes as its original."""
    return (isinstance(shape, Polygon) and not shape.is_empty
            and len(shape.interiors) == len(original.interiors) and bool(shape.is_valid))


def _largest(shape: Polygon) -> Polygon:
    """Return the largest sound polygon in a shape whose rings may touch or cross."""
    parts = shapely.get_parts(shapely.make_valid(shape))
    return max((part for part in parts if isinstance(part, Polygon)), key=lambda part: part.area)
