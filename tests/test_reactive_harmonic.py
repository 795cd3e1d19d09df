# SPDX-License-Identifier: Apache-2.0
"""The harmonic map is one to one, piecewise affine, and sends border to border."""

import numpy as np
import pytest
import shapely
from test_reactive_mesh import AWKWARD, TWELVE_HOLES

from psane_reactive.clearance import Border
from psane_reactive.embedding import doubled_areas, embed
from psane_reactive.harmonic import HarmonicMap
from psane_reactive.mesh import mesh_region
from psane_reactive.region import smooth_parts
from psane_reactive.sample_regions import random_points, random_snake, star_world

# Central differences over 1e-6 m inside one triangle of an affine map: only rounding is left.
DIFFERENCE = 1e-6
DIFFERENCE_TOLERANCE = 1e-5


def regions():
    random = np.random.default_rng(21)
    parts = [random_snake(random, int(random.integers(10, 250)), random.uniform(0.1, 0.35))
             for _ in range(12)]
    return [smooth_parts(part, 0.002)[0] for part in [*parts, star_world(random, 9), TWELVE_HOLES]]


MAPS = [HarmonicMap(region) for region in regions()]


@pytest.mark.parametrize('mapped', MAPS)
def test_no_triangle_is_turned_over(mapped):
    assert (mapped.embedding.doubled_area > 0.0).all()
    assert mapped.unusable_share == 0.0


@pytest.mark.parametrize('mapped', MAPS)
def test_jacobian_equals_finite_differences_and_has_a_positive_determinant(mapped):
    random = np.random.default_rng(0)
    for point in random_points(random, mapped.polygon, 60):
        jacobian = mapped.jacobian(point)
        assert np.linalg.det(jacobian) > 0.0
        steps = DIFFERENCE * np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])
        around = point + steps
        triangles = {mapped.triangle_at(place) for place in around}
        if len(triangles) > 1:
            continue
        images = mapped.to_model(around)
        differences = np.column_stack((images[0] - images[1], images[2] - images[3]))
        assert np.allclose(differences / (2.0 * DIFFERENCE), jacobian,
                           atol=DIFFERENCE_TOLERANCE * np.abs(jacobian).max() + 1e-9)


@pytest.mark.parametrize('mapped', MAPS)
def test_outer_border_goes_to_the_circle_once_around_counter_clockwise(mapped):
    images = mapped.embedding.model[mapped.mesh.rings[0]]
    assert np.hypot(*images.T) == pytest.approx(1.0)
    angles = np.unwrap(np.arctan2(images[:, 1], images[:, 0]))
    assert (np.diff(angles) > 0.0).all()
    assert angles[-1] - angles[0] < 2.0 * np.pi
    # Points between the vertices map onto the chords between them.
    ring = mapped.mesh.vertices[mapped.mesh.rings[0]]
    middles = 0.5 * (ring + np.roll(ring, -1, axis=0))
    expected = 0.5 * (images + np.roll(images, -1, axis=0))
    assert mapped.to_model(middles) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize('mapped', MAPS)
def test_each_hole_goes_to_a_ring_around_its_hub_that_the_hub_sees_whole(mapped):
    model, vertices = mapped.embedding.model, mapped.mesh.vertices
    for number, ring in enumerate(mapped.mesh.rings[1:]):
        arms = model[ring] - model[len(vertices) + number]
        following = np.roll(arms, -1, axis=0)
        # A hole's border runs clockwise, the region on its left.
        turns = arms[:, 0] * following[:, 1] - arms[:, 1] * following[:, 0]
        assert (turns < 0.0).all()


@pytest.mark.parametrize('mapped', MAPS)
def test_distinct_points_stay_distinct_and_images_stay_in_the_disk(mapped):
    points = random_points(np.random.default_rng(1), mapped.polygon, 400)
    images = mapped.to_model(points)
    assert (np.hypot(*images.T) < 1.0).all()
    gaps = np.hypot(*(images[:, None] - images[None]).transpose(2, 0, 1))
    gaps[np.diag_indices(len(gaps))] = np.inf
    assert gaps.min() > 0.0


@pytest.mark.parametrize('mapped', MAPS)
def test_images_of_triangles_fill_the_disk_without_overlap(mapped):
    embedding = mapped.embedding
    outer = embedding.model[mapped.mesh.rings[0]]
    disk = shapely.Polygon(outer).area
    assert 0.5 * embedding.doubled_area.sum() == pytest.approx(disk, rel=1e-9)


