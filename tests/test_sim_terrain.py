# SPDX-License-Identifier: Apache-2.0
"""Terrains: slip and strength, files, random families, and how bad files are refused."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.slip import CalibratedSlipCurve
from psane_sim.errors import TerrainFileError, UnknownTerrainError
from psane_sim.terrains import heterogeneous
from psane_sim.terrains.catalogue import SHIPPED, load_terrain, read_slip
from psane_sim.terrains.endpoints import connected
from psane_sim.terrains.gaussian_mixture import Gaussian, mixture_slip
from psane_sim.terrains.random_terrain import FAMILIES, SHORTEST_MISSION, random_terrain
from psane_sim.terrains.terrain import STRENGTH_RANGE, Terrain, strength_of_slip

law = settings(deadline=None, derandomize=True, max_examples=40)
HEADER = 'gaussian_x,gaussian_y,std_x,std_y,rotation,amplitude\n'
ENV1_SOFT = [(1.25, 1.25), (1.25, 8.75), (3.75, 3.75), (3.75, 6.25), (6.25, 3.75), (6.25, 8.75),
             (8.75, 1.25), (8.75, 8.75)]


@law
@given(slip=st.lists(st.floats(0.0, 1.0), min_size=2, max_size=2))
def test_strength_never_grows_with_slip_and_stays_in_its_range(slip):
    low, high = strength_of_slip(np.array(sorted(slip)))
    assert high <= low
    assert STRENGTH_RANGE[0] <= high <= low <= STRENGTH_RANGE[1]


@law
@given(slip=st.floats(0.085, 0.9))
def test_strength_inverts_the_calibrated_curve_up_to_slip_nine_tenths(slip):
    assert CalibratedSlipCurve().slip(strength_of_slip(slip)) == pytest.approx(slip)


def test_ground_of_slip_one_has_the_strength_that_holds_a_robot():
    assert strength_of_slip(1.0) == pytest.approx(0.015)
    middle = strength_of_slip(np.array([0.9, 0.95, 1.0]))
    assert middle[1] == pytest.approx(math.sqrt(middle[0] * middle[2]))


@pytest.mark.parametrize('name', [*SHIPPED, 'smooth:4', 'patchy:4', 'corridors:4'])
def test_start_and_goal_of_every_terrain_lie_in_one_safe_part_with_room_for_a_robot(name):
    terrain = load_terrain(name)
    assert connected(terrain.slip, terrain.grid, terrain.start, terrain.goal, 0.35)
    assert np.hypot(*np.subtract(terrain.start, terrain.goal)) >= SHORTEST_MISSION
    assert (terrain.true_slip(np.array([terrain.start, terrain.goal])) < 0.5).all()


@pytest.mark.parametrize('name', SHIPPED)
def test_slip_is_one_at_the_edge_and_falls_by_two_per_metre_or_is_the_terrains_own(name):
    terrain = load_terrain(name)
    along = np.linspace(0.0, 10.0, 41)
    edge = np.column_stack((along, np.zeros(41)))
    np.testing.assert_allclose(terrain.true_slip(edge), 1.0)
    assert (terrain.true_slip(edge + (0.0, 0.2)) >= 0.6 - 1e-9).all()
    assert (terrain.true_slip(edge - (0.0, 0.5)) == 1.0).all()


def test_env1_has_its_eight_soft_places_and_is_firm_at_the_others():
    terrain = load_terrain('env1')
    assert (terrain.true_slip(np.array(ENV1_SOFT)) > 0.95).all()
    firm = [(x, y) for x in (1.25, 3.75, 6.25, 8.75) for y in (1.25, 3.75, 6.25, 8.75)
            if (x, y) not in ENV1_SOFT]
    assert len(firm) == 8
    assert (terrain.true_slip(np.array(firm)) < 0.2).all()
    assert terrain.start == (2.0, 5.0)
    assert terrain.goal == (7.0, 1.5)


def test_the_shipped_env2_is_what_its_script_makes():
    np.testing.assert_array_equal(np.load(SHIPPED['env2'][0]),
                                  heterogeneous.make_slip().astype(np.float32))


def test_env2_is_a_third_safe_with_sharp_sides():
    terrain = load_terrain('env2')
    assert 0.28 <= (terrain.slip <= 0.5).mean() <= 0.38
    gradient = np.hypot(*np.gradient(terrain.slip, terrain.grid.resolution))
    on_a_side = np.abs(terrain.slip - 0.5) < 0.1
    assert np.median(gradient[on_a_side]) == pytest.approx(1.6, abs=0.15)


@pytest.mark.parametrize('family', FAMILIES)
def test_a_seed_always_makes_the_same_terrain_and_another_seed_another(family):
    first, again, other = (random_terrain(family, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.slip, again.slip)
    assert (first.start, first.goal) == (again.start, again.goal)
    assert np.abs(first.slip - other.slip).max() > 0.1


def test_strength_lookup_agrees_with_the_slip_it_was_made_from():
    terrain = load_terrain('env1')
    cells = np.array([[30, 40], [100, 100], [77, 123]])
    points = terrain.grid.point_of(cells)
    np.testing.assert_allclose(terrain.strength(points),
                               strength_of_slip(terrain.slip[cells[:, 0], cells[:, 1]]))


def test_uniform_ground_has_one_strength_everywhere():
    terrain = Terrain.uniform(0.3)
    points = np.random.default_rng(0).uniform(-50.0, 50.0, (20, 2))
    np.testing.assert_allclose(terrain.strength(points), 0.3)
    np.testing.assert_allclose(terrain.true_slip(points), CalibratedSlipCurve().slip(0.3))


def test_a_rotated_gaussian_is_long_along_its_own_axis():
    bump = [Gaussian(0.5, 0.5, 0.2, 0.05, math.radians(30.0), 0.8)]
    axis = 0.1 * np.array([math.cos(math.radians(30.0)), math.sin(math.radians(30.0))])
    along, across = mixture_slip(bump, np.array([[0.5, 0.5] + axis,
                                                 [0.5, 0.5] + axis[::-1] * (-1.0, 1.0)]))
    assert along == pytest.approx(0.8 * math.exp(-0.5 * 0.25))
    assert across == pytest.approx(0.8 * math.exp(-0.5 * 4.0))


def test_an_unknown_name_is_answered_with_the_list():
    with pytest.raises(UnknownTerrainError, match=r"unknown terrain 'mars2'; available: .*env1"):
        load_terrain('mars2')
    with pytest.raises(UnknownTerrainError):
        load_terrain('patchy:minus')
    with pytest.raises(UnknownTerrainError):
        load_terrain('no/such/file.npy')


@pytest.mark.parametrize(('text', 'line', 'column'), [
    ('', 1, 1),
    (HEADER, 1, 1),
    ('gaussian_x,gaussian_y\n', 1, 3),
    (HEADER.replace('std_y', 'std_z'), 1, 4),
    (HEADER + '0.5,0.5,0.1,0.1,0,1\n0.5,0.5,0.1,soft,0,1\n', 3, 4),
    (HEADER + '0.5,0.5,0.1,0.1,0\n', 2, 6),
    (HEADER + '0.5,0.5,0.0,0.1,0,1\n', 2, 3),
    (HEADER + '0.5,nan,0.1,0.1,0,1\n', 2, 2),
])
def test_a_bad_csv_file_is_refused_with_line_and_column(tmp_path, text, line, column):
    path = tmp_path / 'bad.csv'
    path.write_text(text)
    with pytest.raises(TerrainFileError) as error:
        load_terrain(str(path))
    assert (error.value.line, error.value.column) == (line, column)
    assert f'line {line}, column {column}' in str(error.value)


def test_a_good_csv_file_in_another_column_order_makes_a_terrain(tmp_path):
    path = tmp_path / 'mine.csv'
    path.write_text('amplitude,gaussian_x,gaussian_y,std_x,std_y,rotation\n1,0.5,0.5,0.1,0.1,0\n')
    terrain = load_terrain(str(path))
    assert terrain.name == 'mine'
    assert terrain.true_slip(np.array([5.0, 5.0])) == pytest.approx(1.0)
    assert terrain.true_slip(np.array([5.0, 2.0])) < 0.05


def test_a_numpy_file_covers_the_workspace_with_row_as_y(tmp_path):
    path = tmp_path / 'grid.npy'
    np.save(path, np.tile(np.linspace(0.0, 1.0, 11)[:, None], (1, 21)))
    slip = read_slip(path)
    assert slip.shape == (201, 201)
    np.testing.assert_allclose(slip[:, 7], np.linspace(0.0, 1.0, 201), atol=1e-12)


@pytest.mark.parametrize(('values', 'problem'), [
    (np.full((5, 5), 0.2), None),
    (np.zeros(5), 'shape'),
    (np.array([[0.1, 0.2], [0.1, 1.5]]), 'line 2, column 2'),
    (np.array([[0.1, np.nan], [0.1, 0.5]]), 'line 1, column 2'),
    (np.ones((4, 4)), 'no safe ground'),
    (np.array([['a', 'b'], ['c', 'd']]), 'expected numbers'),
])
def test_a_numpy_file_is_accepted_or_refused_with_its_row_and_column(tmp_path, values, problem):
    path = tmp_path / 'grid.npy'
    np.save(path, values)
    if problem is None:
        assert load_terrain(str(path)).true_slip(np.array([5.0, 5.0])) == pytest.approx(0.2)
    else:
        with pytest.raises(TerrainFileError, match=problem):
            load_terrain(str(path))


def test_a_file_that_is_no_numpy_array_is_refused(tmp_path):
    path = tmp_path / 'grid.npy'
    path.write_text('not an array')
    with pytest.raises(TerrainFileError, match='cannot be read as a numpy array'):
        load_terrain(str(path))


def test_a_geotiff_without_rasterio_is_refused_with_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__('sys').modules, 'rasterio', None)
    path = tmp_path / 'map.tif'
    path.write_bytes(b'II*\x00')
    with pytest.raises(TerrainFileError, match='pip install rasterio'):
        load_terrain(str(path))
