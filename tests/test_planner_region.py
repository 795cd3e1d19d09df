# SPDX-License-Identifier: Apache-2.0
"""The region keeps its clearance to uncertified ground, whatever the certified cells look like."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy import ndimage

from psane_mapping.grid import Grid
from psane_planner.component import component_around
from psane_planner.placement import Placement
from psane_planner.region import RegionBuilder

GRID = Grid.over_workspace(0.0, 0.0, 4.0, 3.0, 0.1)
CLEARANCE, TOLERANCE = 0.15, 0.02
SEEDS = st.integers(0, 2**32 - 1)
# Rounding of coordinates through float32 distances [m].
ROUNDING = 1e-4


def snake(draw):
    """Return cells along a random walk, 0.2 to 0.8 m wide, like ground that a robot certified."""
    point, angle = draw.uniform((0.8, 0.8), (3.2, 2.2)), draw.uniform(0, 2 * math.pi)
    cells, away = np.zeros(GRID.shape, bool), GRID.points
    for _ in range(draw.integers(3, 40)):
        radius = draw.uniform(0.1, 0.4)
        cells |= (np.hypot(*(away - point).T) <= radius).reshape(GRID.shape)
        angle += draw.normal(0, 0.6)
        point = np.clip(point + 0.12 * np.array((math.cos(angle), math.sin(angle))),
                        0.3, (3.7, 2.7))
    return cells


def squares(mask):
    """Return the union of the cells of a mask, joined in whole numbers to leave no crack."""
    cells = np.argwhere(mask)
    union = shapely.union_all(shapely.box(cells[:, 1], cells[:, 0], cells[:, 1] + 1,
                                          cells[:, 0] + 1))
    corner = (GRID.origin_x, GRID.origin_y)
    return shapely.transform(union, lambda xy: xy * GRID.resolution + corner)


def region_of(certified, position, within=0.3, **details):
    component = component_around(certified, GRID, position).mask
    builder = RegionBuilder(GRID, details.get('clearance', CLEARANCE),
                            details.get('tolerance', TOLERANCE))
    return builder.build(certified, component, position, within)


def vertices_within(polygon, area):
    """Return the vertices of all rings that lie in an area, as tuples."""
    rings = (polygon.exterior, *polygon.interiors)
    return [vertex for ring in rings for vertex in ring.coords if area.contains(
        shapely.Point(vertex))]


def steerable_point(certified):
    """Return the cell centre that is deepest in certified ground."""
    depth = ndimage.distance_transform_edt(np.pad(certified, 1))[1:-1, 1:-1]
    return GRID.points[np.argmax(depth)]


@settings(max_examples=60, deadline=None)
@example(86136, False)  # here the simplification of a polygon moves its closing vertex too far
@given(SEEDS, st.booleans())
def test_the_region_grown_by_the_clearance_stays_on_certified_ground(seed, is_speckled):
    draw = np.random.default_rng(seed)
    certified = snake(draw)
    if is_speckled:
        certified &= draw.uniform(size=GRID.shape) < 0.985
    if not certified.any():
        return
    region = region_of(certified, steerable_point(certified), within=math.inf)
    if region is None:
        return
    polygon = region.polygon
    assert polygon.is_valid and polygon.geom_type == 'Polygon'
    uncertified = shapely.box(-1, -1, 5, 4).difference(squares(certified))
    assert polygon.distance(uncertified) >= CLEARANCE - ROUNDING
    # Buffers draw arcs by chords from inside, so this side of the test is exact.
    assert squares(certified).buffer(ROUNDING).covers(polygon.buffer(CLEARANCE))


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_ground_deep_enough_is_never_eroded(seed):
    certified = snake(np.random.default_rng(seed))
    region = region_of(certified, steerable_point(certified), within=math.inf)
    uncertified = shapely.box(-1, -1, 5, 4).difference(squares(certified))
    # The contour's level, the simplification, and half the diagonal of the lattice's meshes:
    # where all four corners of a mesh are inside, the mesh is.
    depth = CLEARANCE + 2 * TOLERANCE + 0.05 / math.sqrt(2)
    deep = shapely.get_parts(shapely.box(0, 0, 4, 3).difference(
        uncertified.buffer(depth, quad_segs=32)))
    if region is None:
        assert not any(piece.area > 0 for piece in deep)
        return
    mine = [piece for piece in deep if piece.intersects(region.polygon)]
    assert all(region.polygon.buffer(ROUNDING).covers(piece) for piece in mine)


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_rings_are_oriented_and_cells_lie_in_the_component(seed):
    draw = np.random.default_rng(seed)
    certified = snake(draw) & (draw.uniform(size=GRID.shape) < 0.99)
    position = steerable_point(certified)
    region = region_of(certified, position, within=math.inf)
    if region is None:
        return
    assert shapely.is_ccw(region.polygon.exterior)
    assert not any(shapely.is_ccw(ring) for ring in region.polygon.interiors)
    assert not (region.cells & ~component_around(certified, GRID, position).mask).any()
    assert region.cells.any()


def test_a_ring_of_certified_ground_becomes_a_polygon_with_a_hole():
    certified = np.zeros(GRID.shape, bool)
    certified[5:25, 5:25] = True
    certified[14:16, 14:16] = False
    region = region_of(certified, np.array((0.9, 0.9)))
    assert len(region.polygon.interiors) == 1
    hole = shapely.Polygon(region.polygon.interiors[0])
    # A hole keeps the clearance around two cells: 0.2 m square grown by 0.15 .. 0.19 m.
    assert shapely.box(1.35, 1.35, 1.55, 1.55).buffer(CLEARANCE - 1e-3).within(hole)
    assert hole.within(shapely.box(1.35, 1.35, 1.55, 1.55).buffer(CLEARANCE + 2 * TOLERANCE))


@pytest.mark.parametrize(('width', 'is_steerable'), [(3, False), (4, True)])
def test_a_corridor_is_steerable_exactly_where_it_is_wider_than_twice_the_level(width,
                                                                                is_steerable):
    certified = np.zeros(GRID.shape, bool)
    certified[10:10 + width, 5:35] = True
    region = region_of(certified, np.array((2.0, 1.0 + 0.05 * (width - 1))))
    assert (region is not None) == is_steerable
    if region is not None:
        assert region.cells[:, 10:30].any(axis=0).all()


def test_nothing_is_left_of_a_few_cells_or_of_none():
    certified = np.zeros(GRID.shape, bool)
    assert region_of(certified, np.array((1.0, 1.0))) is None
    certified[10:12, 10:12] = True
    assert region_of(certified, np.array((1.1, 1.1))) is None


def test_a_robot_just_outside_gets_the_nearest_region_and_one_far_off_none():
    certified = np.zeros(GRID.shape, bool)
    certified[5:25, 5:25] = True
    left_edge = 0.45 + CLEARANCE + TOLERANCE
    assert region_of(certified, np.array((left_edge - 0.29, 1.5))) is not None
    assert region_of(certified, np.array((left_edge - 0.31, 1.5))) is None


def test_the_region_of_the_robot_is_taken_where_a_neck_parts_two():
    certified = np.zeros(GRID.shape, bool)
    certified[5:25, 3:15] = certified[5:25, 25:38] = True
    certified[14:16, 15:25] = True
    left = region_of(certified, np.array((0.8, 1.5))).polygon
    right = region_of(certified, np.array((3.2, 1.5))).polygon
    assert left.bounds[2] < 1.5 < right.bounds[0]


def test_unchanged_ground_keeps_the_very_same_region():
    certified = np.zeros(GRID.shape, bool)
    certified[5:25, 5:25] = True
    builder = RegionBuilder(GRID, CLEARANCE, TOLERANCE)
    first = builder.build(certified, certified, np.array((1.0, 1.0)), 0.3)
    again = builder.build(certified.copy(), certified.copy(), np.array((1.5, 1.0)), 0.3)
    assert again is first
    certified[5, 5] = False
    assert builder.build(certified, certified, np.array((1.0, 1.0)), 0.3) is not first


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_a_placed_point_lies_inside_by_the_inset(seed):
    draw = np.random.default_rng(seed)
    certified = snake(draw)
    region = region_of(certified, steerable_point(certified), within=math.inf)
    if region is None or region.polygon.buffer(-0.01).is_empty:
        return
    placement = Placement(0.01)
    for wanted in draw.uniform((0, 0), (4, 3), (10, 2)):
        placed, moved = placement.place(region.polygon, wanted)
        point = shapely.Point(placed)
        assert region.polygon.contains(point)
        assert region.polygon.exterior.distance(point) >= 0.01 - 1e-9
        assert math.isclose(moved, np.hypot(*(placed - wanted)), abs_tol=1e-9)
        if shapely.Point(wanted).within(region.polygon.buffer(-0.0101)):
            assert moved == 0.0


def test_a_sliver_thinner_than_the_inset_still_takes_a_point():
    sliver = shapely.box(0.0, 0.0, 1.0, 0.01)
    placed, _ = Placement(0.01).place(sliver, np.array((5.0, 5.0)))
    assert sliver.covers(shapely.Point(placed))


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_a_change_in_one_place_moves_no_vertex_elsewhere(seed):
    draw = np.random.default_rng(seed)
    certified = snake(draw)
    position = steerable_point(certified)
    before = region_of(certified, position)
    row, column = np.argwhere(certified)[draw.integers(certified.sum())]
    changed = certified.copy()
    changed[row - 1:row + 2, column - 1:column + 2] = draw.uniform() < 0.5
    if before is None or not changed[GRID.index_of(position)[0], GRID.index_of(position)[1]]:
        return
    after = region_of(changed, position)
    if after is None:
        return
    # The change reaches as far as the clearance; simplification as far as the next fixed line.
    place = GRID.point_of(np.array((row, column)))
    reach = 0.15 * math.sqrt(2) + CLEARANCE + TOLERANCE + 0.5 * math.sqrt(2) + 0.1
    far = shapely.box(-1, -1, 5, 4).difference(shapely.Point(*place).buffer(reach))
    old, new = (vertices_within(polygon, far) for polygon in (before.polygon, after.polygon))
    # What the change cuts off, or joins, is ground of its own; where both are, nothing moves.
    shared = before.polygon.intersection(after.polygon).intersection(far)
    for mine, others in ((old, new), (new, old)):
        for vertex in mine:
            if not shared.is_empty and shared.distance(shapely.Point(vertex)) < 1e-9:
                assert any(math.dist(vertex, other) < 1e-6 for other in others)
