# SPDX-License-Identifier: Apache-2.0
"""The purging map is one to one and folds every obstacle away, all of its border included."""

import numpy as np
import pytest
import shapely

from psane_reactive.convex_pieces import pieces_of
from psane_reactive.free_space import local_goal
from psane_reactive.purging import PurgingMap
from psane_reactive.recorded import read_recording
from psane_reactive.region import smooth_parts
from psane_reactive.sample_regions import polygon_world, random_points, random_snake, star_world

# Central differences; the map bends on lengths down to a millimetre near the border.
DIFFERENCE = 1e-8
DIFFERENCE_TOLERANCE = 1e-5
# Share of the sampled points where the differences straddle an edge of a collar [-].
STRADDLING = 0.02
# Images of border points are as near to the model's border as this [m].
BORDER_TOLERANCE = 1e-6


def regions():
    random = np.random.default_rng(31)
    found = [recorded.polygon for recorded in read_recording()[3::35]]
    found += [star_world(random, 9), star_world(random, 3), polygon_world(random, 12, 14)]
    found += [random_snake(random, steps, 0.25) for steps in (20, 120)]
    return [max(smooth_parts(region, 0.002), key=lambda part: part.area) for region in found]


REGIONS = regions()
MAPS = [PurgingMap(region) for region in REGIONS]
ALL_KINDS = MAPS + [PurgingMap(region, pieces='triangles') for region in REGIONS[::3]] + [
    PurgingMap(region, switch='exponential') for region in REGIONS[::3]]


def border_points(polygon, count=400):
    return np.concatenate([
        shapely.get_coordinates(shapely.line_interpolate_point(
            ring, np.linspace(0.0, ring.length, count, endpoint=False)))
        for ring in (polygon.exterior, *polygon.interiors)])


def distance_to_model_border(mapped, images):
    hull = shapely.Polygon(mapped.hull).exterior
    distances = shapely.distance(hull, shapely.points(images))
    for x, y, radius in mapped.disks:
        away = np.abs(np.hypot(images[:, 0] - x, images[:, 1] - y) - radius)
        distances = np.minimum(distances, away)
    return distances


def purged_share(mapped):
    images = mapped.to_model(border_points(mapped.polygon))
    return float((distance_to_model_border(mapped, images) < BORDER_TOLERANCE).mean())


@pytest.mark.parametrize('mapped', ALL_KINDS)
def test_jacobian_equals_finite_differences_and_has_a_positive_determinant(mapped):
    random = np.random.default_rng(0)
    wrong = 0
    points = random_points(random, mapped.polygon, 400, 1e-4)
    for point in points:
        jacobian = mapped.jacobian(point)
        assert np.linalg.det(jacobian) > 0.0
        images = mapped.to_model(point + DIFFERENCE * np.array([(1, 0), (-1, 0), (0, 1), (0, -1)]))
        differences = np.column_stack((images[0] - images[1], images[2] - images[3]))
        size = max(1.0, float(np.abs(jacobian).max()))
        error = np.abs(differences / (2.0 * DIFFERENCE) - jacobian).max() / size
        wrong += bool(error > DIFFERENCE_TOLERANCE)
    assert wrong <= STRADDLING * len(points)


@pytest.mark.parametrize('pieces', ['convex', 'triangles'])
def test_every_border_point_goes_to_the_border_of_the_model(pieces):
    for region in REGIONS:
        assert purged_share(PurgingMap(region, pieces=pieces)) == 1.0


def test_the_border_test_sees_what_the_published_switch_leaves_although_it_is_invertible():
    shares = [purged_share(PurgingMap(region, switch='exponential')) for region in REGIONS]
    assert min(shares) < 0.98
    assert np.mean(shares) > 0.7


@pytest.mark.parametrize('mapped', ALL_KINDS)
def test_distinct_points_stay_distinct_and_inside_the_model(mapped):
    random = np.random.default_rng(1)
    points = random_points(random, mapped.polygon, 300, 1e-3)
    images = mapped.to_model(points)
    assert shapely.covers(shapely.Polygon(mapped.hull).buffer(1e-9), shapely.points(images)).all()
    for x, y, radius in mapped.disks:
        assert (np.hypot(images[:, 0] - x, images[:, 1] - y) > radius).all()
    near = mapped.to_model(points + 1e-6 * random.choice((-1.0, 1.0), points.shape))
    assert (np.hypot(*(near - images).T) > 0.0).all()
    gaps = np.hypot(*(images[:, None] - images[None, :]).transpose(2, 0, 1))
    assert (gaps[np.triu_indices(len(images), 1)] > 0.0).all()


