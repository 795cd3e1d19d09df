# SPDX-License-Identifier: Apache-2.0
"""Slip of single strides, and random commands."""

import numpy as np
import pytest

from psane_mapping.errors import ParameterError
from psane_mapping.grid import Grid
from psane_sim.calibration.ladder import measure_slip
from psane_sim.calibration.steered_walks import SteeredWalks, read_walks
from psane_sim.calibration.stride_slip import WALKS, StrideSlip, compare, strides_of, ways_ahead
from psane_sim.calibration.twist_trials import FALLEN, walk_at_random
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.runs.truth_log import TruthEntry
from psane_sim.terrains.terrain import Terrain

CONFIG = SimulatorConfiguration()
TABLE = read_walks(WALKS)


def strides_on(strength, command, seconds):
    entries = []
    with HexapodSimulator(CONFIG, Terrain.uniform(strength), (5.0, 5.0, 0.4)) as robot:
        robot.command(*command)
        for _ in range(round(seconds / 0.05)):
            entries.append(TruthEntry.of(robot.truth()))
            robot.step(50)
    return strides_of(entries, TABLE, CONFIG.stride_frequency)


@pytest.mark.parametrize('strength', [0.08, 0.2, 1.0])
def test_the_slip_of_strides_is_that_of_a_long_walk(strength):
    strides = strides_on(strength, (0.29, 0.0), 9.0)
    assert len(strides) >= 5
    expected = measure_slip(strength).slip
    # The first strides set off from rest.
    assert np.median([stride.slip for stride in strides]) == pytest.approx(expected, abs=0.04)


@pytest.mark.parametrize(('linear', 'angular'), [(0.25, 0.3), (0.2, -0.15), (0.15, 0.1)])
@pytest.mark.parametrize('strength', [0.1, 0.15, 0.4])
def test_a_robot_that_steers_slips_no_more_than_one_that_walks_straight(strength, linear, angular):
    strides = strides_on(strength, (linear, angular), 8.0)
    # Advance alone would make it up to 0.7 here: steering costs way.
    expected = measure_slip(strength).slip
    assert np.median([stride.slip for stride in strides]) == pytest.approx(expected, abs=0.06)


def test_a_robot_that_stands_or_turns_on_the_spot_or_walks_backward_has_no_slip():
    for command in ((0.0, 0.0), (0.0, 0.4), (-0.2, 0.0)):
        assert not strides_on(0.5, command, 3.0)


def test_a_way_is_counted_along_the_heading():
    yaw = 0.3
    poses = np.array([(0.0, 0.0, yaw), (np.cos(yaw), np.sin(yaw), yaw),
                      (np.cos(yaw) - np.sin(yaw), np.sin(yaw) + np.cos(yaw), yaw)])
    np.testing.assert_allclose(ways_ahead(poses), [1.0, 0.0], atol=1e-12)


def test_a_shorter_way_is_more_slip_and_nothing_is_cut_off():
    ways = np.linspace(0.1, 0.4, len(TABLE.strength))
    slips = [TABLE.slip_of(way, ways) for way in np.linspace(-0.2, 0.8, 101)]
    assert (np.diff(slips) < 0.0).all()
    assert slips[0] > 1.0 > 0.0 > slips[-1]
    for way, slip in zip(ways, TABLE.slip, strict=True):
        assert TABLE.slip_of(way, ways) == pytest.approx(slip)


def test_advances_are_those_of_the_table_and_lie_between_them():
    mean, half = (axis.ravel() for axis in np.meshgrid(TABLE.mean, TABLE.half, indexing='ij'))
    expected = TABLE.advance.reshape(len(TABLE.strength), -1).T
    np.testing.assert_allclose(TABLE.advances(mean, half), expected, atol=1e-12)
    np.testing.assert_allclose(TABLE.advances(mean, -half), expected, atol=1e-12)
    middle = TABLE.advances(np.array([0.5 * (TABLE.mean[1] + TABLE.mean[2])]), np.zeros(1))[0]
    np.testing.assert_allclose(middle, 0.5 * (TABLE.advance[:, 1, 0] + TABLE.advance[:, 2, 0]))


def test_walks_are_read_as_they_were_written(tmp_path):
    table = SteeredWalks(np.array([0.1, 1.0]), np.array([0.0, 1.0]), np.array([0.0, 0.5]),
                         np.arange(8.0).reshape(2, 2, 2), -np.arange(8.0).reshape(2, 2, 2),
                         np.array([0.5, 0.1]))
    table.write(tmp_path / 'walks.csv')
    back = read_walks(tmp_path / 'walks.csv')
    for name in ('strength', 'mean', 'half', 'advance', 'turn', 'slip'):
        np.testing.assert_array_equal(getattr(back, name), getattr(table, name))
    text = (tmp_path / 'walks.csv').read_text()
    for broken in ('a,b\n', text[:-20]):
        (tmp_path / 'other.csv').write_text(broken)
        with pytest.raises(ParameterError):
            read_walks(tmp_path / 'other.csv')


def test_a_map_is_compared_over_the_whole_way_of_a_stride():
    grid = Grid.over_workspace(0.0, 0.0, 1.0, 1.0, 0.1)
    slip = np.tile(np.linspace(0.05, 0.95, 11), (11, 1))[:grid.shape[0], :grid.shape[1]]
    way = np.column_stack((np.linspace(0.2, 0.8, 13), np.full(13, 0.5)))
    error = compare([StrideSlip(1.0, way, 0.3)], grid, slip)
    assert error.mean == pytest.approx(float(slip[5].mean()) - 0.3, abs=0.02)
    assert error.rmse == pytest.approx(abs(error.mean))
    assert np.isnan(compare([], grid, slip).rmse)


def test_random_commands_do_not_make_it_fall():
    # A thousand are walked by `python -m psane_sim.calibration.twist_trials`.
    trials = [walk_at_random(seed) for seed in range(5000, 5006)]
    assert all(trial.tilt < FALLEN for trial in trials)
    assert [walk_at_random(5000)] == trials[:1]
