# SPDX-License-Identifier: Apache-2.0
"""Robot and soil by name: what comes with them, and what a run says of touch."""

import json

import numpy as np
import pytest

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.parameters import from_mapping
from psane_mapping.propagation import slip_model_of
from psane_sim.calibration.calibration import read_calibration
from psane_sim.configuration import SOIL_NAMES, SimulatorConfiguration
from psane_sim.demo.options import assignment_of, parse
from psane_sim.errors import SimulationError
from psane_sim.robot.chosen_robot import CALIBRATIONS, choose_robot
from psane_sim.robot.feed_forward import Sweep
from psane_sim.robot.robots import robot_names
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.truth_log import TruthEntry
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.summary import touch_in_words, touch_summary, write_strides


def test_the_default_robot_changes_no_parameter_and_no_ground():
    chosen, terrain = choose_robot(), load_terrain('env1')
    assert chosen.simulator == chosen.mapping == chosen.touch == chosen.model_parameters == {}
    assert chosen.terrain_for(terrain) is terrain
    assert chosen.simulator_configuration() == SimulatorConfiguration()


@pytest.mark.parametrize('name', robot_names())
def test_every_shipped_robot_comes_with_its_calibration(name):
    chosen = choose_robot(name)
    assert chosen.walks is not None
    # On ground that holds the robot slip is 1, give or take how it settles.
    assert np.all(np.diff(chosen.walks.slip) < 1e-3)
    chosen.simulator_configuration(), chosen.mapping_configuration(), chosen.touch_configuration()


def test_another_robot_walks_on_ground_as_firm_for_it_and_feels_with_its_own_curve():
    chosen, terrain = choose_robot('sandbot'), load_terrain('env1')
    mapper, simulator = read_calibration(CALIBRATIONS / 'sandbot.yaml')
    assert chosen.mapping == mapper
    assert simulator.items() <= chosen.simulator.items()
    assert chosen.touch_configuration().touch_down_force < 2.0 < (
        TouchConfiguration().touch_down_force)
    made, points = chosen.terrain_for(terrain), terrain.grid.points[::997]
    np.testing.assert_allclose(made.strength(points),
                               chosen.strength_factor * terrain.strength(points))
    curve = slip_model_of(from_mapping(MappingConfiguration, mapper))
    np.testing.assert_allclose(made.true_slip(points), curve.slip(made.strength(points)),
                               atol=1e-9)


@pytest.mark.parametrize('soil', SOIL_NAMES)
def test_a_soil_is_chosen_by_name(soil):
    assert choose_robot(soil=soil).simulator_configuration().soil == soil


def test_an_unknown_robot_or_soil_gets_the_list():
    with pytest.raises(SimulationError, match='sandbot'):
        choose_robot('mars2')
    with pytest.raises(SimulationError, match='scm_published'):
        choose_robot(soil='mud')


def test_the_demo_takes_a_robot_and_a_soil():
    assignment = assignment_of(parse(['--robot', 'sandbot', '--soil', 'rigid',
                                      '--threshold', '0.8']))
    assert (assignment.task.robot, assignment.task.soil) == ('sandbot', 'rigid')
    assert assignment.robot.simulator['soil'] == 'rigid'
    assert 'body_length' in assignment.robot.model_parameters


def test_a_calibration_of_ones_own_is_taken_with_the_robot(tmp_path):
    own = tmp_path / 'mine.yaml'
    own.write_text((CALIBRATIONS / 'x_rhex.yaml').read_text())
    chosen = choose_robot(calibration=own)
    assert chosen.mapping == read_calibration(own)[0]
    assert chosen.walks is None


def straight_run(speed):
    grid = load_terrain('env1').grid
    record = RunRecord(grid=grid, start=np.array([2.0, 5.0]), goal=None)
    record.truth = [TruthEntry(time=0.05 * i, pose=np.array([2.0 + 0.05 * i * speed, 5.0, 0.0]),
                               speed=speed, feet=np.full((6, 2), np.nan), sweep=Sweep(1.2, 1.2))
                    for i in range(200)]
    record.slip_mean = np.full(grid.shape, 0.2)
    record.refused = {'not deep enough': 3}
    return record


def test_a_run_says_how_far_its_map_was_from_its_strides(tmp_path):
    chosen, record = choose_robot(), straight_run(0.25)
    summary = json.loads(json.dumps(touch_summary(record, chosen)))
    # 0.318 m/s is the speed without slip.
    slip = 1.0 - 0.25 / 0.318
    assert summary['strides'] == 7
    assert summary['stride_slip_bias'] == pytest.approx(0.2 - slip, abs=0.02)
    assert summary['stride_slip_rmse'] == pytest.approx(abs(0.2 - slip), abs=0.02)
    lines = '\n'.join(touch_in_words(summary))
    assert '7 strides' in lines
    assert '3 not deep enough' in lines
    write_strides(record, chosen, tmp_path / 'strides.csv')
    table = np.loadtxt(tmp_path / 'strides.csv', delimiter=',', skiprows=1)
    assert table.shape == (7, 5)
    np.testing.assert_allclose(table[:, 4], 0.2)


def test_a_run_without_a_stride_says_so():
    record = straight_run(0.0)
    record.truth = record.truth[:5]
    summary = touch_summary(record, choose_robot())
    assert summary['strides'] == 0
    assert summary['stride_slip_rmse'] is None
    assert len(touch_in_words(summary)) == 1
