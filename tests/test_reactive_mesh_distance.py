# SPDX-License-Identifier: Apache-2.0
"""Ways along the mesh: never shorter than the shortest, hardly longer; holes on the short side."""

import numpy as np
import pytest
import shapely

from psane_reactive.harmonic import HarmonicMap
from psane_reactive.mesh import mesh_region
from psane_reactive.mesh_distance import MeshDistance, passes_other_side
from psane_reactive.region import smooth_parts
from psane_reactive.sample_regions import random_points, random_snake, star_world
from psane_reactive.shortest_path import ShortestPath

# Twelve directions cost 4 % at worst; the first and the last triangle add up to an edge each.
LONGEST = 1.04
EDGE = 0.1
# No way on the right side of a hole is so many times longer than the shortest.
WRONG_SIDE = 1.3


def corners_at(mapped, point):
    return mapped.mesh.triangles[mapped.triangle_at(point)]


def test_a_way_along_the_mesh_is_nearly_the_shortest_way():
    random = np.random.default_rng(3)
    for region in (star_world(random, 8), random_snake(random, 120, 0.3)):
        mapped = HarmonicMap(smooth_parts(region, 0.002)[0])
        distance, exact = MeshDistance(mapped.mesh), ShortestPath(mapped.polygon)
        places = random_points(random, mapped.polygon, 40)
        for start, goal in zip(places[:20], places[20:], strict=True):
            length, first = distance.way(start, corners_at(mapped, start), goal,
                                         corners_at(mapped, goal))
            least = exact.length(start, goal)
            assert least - 1e-9 <= length <= LONGEST * least + 4.0 * EDGE
            points = distance.along(first, goal, corners_at(mapped, goal))
            line = shapely.LineString((start, *points, goal))
            assert line.length == pytest.approx(length)
            assert mapped.polygon.buffer(1e-6).covers(line)


def test_links_across_an_edge_stay_within_their_two_triangles():
    mesh = mesh_region(shapely.box(0.0, 0.0, 1.0, 1.0) - shapely.box(0.4, 0.4, 0.6, 0.6), EDGE)
    distance = MeshDistance(mesh)
    starts = np.repeat(np.arange(len(mesh.vertices)), np.diff(distance._offsets))
    lines = shapely.linestrings(mesh.vertices[np.column_stack((starts, distance._ends))])
    assert shapely.covers(shapely.box(0.0, 0.0, 1.0, 1.0).buffer(1e-5)
                          - shapely.box(0.4, 0.4, 0.6, 0.6).buffer(-1e-5), lines).all()


@pytest.mark.parametrize('longest_detour', [1.1, 100.0])
def test_a_hole_is_passed_on_its_short_side_where_detours_are_limited(longest_detour):
    """The line in the disk passes this hole on the far side."""
    region = shapely.box(0.0, 0.0, 6.0, 6.0) - shapely.box(0.5, 1.0, 5.8, 2.0)
    region -= shapely.box(2.0, 3.0, 5.5, 5.9)
    mapped = HarmonicMap(smooth_parts(region, 0.002)[0], longest_detour=longest_detour)
    exact = ShortestPath(mapped.polygon)
    random = np.random.default_rng(4)
    places = random_points(random, mapped.polygon, 120)
    ratios = []
    for start, goal in zip(places[:60], places[60:], strict=True):
        way = mapped.way(start, goal, np.inf)
        length = shapely.LineString((start, *way.points)).length
        ratios.append(length / exact.length(start, goal))
    # Without the limit some are passed on the wrong side, or this test would show nothing.
    assert (max(ratios) > WRONG_SIDE) == (longest_detour == 100.0)


def test_ways_differ_by_side_only_where_a_hole_lies_between_them():
    start, goal = np.array((0.0, 0.0)), np.array((4.0, 0.0))
    above, below = np.array([(1.0, 1.0), (3.0, 1.0)]), np.array([(1.0, -1.0), (3.0, -1.0)])
    for hole, lies_between in (((2.0, 0.1), True), ((2.0, 1.2), False), ((5.0, 0.1), False)):
        holes = np.array([(9.0, 9.0), hole])
        assert passes_other_side(above, below, start, goal, holes) == lies_between
        assert not passes_other_side(above, above + 1e-9, start, goal, holes)


def test_without_holes_the_way_is_the_line_of_the_disk_however_long():
    region = smooth_parts(random_snake(np.random.default_rng(12), 60, 0.3), 0.002)[0]
    region = shapely.Polygon(region.exterior)
    strict, lax = HarmonicMap(region, longest_detour=1.0), HarmonicMap(region, longest_detour=9.0)
    places = random_points(np.random.default_rng(1), region, 20)
    for start, goal in zip(places[:10], places[10:], strict=True):
        first, second = (mapped.way(start, goal, 2.0).points for mapped in (strict, lax))
        assert np.array_equal(first, second)


@pytest.mark.parametrize('reach', [0.5, 1.5])
def test_the_first_stretch_of_a_way_is_no_shorter_than_was_asked_for(reach):
    mapped = HarmonicMap(smooth_parts(star_world(np.random.default_rng(5), 7), 0.002)[0])
    places = random_points(np.random.default_rng(6), mapped.polygon, 60)
    for start, goal in zip(places[:30], places[30:], strict=True):
        way = mapped.way(start, goal, reach)
        line = shapely.LineString((start, *way.points))
        assert way.ends_at_goal or line.length >= reach - 1e-9
        assert not way.ends_at_goal or np.array_equal(way.points[-1], goal)
        assert way.ends_at_goal or line.length <= reach + 2.0 * EDGE
