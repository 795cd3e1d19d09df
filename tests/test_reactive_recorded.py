# SPDX-License-Identifier: Apache-2.0
"""Regions from runs on the physics: the file, and both maps driven in some of them."""

import numpy as np
import pytest
import shapely

from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.errors import RecordingError
from psane_reactive.recorded import SHIPPED, read_recording, write_recording
from psane_reactive.trials import obstacle_trials, recorded_trials, run_trials


def test_there_are_many_sound_regions_of_all_terrains_in_a_small_file():
    regions = read_recording()
    assert len(regions) >= 200
    assert SHIPPED.stat().st_size <= 2**20
    assert all(region.polygon.is_valid and region.polygon.area > 0.0 for region in regions)
    terrains = {region.source.split(' ')[0].split(':')[0] for region in regions}
    assert terrains == {'env1', 'env2', 'smooth', 'patchy', 'corridors'}


def test_what_was_written_is_read_back(tmp_path):
    regions = read_recording()[:20]
    write_recording(regions, tmp_path / 'some.npz')
    for before, after in zip(regions, read_recording(tmp_path / 'some.npz'), strict=True):
        assert before.polygon.equals_exact(after.polygon, 1e-6)
        assert np.array_equal(before.position, after.position)
        assert np.array_equal(before.subgoal, after.subgoal)
        assert (before.time, before.source) == (after.time, after.source)


def test_a_file_that_is_no_recording_is_refused_by_its_name(tmp_path):
    path = tmp_path / 'other.npz'
    np.savez(path, points=np.zeros((3, 2)))
    with pytest.raises(RecordingError, match='other.npz'):
        read_recording(path)
    path.write_text('no archive')
    with pytest.raises(RecordingError, match='record_regions'):
        read_recording(path)


@pytest.mark.parametrize('steering', ['harmonic', 'purging'])
def test_all_goals_of_recorded_regions_are_reached_inside(steering):
    settings = ReactiveConfiguration(steering_map=steering)
    tally = run_trials(recorded_trials(read_recording()[1::20]), settings)
    assert tally.drives > 20
    assert tally.failures == []
    # The bound on lengths is the default map's.
    if steering == 'harmonic':
        assert np.quantile(tally.ratios, 0.95) <= 1.15


@pytest.mark.parametrize('steering', ['harmonic', 'purging'])
@pytest.mark.parametrize('holonomic', [False, True])
def test_all_goals_among_obstacles_are_reached_by_unicycle_and_point_robot(steering, holonomic):
    settings = ReactiveConfiguration(steering_map=steering, holonomic=holonomic)
    tally = run_trials(obstacle_trials(8, seed=5), settings, step=0.02)
    assert tally.failures == []
    assert (tally.reached, tally.exits, tally.exceptions) == (8, 0, 0)


def test_a_drive_that_fails_is_counted_and_named():
    trial = next(iter(recorded_trials(read_recording()[100:101])))
    nowhere = trial._replace(region=shapely.box(0.0, 0.0, 0.0, 1.0))
    tally = run_trials([nowhere], ReactiveConfiguration())
    assert (tally.drives, tally.reached) == (1, 0)
    assert trial.name in tally.failures[0]
