# SPDX-License-Identifier: Apache-2.0
"""Regions like those that certification makes, drawn at random, for tests and benchmarks."""

from collections.abc import Callable

import numpy as np
import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.region import clean_region, nearest_part, smooth_parts


def random_snake(random: np.random.Generator, steps: int = 60, width: float = 0.25,
                 side: float = 10.0) -> shapely.Polygon:
    """Return the union of disks along a wandering walk with branches: a certified-like region.

    Parameters
    ----------
    steps : int
        Disks of the walk; a fifth of them starts a side branch.
    width : float
        Mean radius of the disks [m].
    side : float
        Edge of the square in which the walk stays [m].
    """
    point, heading = random.uniform(0.3 * side, 0.7 * side, 2), random.uniform(-np.pi, np.pi)
    centres = [point]
    for _ in range(steps):
        if random.random() < 0.08:
            point = centres[random.integers(len(centres))]
            heading = random.uniform(-np.pi, np.pi)
        heading += random.normal(0.0, 0.4)
        moved = point + 0.2 * np.array((np.cos(heading), np.sin(heading)))
        if not (np.abs(moved - 0.5 * side) < 0.5 * side - 0.3).all():
            heading += np.pi / 2.0
            continue
        point = moved
        centres.append(point)
    radii = random.uniform(0.5 * width, 1.5 * width, len(centres))
    disks = shapely.buffer(shapely.points(np.array(centres)), radii, quad_segs=4)
    parts = smooth_parts(shapely.union_all(disks).buffer(0.05).buffer(-0.05), 0.005)
    return clean_region(parts[nearest_part(parts, centres[0])])


def star_world(random: np.random.Generator, holes: int = 8, side: float = 10.0,
               gap: float = 0.3) -> shapely.Polygon:
    """Return a square with star-shaped non-convex holes that keep `gap` [m] from each other."""
    return _world(random, holes, side, gap, lambda: (int(random.integers(5, 13)), 1.2))


def polygon_world(random: np.random.Generator, holes: int, corners: int) -> shapely.Polygon:
    """Return a square of 10 m with exactly so many holes of so many corners, star-shaped."""
    region = shapely.Polygon()
    while len(region.interiors) != holes:
        region = _world(random, holes, 10.0, 0.3, lambda: (corners, 0.9))
    return region


def _world(random: np.random.Generator, holes: int, side: float, gap: float,
           shape: Callable[[], tuple[int, float]]) -> shapely.Polygon:
    """Return a square with up to `holes` stars of corners and radius [m] that `shape` says."""
    outer = shapely.box(0.0, 0.0, side, side)
    taken: list[shapely.Polygon] = []
    for _ in range(50 * holes):
        if len(taken) == holes:
            break
        star = _star(random, random.uniform(0.1 * side, 0.9 * side, 2), *shape())
        if (outer.buffer(-gap).contains(star)
                and all(star.distance(other) >= gap for other in taken)):
            taken.append(star)
    return shapely.Polygon(outer.exterior, [star.exterior for star in taken])


def random_points(random: np.random.Generator, region: shapely.Polygon, count: int,
                  depth: float = 0.01) -> FloatArray:
    """Return points (count, 2) [m] that are at least `depth` inside, or anywhere if none are."""
    inner = region.buffer(-depth)
    inner = region if inner.is_empty else inner
    low_x, low_y, high_x, high_y = inner.bounds
    found = np.empty((0, 2))
    while len(found) < count:
        points = random.uniform((low_x, low_y), (high_x, high_y), (50 * count, 2))
        found = np.concatenate((found, points[shapely.contains_xy(inner, points)]))
    return found[:count]


def _star(random: np.random.Generator, centre: FloatArray, count: int,
          largest: float) -> shapely.Polygon:
    """Return a star-shaped polygon with `count` random corners around a centre (2,) [m]."""
    angles = (np.arange(count) + random.uniform(-0.3, 0.3, count)) * 2.0 * np.pi / count
    radii = random.uniform(0.25 * largest, largest, count)
    corners = centre + radii[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    return shapely.Polygon(corners)