@pytest.mark.parametrize('region', REGIONS[::4])
def test_both_orientations_of_rings_give_the_same_map(region):
    turned = shapely.Polygon(region.exterior.coords[::-1],
                             [hole.coords[::-1] for hole in region.interiors])
    points = random_points(np.random.default_rng(2), region, 50)
    first, second = PurgingMap(region).to_model(points), PurgingMap(turned).to_model(points)
    assert np.abs(first - second).max() < 1e-6


def test_far_from_obstacles_nothing_moves():
    region = star_world(np.random.default_rng(4), 4)
    mapped = PurgingMap(region, width=0.2)
    points = random_points(np.random.default_rng(5), region, 300)
    far = np.array([min(hole.distance(shapely.Point(point)) for hole in region.interiors) > 0.4
                    for point in points])
    assert far.sum() > 50
    assert np.array_equal(mapped.to_model(points[far]), points[far])


def test_each_hole_becomes_a_disk_inside_it():
    region = polygon_world(np.random.default_rng(6), 12, 14)
    mapped = PurgingMap(region)
    assert len(mapped.disks) == 12
    for x, y, radius in mapped.disks:
        disk = shapely.Point(x, y).buffer(radius)
        assert sum(shapely.Polygon(hole).covers(disk) for hole in region.interiors) == 1


@pytest.mark.parametrize('is_merged', [True, False])
@pytest.mark.parametrize('is_pushed_out', [True, False])
def test_pieces_are_convex_cover_the_obstacle_and_hang_on_later_ones(is_merged, is_pushed_out):
    for hole in star_world(np.random.default_rng(7), 8).interiors:
        ring = np.asarray(shapely.geometry.polygon.orient(shapely.Polygon(hole)).exterior.coords)
        pieces = pieces_of(ring[:-1], is_pushed_out, is_merged)
        shapes = [shapely.Polygon(piece.corners) for piece in pieces]
        assert all(shape.exterior.is_ccw for shape in shapes)
        assert all(shape.convex_hull.area == pytest.approx(shape.area) for shape in shapes)
        assert sum(shape.area for shape in shapes) == pytest.approx(shapely.Polygon(hole).area)
        assert [piece.is_root for piece in pieces] == [False] * (len(pieces) - 1) + [True]
        for number, piece in enumerate(pieces[:-1]):
            middle = shapely.Point(0.5 * (piece.corners[0] + piece.corners[-1]))
            assert any(shape.distance(middle) < 1e-9 for shape in shapes[number + 1:])


@pytest.mark.parametrize('seed', range(20))
def test_the_local_goal_is_the_nearest_point_of_the_power_cell(seed):
    random = np.random.default_rng(seed)
    hull = np.array(shapely.MultiPoint(random.uniform(0, 10, (12, 2))).convex_hull
                    .exterior.coords)[::-1][:-1]
    hull = hull if shapely.LinearRing(hull).is_ccw else hull[::-1]
    disks = np.column_stack((random.uniform(2, 8, (5, 2)), random.uniform(0.2, 0.6, 5)))
    inside = random_points(random, shapely.Polygon(hull), 4000)
    free = np.array([(np.hypot(*(point - disks[:, :2]).T) > disks[:, 2]).all()
                     for point in inside])
    here, goal, *others = inside[free]

    def is_in_cell(points, slack):
        own = ((points - here) ** 2).sum(axis=1)
        powers = ((points[:, None] - disks[None, :, :2]) ** 2).sum(axis=2) - disks[:, 2] ** 2
        return (own[:, None] <= powers + slack).all(axis=1)
    found = np.array(local_goal(hull, disks, *here, *goal))
    assert is_in_cell(found[None, :], 1e-9).all()
    assert shapely.Polygon(hull).distance(shapely.Point(found)) < 1e-9
    cell = np.array(others)[is_in_cell(np.array(others), 0.0)]
    assert np.hypot(*(found - goal)) <= np.hypot(*(cell - goal).T).min() + 1e-9


def test_ways_stay_inside_and_nearly_all_end_at_their_goals():
    random = np.random.default_rng(8)
    ended = []
    for mapped in MAPS:
        points = random_points(random, mapped.polygon, 20, 0.005)
        for start, goal in zip(points[::2], points[1::2], strict=True):
            way = mapped.way(start, goal, 1e3)
            assert way is not None
            line = shapely.LineString(np.concatenate((start[None, :], way.points)))
            assert mapped.polygon.buffer(1e-9).covers(line)
            ended.append(way.ends_at_goal)
    # Where the way does not get on beside a corner, the field leads on from there.
    assert np.mean(ended) > 0.9
