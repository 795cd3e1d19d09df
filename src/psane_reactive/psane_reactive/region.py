# SPDX-License-Identifier: Apache-2.0
"""The region that the robot may use, made fit for distances and for meshing."""

from typing import Any

import numpy as np
import shapely
import shapely.ops

from psane_mapping.grid import FloatArray
from psane_reactive.clearance import Area
from psane_reactive.errors import RegionError

# Smaller pieces cannot hold the robot's centre for a single control period.
SMALLEST_AREA = 1e-4
# Squares and differences of larger coordinates lose what steering needs [m].
FARTHEST = 1e6


def clean_region(area: Any) -> Area:
    """Return the polygonal part of an area, valid and with counter-clockwise outer rings.

    Parameters
    ----------
    area : Polygon or MultiPolygon, map frame [m]
        May be invalid, may repeat vertices, may hold slivers; rings of either orientation.

    Raises
    ------
    RegionError
        When nothing usable is left.
    """
    if not isinstance(area, (shapely.Polygon, shapely.MultiPolygon)):
        raise RegionError(f'region is a {type(area).__name__}, expected a polygon')
    if not (np.abs(shapely.get_coordinates(area)) <= FARTHEST).all():
        raise RegionError('region holds a coordinate that is not finite or beyond '
                          f'{FARTHEST:g} m')
    valid = area if area.is_valid else shapely.make_valid(area)
    parts = [part for part in _polygons(shapely.force_2d(valid)) if part.area > SMALLEST_AREA]
    if not parts:
        raise RegionError(f'region has an area of {area.area:.3g} m^2, '
                          f'expected a part above {SMALLEST_AREA:g} m^2')
    parts = [shapely.geometry.polygon.orient(part) for part in parts]
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)


def nearest_part(parts: list[shapely.Polygon], point: FloatArray) -> int:
    """Return the index of the polygon that holds a point (2,) [m], or of the nearest one."""
    if len(parts) == 1:
        return 0
    distances = [float(part.distance(shapely.Point(point))) for part in parts]
    return distances.index(min(distances))


def smooth_parts(area: Area, radius: float) -> list[shapely.Polygon]:
    """Return the parts of an area whose corners and necks are no finer than `radius` [m].

    Notes
    -----
    Eroding by twice the radius and growing by once opens pinch points (holes that touch the
    border or each other) and removes cusps and necks narrower than four radii, which no robot
    that keeps a margin can pass. What is left lies about a radius inside the old border, so that
    a simplification by half a radius stays inside as well. When nothing is left the area's own
    parts are returned.
    """
    opened = area.buffer(-2.0 * radius, quad_segs=2).buffer(radius, quad_segs=2)
    simple = opened.simplify(0.5 * radius, preserve_topology=False)
    if not simple.is_valid:
        # Rarely needed, and many times slower.
        simple = opened.simplify(0.5 * radius)
    parts = [part for part in _polygons(simple) if part.area > SMALLEST_AREA and part.is_valid]
    return [_without_small_holes(part, radius * radius) for part in parts or _polygons(area)]


def _without_small_holes(polygon: shapely.Polygon, smallest: float) -> shapely.Polygon:
    """Return a polygon without the holes whose area is below `smallest` [m^2]."""
    holes = [ring for ring in polygon.interiors if shapely.Polygon(ring).area > smallest]
    return shapely.geometry.polygon.orient(shapely.Polygon(polygon.exterior, holes))


def point_inside(area: Area, point: FloatArray, depth: float) -> FloatArray:
    """Return the point itself, or the nearest one `depth` [m] inside where there is room.

    Parameters
    ----------
    point : (2,) float, map frame [m]
    """
    place = shapely.Point(point)
    if area.contains(place) and area.boundary.distance(place) >= depth:
        return point
    for shrunk in (depth, 0.5 * depth, 0.1 * depth):
        inner = area.buffer(-shrunk)
        if not inner.is_empty:
            nearest = shapely.ops.nearest_points(inner, place)[0]
            return np.array((nearest.x, nearest.y))
    anywhere = area.representative_point()
    return np.array((anywhere.x, anywhere.y))


def _polygons(geometry: Any) -> list[shapely.Polygon]:
    """Return the polygons of a geometry of any kind."""
    if isinstance(geometry, shapely.Polygon):
        return [] if geometry.is_empty else [geometry]
    return [part for piece in getattr(geometry, 'geoms', ()) for part in _polygons(piece)]
