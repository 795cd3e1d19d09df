# SPDX-License-Identifier: Apache-2.0
"""Edges and neighbours of a mesh beside sets of pairs."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from psane_reactive.mesh_edges import edges_of, flooded, neighbours_across, places_of

COUNT = 60


def some_triangles(seed):
    generator = np.random.default_rng(seed)
    points = generator.uniform(size=(COUNT, 2))
    triangles = Delaunay(points).simplices.astype(np.int64)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    along, aside = b - a, c - a
    clockwise = along[:, 0] * aside[:, 1] - along[:, 1] * aside[:, 0] < 0.0
    triangles[clockwise] = triangles[clockwise][:, ::-1]
    return triangles[generator.random(len(triangles)) < 0.8]


def owners(triangles):
    return {(int(triangle[k]), int(triangle[(k + 1) % 3])): (number, k)
            for number, triangle in enumerate(triangles) for k in range(3)}


@pytest.mark.parametrize('seed', range(5))
def test_every_pair_of_vertices_is_found_where_it_is_an_edge(seed):
    triangles = some_triangles(seed)
    starts, ends = (index.ravel() for index in np.indices((COUNT, COUNT)))
    places = places_of(edges_of(triangles, COUNT), starts, ends)
    known = owners(triangles)
    for start, end, place in zip(starts.tolist(), ends.tolist(), places.tolist(), strict=True):
        number, k = known.get((start, end), (0, -1))
        assert place == 3 * number + k


@pytest.mark.parametrize('seed', range(5))
def test_neighbours_share_the_edge_the_other_way_round(seed):
    triangles = some_triangles(seed)
    known = owners(triangles)
    found = neighbours_across(edges_of(triangles, COUNT), triangles)
    for (start, end), (number, k) in known.items():
        assert found[number, k] == known.get((end, start), (-1, 0))[0]


@pytest.mark.parametrize('seed', range(5))
def test_a_flood_reaches_what_neighbours_join_and_no_more(seed):
    triangles = some_triangles(seed)
    neighbours = neighbours_across(edges_of(triangles, COUNT), triangles)
    reached = flooded(neighbours, np.array([0]))
    expected, growing = {0}, True
    while growing:
        wider = expected | {int(other) for one in expected for other in neighbours[one]
                            if other >= 0}
        growing, expected = wider != expected, wider
    assert set(np.flatnonzero(reached).tolist()) == expected


def test_without_seeds_nothing_is_flooded():
    neighbours = np.full((4, 3), -1)
    assert not flooded(neighbours, np.empty(0, dtype=np.int64)).any()
