# SPDX-License-Identifier: Apache-2.0
"""Terrains from other programs' files, and terrains on which a task makes no sense."""

import numpy as np
import pytest

from psane_sim.errors import TerrainFileError
from psane_sim.terrains.catalogue import load_terrain, read_slip
from psane_sim.terrains.terrain import Terrain
from psane_sim.terrains.terrain_sense import nonsense_of


@pytest.fixture
def write_geotiff(tmp_path):
    rasterio = pytest.importorskip('rasterio', reason='rasterio is not installed')

    def write(values):
        path = tmp_path / 'map.tif'
        with rasterio.open(path, 'w', driver='GTiff', height=values.shape[0],
                           width=values.shape[1], count=1, dtype='float32') as file:
            file.write(values.astype('float32'), 1)
        return path
    return write


def test_the_first_row_of_a_geotiff_is_the_north(write_geotiff):
    north_soft = np.tile(np.linspace(1.0, 0.0, 50)[:, None], (1, 40))
    slip = read_slip(write_geotiff(north_soft))
    np.testing.assert_allclose(slip[:, 11], np.linspace(0.0, 1.0, 201), atol=1e-6)


def test_a_hole_in_a_geotiff_is_named_by_row_and_column(write_geotiff):
    values = np.full((20, 30), 0.2)
    values[3, 4] = np.nan
    with pytest.raises(TerrainFileError, match='line 4, column 5'):
        load_terrain(str(write_geotiff(values)))


@pytest.fixture
def walled():
    slip = np.full((201, 201), 0.1)
    slip[90:110] = 1.0
    return Terrain.from_slip('walled', slip, (5.0, 2.0), (5.0, 8.0))


def test_a_goal_behind_a_wall_makes_no_sense_and_one_before_it_does(walled):
    assert 'cannot be reached' in nonsense_of(walled, walled.start, walled.goal, 0.5)[0]
    assert nonsense_of(walled, walled.start, (6.0, 2.5), 0.5) == []


def test_a_start_on_unsafe_ground_makes_no_sense_even_without_a_goal(walled):
    assert 'start is unsafe' in nonsense_of(walled, (5.0, 5.0), None, 0.5)[0]
    assert nonsense_of(walled, walled.start, None, 0.5) == []


def test_what_makes_sense_depends_on_the_threshold(walled):
    assert nonsense_of(walled, walled.start, walled.start, 0.05)
