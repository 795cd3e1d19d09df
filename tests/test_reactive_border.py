# SPDX-License-Identifier: Apache-2.0
"""Distances to the border of a region, against shapely."""

import numpy as np
import pytest
import shapely

from psane_reactive.border_index import nearest_by_all
from psane_reactive.clearance import Border
from psane_reactive.sample_regions import random_snake, star_world

# Both sides compute the same distances in double precision over coordinates of about 10 m.
ROUNDING = 1e-9


def regions():
    random = np.random.default_rng(3)
    yield from (random_snake(random, 120) for _ in range(4))
    yield star_world(random, 6)
    yield shapely.MultiPolygon([shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 1)])
    yield shapely.box(0.0, 0.0, 0.25, 0.5)


@pytest.mark.parametrize('region', list(regions()))
def test_signed_distance_agrees_with_shapely(region):
    random = np.random.default_rng(0)
    low_x, low_y, high_x, high_y = region.bounds
    points = random.uniform((low_x - 1, low_y - 1), (high_x + 1, high_y + 1), (3000, 2))
    expected = shapely.distance(region.boundary, shapely.points(points))
    expected[shapely.contains_xy(region, points)] *= -1.0
    assert np.allclose(Border(region).outside_distances(points), expected, atol=ROUNDING)


@pytest.mark.parametrize('region', list(regions()))
def test_buckets_give_what_all_segments_give(region):
    border = Border(region)
    random = np.random.default_rng(1)
    low_x, low_y, high_x, high_y = region.bounds
    for x, y in random.uniform((low_x, low_y), (high_x, high_y), (500, 2)):
        square, _, _, inside = nearest_by_all(border.segments.ends, x, y)
        distance = border.outside_distance((x, y))
        assert (distance < 0.0) == inside
        assert abs(distance) == pytest.approx(square**0.5, abs=ROUNDING)


@pytest.mark.parametrize('region', list(regions()))
def test_distance_of_a_segment_agrees_with_shapely_up_to_the_cap(region):
    border = Border(region)
    random = np.random.default_rng(2)
    low_x, low_y, high_x, high_y = region.bounds
    for _ in range(400):
        start = random.uniform((low_x, low_y), (high_x, high_y))
        end = start + random.normal(0.0, 0.3, 2)
        line = shapely.LineString((start, end))
        expected = min(0.1, float(line.distance(region.boundary)))
        assert border.segment_distance(start, end, 0.1) == pytest.approx(expected, abs=ROUNDING)


@pytest.mark.parametrize('region', list(regions()))
def test_a_ray_ends_where_a_long_line_first_meets_the_border(region):
    border = Border(region)
    random = np.random.default_rng(4)
    low_x, low_y, high_x, high_y = region.bounds
    for _ in range(300):
        point = random.uniform((low_x, low_y), (high_x, high_y))
        heading = random.uniform(-np.pi, np.pi)
        end = point + 2.0 * np.array((np.cos(heading), np.sin(heading)))
        met = shapely.LineString((point, end)).intersection(region.boundary)
        expected = 2.0 if met.is_empty else float(met.distance(shapely.Point(point)))
        assert border.ray(point, heading, 2.0) == pytest.approx(expected, abs=1e-7)


def test_the_nearest_point_lies_on_the_border_at_the_distance():
    region = random_snake(np.random.default_rng(5), 100)
    border = Border(region)
    for point in np.random.default_rng(6).uniform(0.0, 10.0, (300, 2)):
        nearest = border.nearest(point)
        assert region.boundary.distance(shapely.Point(nearest)) < ROUNDING
        assert np.hypot(*(nearest - point)) == pytest.approx(abs(border.outside_distance(point)))
