# SPDX-License-Identifier: Apache-2.0
"""Prior maps: where they come from, and that they move the mean and nothing else."""

import math

import numpy as np
import pytest
from felt_stances import stance
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.encoding import encode_log_strength, encode_slip_mean
from psane_mapping.errors import MapFileError, ParameterError, ShapeError
from psane_mapping.grid import Grid
from psane_mapping.map_keeper import MapKeeper
from psane_mapping.mapper import TerrainMapper
from psane_mapping.prior_file import prior_of_cells, read_prior
from psane_mapping.prior_map import PriorMap
from psane_mapping.slip import CalibratedSlipCurve

CURVE = CalibratedSlipCurve()
SMALL = {'min_x': 0.0, 'min_y': 0.0, 'max_x': 2.0, 'max_y': 2.0}
GRID = Grid.over_workspace(0.0, 0.0, 2.0, 2.0, 0.1)
ENDS = (0.005, 20.0)


def sloping(grid):
    return np.tile(0.2 + 0.2 * grid.x, (grid.rows, 1))


def test_slip_and_strength_of_a_prior_fit_each_other():
    slip = sloping(GRID)
    of_slip = PriorMap.of_slip(GRID, slip, CURVE)
    of_strength = PriorMap.of_strength(GRID, CURVE.inverse(slip), CURVE)
    assert np.allclose(of_slip.slip, of_strength.slip)
    assert np.allclose(of_slip.log_strength, of_strength.log_strength)


@settings(max_examples=50)
@given(st.lists(st.one_of(st.floats(), st.just(math.nan)), min_size=6, max_size=6))
def test_any_numbers_make_a_prior_that_is_finite_where_it_is_known(numbers):
    grid = Grid(origin_x=0.0, origin_y=0.0, resolution=1.0, rows=2, columns=3)
    for make in (PriorMap.of_slip, PriorMap.of_strength):
        prior = make(grid, np.array(numbers).reshape(2, 3), CURVE)
        for values in (prior.mean_of_slip(0.3)(GRID), prior.mean_of_log_strength(-1.0)(GRID)):
            assert np.isfinite(values).all() and values.shape == GRID.shape


def test_a_prior_of_another_grid_is_interpolated_and_the_constant_holds_beyond():
    coarse = Grid(origin_x=0.0, origin_y=0.0, resolution=0.5, rows=2, columns=3)
    mean = PriorMap.of_slip(coarse, np.array([[0.2, 0.4, 0.6]] * 2), CURVE).mean_of_slip(0.9)
    values = mean(Grid(origin_x=-0.5, origin_y=0.0, resolution=0.25, rows=4, columns=10))
    # Cell centres at -0.375, -0.125, 0.125 ... 1.875; those of the prior at 0.25, 0.75, 1.25.
    assert np.allclose(values[1], [0.9, 0.9, 0.2, 0.25, 0.35, 0.45, 0.55, 0.6, 0.9, 0.9])


def test_unknown_cells_of_a_prior_show_the_constant():
    slip = np.full(GRID.shape, 0.4)
    slip[:, 10:] = np.nan
    mean = PriorMap.of_slip(GRID, slip, CURVE).mean_of_slip(0.1)(GRID)
    assert np.allclose(mean[:, :10], 0.4) and np.allclose(mean[:, 11:], 0.1)


def test_a_prior_map_certifies_nothing_that_was_not_felt():
    config = MappingConfiguration(**SMALL)
    firm = PriorMap.of_slip(GRID, np.zeros(GRID.shape), CURVE)
    maps = TerrainMapper(config, prior=firm).maps()
    assert np.allclose(maps.slip_std, config.slip_prior_deviation)
    # beta = 4 and the largest threshold in use, 0.8.
    assert (maps.slip_mean + 2.0 * maps.slip_std > 0.8).all()


def test_a_prior_that_comes_late_gives_the_map_of_one_that_was_there():
    config = MappingConfiguration(**SMALL)
    prior = PriorMap.of_slip(GRID, sloping(GRID), CURVE)
    late = MapKeeper(config)
    for seed in range(6):
        late.add(stance(0.3, 0.06, seed=seed, point=(0.3 * seed, 1.0)))
    samples = late.samples()
    assert late.set_prior(prior) and not late.set_prior(prior)
    early = TerrainMapper(config, prior=prior)
    for sample in samples:
        early.take(sample)
    assert np.array_equal(late.mapper.maps().slip_mean, early.maps().slip_mean)
    assert np.array_equal(late.mapper.maps().slip_std, early.maps().slip_std)
    assert late.mapper.accepted == 6
    # Reset keeps the prior.
    late.reset()
    assert np.allclose(late.mapper.maps().slip_mean, sloping(GRID))


