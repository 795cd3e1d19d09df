# SPDX-License-Identifier: Apache-2.0
"""The example robot outside the workspace: a table of stances that the mapper maps with."""

import importlib.util
import os
import subprocess
import sys

import numpy as np
import pytest
from felt_stances import stance
from nav_msgs.msg import OccupancyGrid
from node_process import PATIENCE
from source_tree import ROOT

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.conversions import cells_of
from psane_mapping.map_cells import SLIP_MEAN, MapSteps, cells_of_maps
from psane_mapping.mapper import TerrainMapper, TerrainSample
from psane_mapping.quality_of_service import CONTACTS, LATCHED
from psane_msgs.msg import TerrainSample as TerrainSampleMessage

EXAMPLE = ROOT / 'examples' / 'contacts_from_csv'
TABLE = EXAMPLE / 'data' / 'contacts.csv'
CHANNELS = ('forward', 'vertical', 'moment')


def example_module(name, place):
    """Load a module of the example, which is not installed."""
    spec = importlib.util.spec_from_file_location(name, EXAMPLE / place)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope='module')
def example():
    """Return the example's modules `table` and `make_table`."""
    package = example_module('contacts_from_csv', 'contacts_from_csv/__init__.py')
    package.__path__ = [str(EXAMPLE / 'contacts_from_csv')]
    table = example_module('contacts_from_csv.table', 'contacts_from_csv/table.py')
    return table, example_module('make_table', 'make_table.py')


def contact_of(row):
    """Return a stance of the table as the mapper's core knows it."""
    columns = {kind: np.column_stack([row.samples[f'{kind}_{name}'] for name in CHANNELS])
               for kind in ('measured', 'response', 'deviation')}
    return LegContact(leg=row.leg, touch_down=row.touch_down, lift_off=row.lift_off,
                      point=np.array([row.x, row.y]), point_deviation=row.point_deviation,
                      depth=np.array(row.samples['depth']), has_velocity=row.has_velocity,
                      **columns)


@pytest.fixture
def feed(tmp_path):
    """Start the example's node on a table; it is stopped at the end."""
    started = []

    def start(table, *parameters):
        path = os.pathsep.join([str(EXAMPLE), *sys.path])
        log = (tmp_path / 'feed.log').open('wb')
        started.append(subprocess.Popen(
            [sys.executable, '-m', 'contacts_from_csv.feed', '--ros-args', '-p',
             f'table:={table}', *parameters], stdout=log, stderr=subprocess.STDOUT,
            env={**os.environ, 'PYTHONPATH': path}))
        return started[-1]
    yield start
    for process in started:
        if process.poll() is None:
            process.terminate()
            process.wait(PATIENCE)


def test_the_table_is_small_and_comes_from_a_walk(example):
    stances = example[0].read_table(TABLE)
    assert TABLE.stat().st_size <= 200_000
    assert len(stances) > 40
    assert {row.leg for row in stances} == set(range(6))
    points = np.array([(row.x, row.y) for row in stances])
    assert np.ptp(points, axis=0).max() > 1.0
    times = [row.lift_off for row in stances]
    assert times == sorted(times)


def test_a_table_that_was_written_reads_back(example, tmp_path):
    table, make_table = example
    contacts = [stance(seed=seed, point=(2.0, 3.0 + seed), time=5.0 + seed, leg=seed)
                for seed in range(3)]
    make_table.write_table(tmp_path / 'table.csv', contacts, every=1)
    back = [contact_of(row) for row in table.read_table(tmp_path / 'table.csv')]
    assert [contact.leg for contact in back] == [0, 1, 2]
    for one, other in zip(contacts, back, strict=True):
        np.testing.assert_allclose(other.measured, one.measured, atol=0.005)
        np.testing.assert_allclose(other.depth, one.depth, atol=5e-6)
        np.testing.assert_allclose(other.point, one.point, atol=5e-5)


@pytest.mark.parametrize(('before', 'after', 'sentence'), [
    ('depth', 'deep', 'missing'), ('2.', 'two.', 'row 1'),
])
def test_a_broken_table_is_refused_with_its_place(example, tmp_path, before, after, sentence):
    lines = TABLE.read_text().splitlines(keepends=True)
    which = 2 if before == 'depth' else 3
    lines[which] = lines[which].replace(before, after)
    (tmp_path / 'broken.csv').write_text(''.join(lines))
    with pytest.raises(ValueError, match=sentence):
        example[0].read_table(tmp_path / 'broken.csv')


def test_the_example_makes_the_mappers_node_map_what_its_core_maps(example, feed, probe,
                                                                   start_node):
    config = MappingConfiguration()
    core = TerrainMapper(config)
    steps = MapSteps.of(config)
    rows = example[0].read_table(TABLE)
    before = cells_of_maps(core.maps(), steps)[SLIP_MEAN]
    samples = [core.add(contact_of(row)) for row in rows]
    accepted = sum(isinstance(sample, TerrainSample) for sample in samples)
    expected = cells_of_maps(core.maps(), steps)[SLIP_MEAN]
    assert accepted > 0.6 * len(rows)
    assert (expected != before).sum() > 200

    probe.listen(OccupancyGrid, 'slip/mean', LATCHED)
    probe.listen(TerrainSampleMessage, 'terrain_samples', CONTACTS)
    start_node('psane_mapping', 'terrain_mapper')
    probe.until(lambda: probe.heard['slip/mean'])
    np.testing.assert_array_equal(cells_of(probe.last('slip/mean'), 'map')[1], before)
    feed(TABLE, '-p', 'speed:=4.0')

    def is_mapped():
        return np.array_equal(cells_of(probe.last('slip/mean'), 'map')[1], expected)
    probe.until(lambda: len(probe.heard['terrain_samples']) == accepted)
    probe.until(is_mapped)


@pytest.mark.parametrize(('table', 'parameters', 'sentence'), [
    ('nowhere.csv', (), 'nowhere.csv'),
    (TABLE, ('-p', 'speed:=-1.0'), 'speed = -1.0, expected'),
])
def test_the_example_refuses_bad_parameters_with_a_sentence(feed, tmp_path, table, parameters,
                                                            sentence):
    process = feed(table, *parameters)
    assert process.wait(PATIENCE) == 2
    assert sentence in (tmp_path / 'feed.log').read_text()