def test_a_hundred_thousand_points_have_an_image_and_a_positive_determinant():
    mapped = max(MAPS, key=lambda m: len(m.mesh.triangles))
    points = random_points(np.random.default_rng(2), mapped.polygon, 100_000)
    triangles = np.array([mapped.triangle_at(point) for point in points])
    # Border vertices are dented inwards by micrometres, so few points next to them lie in none.
    assert (triangles >= 0).mean() > 0.999
    determinant = (mapped.embedding.doubled_area[:len(mapped.mesh.triangles)]
                   / doubled_areas(mapped.mesh.vertices, mapped.mesh.triangles))
    assert (determinant[triangles[triangles >= 0]] > 0.0).all()


@pytest.mark.parametrize('name', AWKWARD)
def test_awkward_regions_are_mapped_one_to_one(name):
    for part in smooth_parts(AWKWARD[name].buffer(0), 0.002):
        assert HarmonicMap(part).unusable_share == 0.0


def test_both_orientations_of_the_rings_are_accepted():
    region = shapely.Polygon([(0, 0), (3, 0), (3, 2), (0, 2)], [[(1, .5), (2, .5), (2, 1.5)]])
    reverse = shapely.Polygon(list(region.exterior.coords)[::-1],
                              [list(region.interiors[0].coords)[::-1]])
    for polygon in (region, reverse):
        mapped = HarmonicMap(polygon)
        assert (mapped.embedding.doubled_area > 0.0).all()


@pytest.mark.parametrize('stiffness', [0.05, 3.0, 100.0])
@pytest.mark.parametrize('is_uniform', [False, True])
def test_any_positive_weights_give_a_one_to_one_map(stiffness, is_uniform):
    mesh = mesh_region(TWELVE_HOLES, 0.1)
    assert (embed(mesh, stiffness, is_uniform).doubled_area > 0.0).all()


@pytest.mark.parametrize('mapped', MAPS)
def test_the_way_leads_through_the_region_to_the_goal(mapped):
    points = random_points(np.random.default_rng(3), mapped.polygon, 40)
    grown = mapped.polygon.buffer(1e-5)
    for start, goal in zip(points[::2], points[1::2], strict=True):
        way = mapped.way(start, goal, 1e9)
        assert way is not None
        assert way.ends_at_goal
        assert way.points[-1] == pytest.approx(goal)
        assert grown.covers(shapely.LineString([start, *way.points]))


def test_the_way_is_cut_at_the_reach_asked_for():
    mapped = HarmonicMap(shapely.box(0.0, 0.0, 8.0, 0.5))
    way = mapped.way(np.array((0.2, 0.25)), np.array((7.8, 0.25)), 1.0)
    assert way is not None
    assert not way.ends_at_goal
    length = shapely.LineString([(0.2, 0.25), *way.points]).length
    assert 1.0 <= length < 1.3


def test_the_way_of_a_convex_region_is_nearly_straight():
    mapped = HarmonicMap(shapely.Point(0.0, 0.0).buffer(2.0))
    start, goal = np.array((-1.5, -0.5)), np.array((1.2, 1.0))
    way = mapped.way(start, goal, 1e9)
    assert way is not None
    line = shapely.LineString((start, goal))
    assert max(line.distance(shapely.Point(point)) for point in way.points) < 0.02


def test_the_way_beside_a_hole_changes_side_with_the_line():
    ring = shapely.Point(0.0, 0.0).buffer(2.0) - shapely.Point(0.0, 0.0).buffer(0.5)
    mapped = HarmonicMap(ring)
    goal = np.array((1.5, 0.0))
    for side in (1.0, -1.0):
        way = mapped.way(np.array((-1.5, 0.3 * side)), goal, 1e9)
        assert way is not None
        middle = way.points[np.argmin(np.abs(way.points[:, 0]))]
        assert side * middle[1] > 0.4


def test_a_place_far_outside_gets_no_way():
    mapped = HarmonicMap(shapely.box(0.0, 0.0, 1.0, 1.0))
    assert mapped.way(np.array((3.0, 0.5)), np.array((0.5, 0.5)), 1.0) is None


def test_the_nearest_inside_point_of_an_outside_one_is_on_the_border():
    mapped = MAPS[0]
    border = Border(mapped.polygon)
    random = np.random.default_rng(5)
    for point in random.uniform(0.0, 10.0, (200, 2)):
        outside = border.outside_distance(point)
        if outside <= 0.0:
            continue
        inside, triangle = mapped.nearest_inside(point)
        assert triangle >= 0
        assert np.hypot(*(inside - point)) == pytest.approx(outside, abs=2e-3)