def test_cells_of_an_occupancy_grid_are_read_as_they_are_published():
    slip = sloping(GRID)
    cells = encode_slip_mean(slip)
    cells[0, 0] = -1
    prior = prior_of_cells(GRID, cells, 'slip', ENDS, CURVE)
    assert np.isnan(prior.slip[0, 0]) and np.abs(prior.slip - slip)[1:].max() < 0.0101
    log_strength = np.log(CURVE.inverse(slip))
    prior = prior_of_cells(GRID, encode_log_strength(log_strength, *ENDS), 'strength', ENDS, CURVE)
    step = math.log(ENDS[1] / ENDS[0]) / 100.0
    assert np.abs(prior.log_strength - log_strength).max() < 1.0001 * step


def write_image(folder, pixels, described, comment=b''):
    (folder / 'map.pgm').write_bytes(
        b'P5\n' + comment + b'%d %d\n255\n' % pixels.shape[::-1] + pixels.tobytes())
    (folder / 'map.yaml').write_text(
        f'image: map.pgm\nresolution: 0.5\norigin: [1.0, 2.0, 0.0]\n{described}\n')
    return folder / 'map.yaml'


def test_an_image_lies_where_its_yaml_says_with_its_first_row_in_the_north(tmp_path):
    pixels = np.array([[0, 255], [51, 204], [255, 0]], dtype=np.uint8)
    for described, shown in (('negate: 0', 1.0 - pixels / 255.0), ('negate: 1', pixels / 255.0),
                             ('mode: scale', 1.0 - pixels / 255.0)):
        prior = read_prior(write_image(tmp_path, pixels, described, b'# a comment\n'), GRID,
                           'slip', ENDS, CURVE)
        assert (prior.grid.origin_x, prior.grid.origin_y, prior.grid.resolution) == (1.0, 2.0, 0.5)
        assert np.allclose(prior.slip, np.round(shown[::-1], 2))


def test_a_raw_image_holds_cells_and_101_is_unknown(tmp_path):
    pixels = np.array([[40, 101]], dtype=np.uint8)
    prior = read_prior(write_image(tmp_path, pixels, 'mode: raw'), GRID, 'slip', ENDS, CURVE)
    assert prior.slip[0, 0] == 0.4 and np.isnan(prior.slip[0, 1])


@pytest.mark.parametrize('described', [
    'origin: [0.0, 0.0, 0.3]', 'mode: trinary', 'image: none.pgm', 'resolution: 0.0',
    'resolution: many', 'a: [', 'origin: 3'])
def test_a_yaml_that_makes_no_map_is_refused_with_its_name(tmp_path, described):
    path = write_image(tmp_path, np.zeros((2, 2), np.uint8), described)
    with pytest.raises(MapFileError, match=r'map\.yaml'):
        read_prior(path, GRID, 'slip', ENDS, CURVE)


def test_a_truncated_image_is_refused(tmp_path):
    path = write_image(tmp_path, np.zeros((20, 20), np.uint8), '')
    image = tmp_path / 'map.pgm'
    for content in (image.read_bytes()[:-1], b'', b'P6\n2 2\n255\n', b'P5\n2 2'):
        image.write_bytes(content)
        with pytest.raises(MapFileError):
            read_prior(path, GRID, 'slip', ENDS, CURVE)


def test_an_array_over_the_cells_is_a_prior_and_another_shape_is_refused(tmp_path):
    np.save(tmp_path / 'a.npy', sloping(GRID))
    config = MappingConfiguration(prior_file=str(tmp_path / 'a.npy'), **SMALL)
    assert np.allclose(MapKeeper(config).mapper.maps().slip_mean, sloping(GRID))
    np.save(tmp_path / 'a.npy', np.zeros((3, 3)))
    with pytest.raises(ParameterError, match=r'prior_file.*\(21, 21\)'):
        MapKeeper(config)


def test_the_map_of_an_earlier_mission_is_a_prior(tmp_path):
    earlier = MapKeeper(MappingConfiguration(map_directory=str(tmp_path), **SMALL))
    for seed in range(6):
        earlier.add(stance(0.3, 0.06, seed=seed, point=(0.3 * seed, 1.0)))
    earlier.save('monday', False)
    config = MappingConfiguration(prior_file=str(tmp_path / 'monday.map'), **SMALL)
    later = MapKeeper(config)
    assert np.allclose(later.mapper.maps().slip_mean, earlier.mapper.maps().slip_mean)
    assert np.allclose(later.mapper.maps().slip_std, config.slip_prior_deviation)
    assert later.mapper.accepted == 0


@pytest.mark.parametrize('name', ['none.npy', 'none.yaml', 'none.map', 'a.png'])
def test_a_prior_file_that_is_not_there_ends_with_a_sentence(tmp_path, name):
    with pytest.raises(ParameterError, match='prior_file'):
        MapKeeper(MappingConfiguration(prior_file=str(tmp_path / name), **SMALL))


def test_a_prior_of_the_wrong_shape_is_refused():
    with pytest.raises(ShapeError, match='expected'):
        PriorMap(grid=GRID, slip=np.zeros((2, 2)), log_strength=np.zeros(GRID.shape))
