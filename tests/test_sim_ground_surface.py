# SPDX-License-Identifier: Apache-2.0
"""Slopes and footprints."""

from dataclasses import replace

import numpy as np
import pytest

from psane_mapping.grid import Grid
from psane_mapping.leg import RobotModel
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.errors import SimulationError
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.soils.element_soil import ElementSoil
from psane_sim.soils.family import granular_law
from psane_sim.soils.ground_surface import (
    HeightField,
    compaction_of,
    fresh_prints,
    height_at,
    normal_at,
    pit_at,
)
from psane_sim.soils.soil import RobotState
from psane_sim.terrains.terrain import Terrain

GRID = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.5)
ROBOT = RobotModel()


def press(prints, depth, seconds=0.1, x=1.0, y=1.0):
    """Press a plate down for some time and take it away for as long as the ground needs."""
    for _ in range(round(seconds / 0.01)):
        prints[2][0] += 0.01
        found = pit_at(prints, x, y, depth)
    prints[2][0] += 0.2
    return found


def test_a_plane_has_its_heights_and_its_normal():
    relief = HeightField.incline(GRID, 0.1, -0.2).relief
    assert height_at(relief, 6.0, 5.0) - height_at(relief, 5.0, 5.0) == pytest.approx(0.1)
    assert height_at(relief, 5.0, 6.0) - height_at(relief, 5.0, 5.0) == pytest.approx(-0.2)
    np.testing.assert_allclose(normal_at(relief, 4.3, 6.1),
                               np.array([-0.1, 0.2, 1.0]) / np.sqrt(1.05))


@pytest.mark.parametrize('height', [np.zeros((3, 3)), np.full(GRID.shape, np.nan)])
def test_heights_that_do_not_fit_are_refused(height):
    with pytest.raises(SimulationError, match='heights'):
        HeightField(GRID, height)


def test_on_a_slope_everything_is_as_on_level_ground_in_the_slopes_own_frame():
    slope = 0.3
    pitch = -np.arctan(slope)
    turn = np.array([[np.cos(pitch), 0.0, np.sin(pitch)], [0.0, 1.0, 0.0],
                     [-np.sin(pitch), 0.0, np.cos(pitch)]])
    field = Terrain.uniform(0.4).strength_field
    relief = HeightField.incline(GRID, slope, 0.0).relief
    grounds = [ElementSoil(ROBOT, field, granular_law(field)),
               ElementSoil(ROBOT, field, granular_law(field), relief=relief)]
    level, tilted = RobotState.zeros(), RobotState.zeros()
    centre = np.array([5.0, 5.0, 0.0])
    level.position[:] = centre + (0.0, 0.0, 0.12)
    level.velocity[:] = (0.2, 0.05, -0.1)
    tilted.position[:] = centre + turn @ (0.0, 0.0, 0.12)
    tilted.velocity[:] = turn @ level.velocity
    tilted.rotation[:] = turn
    for _ in range(50):
        flat, inclined = (ground.load(state, 0.001)
                          for ground, state in zip(grounds, (level, tilted), strict=True))
    np.testing.assert_allclose(inclined.force, flat.force @ turn.T, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(inclined.moment, flat.moment @ turn.T, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(inclined.depth, flat.depth, atol=1e-9)


def test_a_robot_climbs_a_slope_and_slips_more_than_on_level_ground():
    config = SimulatorConfiguration()
    level = Terrain.uniform(0.5)
    gained, noses = [], []
    for slope in (0.0, 0.12):
        terrain = replace(level, height_field=HeightField.incline(GRID, slope, 0.0))
        with HexapodSimulator(config, terrain, (5.0, 5.0, 0.0)) as robot:
            robot.command(0.25, 0.0)
            robot.step(5000)
            truth = robot.truth()
            rises = []
            for _ in range(40):
                robot.step(33)
                rises.append(robot.truth().rotation[2, 0])
        gained.append(truth.position[0] - 5.0)
        above = truth.position[2] - terrain.height_at(*truth.position[:2])
        assert 0.02 < above < 0.2
        noses.append(np.mean(rises))
    # The nose is up a little on level ground too, since the rear legs sink deeper.
    assert noses[1] - noses[0] == pytest.approx(np.sin(np.arctan(0.12)), abs=0.05)
    assert 0.4 * gained[0] < gained[1] < 0.97 * gained[0]


def test_ground_that_was_pressed_down_stays_down():
    prints = fresh_prints(0.02, 0.5, 0.0, 0.3)
    assert press(prints, 0.04) == 0.0
    assert press(prints, 0.01) == pytest.approx(0.02)
    prints[2][0] += 1e4
    assert press(prints, 0.01) == pytest.approx(0.02)
    assert press(prints, 0.06) == pytest.approx(0.02)
    assert press(prints, 0.01) == pytest.approx(0.03)
    assert press(prints, 0.01, x=1.5) == 0.0


def test_sand_flows_back_in_its_time():
    prints = fresh_prints(0.02, 1.0, 10.0, 0.0)
    press(prints, 0.04)
    first = press(prints, 0.001, seconds=0.01)
    prints[2][0] += 10.0
    later = press(prints, 0.001, seconds=0.01)
    assert 0.036 < first <= 0.04
    assert later == pytest.approx(first * np.exp(-1.02), rel=0.02)


def test_a_footprint_is_firmer_the_deeper_it_is_and_not_without_end():
    prints = fresh_prints(0.02, 0.5, 0.0, 0.3)
    factors = [compaction_of(prints, pit) for pit in (0.0, 0.01, 0.03, 0.05, 0.5)]
    assert factors[0] == 1.0
    assert (np.diff(factors[:4]) > 0.0).all()
    assert factors[3] == factors[4] == pytest.approx(1.3)


def test_walking_twice_over_the_same_place_is_not_the_first_time_again():
    # March in place, so that the feet meet their own prints.
    depths = []
    for footprints in (False, True):
        config = SimulatorConfiguration(footprints=footprints)
        with HexapodSimulator(config, Terrain.uniform(0.3), (5.0, 5.0, 0.0)) as robot:
            robot.command(0.02, 0.0)
            robot.step(6000)
            depths.append(robot.truth().position[2])
    assert depths[1] < depths[0] - 0.01
