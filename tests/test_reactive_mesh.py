# SPDX-License-Identifier: Apache-2.0
"""The mesh covers its region, all of it and nothing else."""

import numpy as np
import pytest
import shapely

from psane_reactive.clearance import Border
from psane_reactive.embedding import doubled_areas
from psane_reactive.errors import RegionError
from psane_reactive.mesh import mesh_region
from psane_reactive.region import clean_region, point_inside, smooth_parts
from psane_reactive.sample_regions import random_points, random_snake, star_world

# Border vertices are moved inwards by a millionth of their edge, so areas differ a little.
AREA_TOLERANCE = 1e-5

SQUARE = shapely.box(0.0, 0.0, 3.0, 3.0)
TWELVE_HOLES = shapely.Polygon(
    SQUARE.exterior, [shapely.box(0.3 + 0.7 * i, 0.3 + 0.9 * j, 0.6 + 0.7 * i, 0.8 + 0.9 * j)
                      .exterior for i in range(4) for j in range(3)])
AWKWARD = {
    'duplicate vertices': shapely.Polygon([(0, 0), (0, 0), (1, 0), (2, 0), (2, 0), (2, 2),
                                           (1, 2), (1, 2), (0, 2)]),
    'crosses itself': shapely.Polygon([(0, 0), (2, 2), (2, 0), (0, 2)]),
    'hole touches the edge': shapely.Polygon(SQUARE.exterior, [[(0, 1.5), (1, 1), (1, 2)]]),
    'holes touch each other': shapely.Polygon(
        SQUARE.exterior, [[(.5, .5), (1.5, 1.5), (.5, 1.5)],
                          [(1.5, 1.5), (2.5, 1.5), (2.5, 2.5)]]),
    'squares meet at a point': shapely.box(0, 0, 1, 1).union(shapely.box(1, 1, 2, 2)),
    'thin corridor': shapely.box(0.0, 0.0, 40.0, 0.2),
    'corridor of 2 cm': shapely.box(0.0, 0.0, 8.0, 0.02),
    'cusp': shapely.Polygon([(0, 0), (5, 0), (0, 0.4)]),
    'spike into it': shapely.Polygon([(0, 0), (3, 0), (3, 3), (1.501, 3), (1.5, .1), (1.499, 3),
                                      (0, 3)]),
    'no hole': SQUARE,
    'twelve holes': TWELVE_HOLES,
    'clockwise': shapely.Polygon(list(SQUARE.exterior.coords)[::-1]),
    'spiral': shapely.LineString([(0.12 * a * np.cos(a), 0.12 * a * np.sin(a))
                                  for a in np.linspace(1, 30, 400)]).buffer(0.15),
}


def regions():
    random = np.random.default_rng(11)
    parts = [random_snake(random, int(random.integers(5, 250)), random.uniform(0.1, 0.35))
             for _ in range(15)]
    parts += [star_world(random, 8) for _ in range(2)]
    for awkward in AWKWARD.values():
        parts += smooth_parts(clean_region(awkward), 0.002)
    return parts


@pytest.mark.parametrize('region', regions())
def test_triangles_cover_the_region_once_and_lie_inside(region):
    part = smooth_parts(region, 0.002)[0]
    mesh = mesh_region(part, 0.1)
    areas = 0.5 * doubled_areas(mesh.vertices, mesh.triangles)
    assert (areas > 0.0).all()
    assert areas.sum() == pytest.approx(part.area, rel=AREA_TOLERANCE, abs=AREA_TOLERANCE)
    grown = part.buffer(1e-6)
    shapely.prepare(grown)
    assert shapely.covers(grown, shapely.polygons(mesh.vertices[mesh.triangles])).all()


@pytest.mark.parametrize('region', regions()[:6])
def test_border_edges_belong_to_one_triangle_and_all_others_to_two(region):
    mesh = mesh_region(smooth_parts(region, 0.002)[0], 0.1)
    directed = {(int(t[k]), int(t[(k + 1) % 3])) for t in mesh.triangles for k in range(3)}
    border = {(int(a), int(b)) for ring in mesh.rings
              for a, b in zip(ring, np.roll(ring, -1), strict=True)}
    assert border <= directed
    assert {(a, b) for a, b in directed if (b, a) not in directed} == border


def test_edges_stay_near_the_wanted_length():
    mesh = mesh_region(shapely.box(0.0, 0.0, 4.0, 3.0), 0.1)
    corners = mesh.vertices[mesh.triangles]
    lengths = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    assert lengths.max() < 0.2
    assert np.median(lengths) == pytest.approx(0.1, rel=0.1)


@pytest.mark.parametrize('name', AWKWARD)
def test_smooth_parts_lie_inside_the_area_they_come_from(name):
    area = clean_region(AWKWARD[name])
    for part in smooth_parts(area, 0.002):
        assert part.is_valid
        assert part.exterior.is_ccw
        assert area.buffer(1e-9).covers(part)


@pytest.mark.parametrize('bad', [
    shapely.Polygon(), shapely.Polygon([(0, 0), (1, 1), (2, 2)]), shapely.box(0, 0, 10, 1e-6),
    shapely.LineString([(0, 0), (1, 1)]), 'a region', None])
def test_what_is_no_area_is_refused_with_a_sentence(bad):
    with pytest.raises(RegionError, match='expected|region is a'):
        clean_region(bad)


def test_coordinates_that_are_not_finite_are_refused():
    with np.errstate(invalid='ignore'):
        bad = shapely.Polygon([(0, 0), (1, 0), (np.inf, 1)])
    with pytest.raises(RegionError, match='not finite'):
        clean_region(bad)


def test_a_point_outside_is_moved_to_the_nearest_place_one_centimetre_inside():
    moved = point_inside(SQUARE, np.array((5.0, 1.0)), 0.01)
    assert moved == pytest.approx((2.99, 1.0))
    kept = np.array((1.0, 1.0))
    assert point_inside(SQUARE, kept, 0.01) is kept


def test_random_points_lie_as_deep_as_asked():
    region = random_snake(np.random.default_rng(0), 60)
    points = random_points(np.random.default_rng(1), region, 50, 0.02)
    assert (Border(region).outside_distances(points) <= -0.02 + 1e-9).all()
