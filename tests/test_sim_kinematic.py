# SPDX-License-Identifier: Apache-2.0
"""The kinematic stand-in: how it moves, what it feels, and that the stack closes a loop on it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.mapper import TerrainMapper, TerrainSample
from psane_planner.geodesic import travel_time
from psane_planner.status import PlannerState
from psane_sim.calibration.contact_errors import FEWEST, errors_of_run
from psane_sim.runs.kinematic import (
    FEET,
    FIRM_SLIP,
    TRIPODS,
    KinematicConfiguration,
    KinematicRobot,
)
from psane_sim.runs.kinematic_loop import KinematicLoop, KinematicSettings
from psane_sim.runs.simulated_touch import SimulatedTouch, SimulatedTouchConfiguration
from psane_sim.runs.summary import Ending, Task
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.terrains.omniscient import least_length, least_time, truly_free
from psane_sim.terrains.terrain import Terrain, strength_of_slip

STILL = KinematicConfiguration(sway=0.0)
DETAILS = {'threshold': 0.5, 'clearance': 0.17, 'border_width': 0.3, 'goal_tolerance': 0.3}


def ground(slip):
    return Terrain.uniform(float(strength_of_slip(np.array(slip))))


def robot_on(terrain, **details):
    return KinematicRobot(details.pop('configuration', STILL), terrain, (5.0, 5.0, 0.0), 0)


@pytest.mark.parametrize('slip', [0.1, 0.3, 0.6, 0.85])
def test_a_straight_walk_loses_exactly_the_share_of_slip(slip):
    robot = robot_on(ground(slip))
    robot.command(0.2, 0.0)
    for _ in range(400):
        robot.step(0.05)
    start = robot.pose[0]
    for _ in range(200):
        robot.step(0.05)
    assert (robot.pose[0] - start) / 10.0 == pytest.approx(0.2 * (1 - slip) / (1 - FIRM_SLIP),
                                                           rel=1e-3)
    assert robot.pose[1] == 5.0 and robot.pose[2] == 0.0


@settings(max_examples=30, deadline=None)
@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_no_command_moves_it_faster_than_its_limits(linear, angular):
    robot = robot_on(ground(FIRM_SLIP + 1e-3))
    robot.command(linear, angular)
    for _ in range(40):
        before = robot.pose.copy()
        robot.step(0.05)
        assert np.hypot(*(robot.pose - before)[:2]) <= 0.3 * 0.05 + 1e-9
        assert abs(math.remainder(robot.pose[2] - before[2], 2 * math.pi)) <= 0.4 * 0.05 + 1e-9


@pytest.mark.parametrize('side', [1.0, -1.0])
def test_soft_ground_on_one_side_turns_the_body_into_it(side):
    grid = load_terrain('env1').grid
    slip = np.tile(0.4 + 0.2 * side * (grid.y - 5.0), (grid.columns, 1)).T
    robot = robot_on(Terrain.from_slip('tilted', slip, (5.0, 5.0), (7.0, 5.0)))
    robot.command(0.3, 0.0)
    for _ in range(60):
        robot.step(0.05)
    assert robot.pose[2] * side > 0.01 and (robot.pose[1] - 5.0) * side > 0.0


def test_each_leg_ends_one_stance_a_stride_and_none_when_the_robot_stands():
    robot = robot_on(ground(0.2))
    robot.command(0.3, 0.0)
    ended = [leg for _ in range(1200) for leg in robot.step(0.05)]
    counts = np.bincount(ended, minlength=6)
    assert (np.abs(counts - 60.0 * STILL.stride_frequency) <= 1).all()
    robot.command(0.0, 0.0)
    for _ in range(100):
        robot.step(0.05)
    assert not [leg for _ in range(100) for leg in robot.step(0.05)]


def test_tripods_share_no_leg_and_hold_a_foot_on_either_side():
    assert sorted(TRIPODS[0] + TRIPODS[1]) == list(range(6))
    for tripod in TRIPODS:
        sides = FEET[list(tripod), 1] > 0
        assert sides.any() and not sides.all()


def felt(slip, count, seed, **details):
    """Return slip of samples that the mapper makes of contacts on even ground."""
    touch = SimulatedTouch(SimulatedTouchConfiguration(**details), ground(slip), seed)
    mapper = TerrainMapper(MappingConfiguration())
    outcomes = [mapper.add(touch.feel(k % 6, np.array((5.0, 5.0)), 1.0 * k))
                for k in range(count)]
    return [sample for sample in outcomes if isinstance(sample, TerrainSample)]


@pytest.mark.parametrize('slip', [0.15, 0.3, 0.5, 0.7])
def test_what_is_felt_is_right_on_average_over_runs(slip):
    means = [np.mean([sample.slip for sample in felt(slip, 8, seed)]) for seed in range(20)]
    assert np.mean(means) == pytest.approx(slip, abs=0.03)


def test_the_noise_is_not_less_than_that_of_the_multibody_simulation():
    """There: a bias of the log-strength of about 0.01 a run, a deviation of 0.02 to 0.04."""
    runs = [errors_of_run(felt(0.35, 40, seed), ground(0.35)) for seed in range(30)]
    assert 0.012 <= np.std([run.log_bias for run in runs]) <= 0.03
    assert 0.035 <= np.mean([run.log_deviation for run in runs]) <= 0.06


def test_errors_of_contacts_are_those_between_the_slips_that_decide():
    terrain = ground(0.35)
    true = float(terrain.strength(np.array((5.0, 5.0))))
    samples = [replace(sample, strength=true * math.exp(0.1), slip=0.33)
               for sample in felt(0.35, FEWEST, 0)]
    errors = errors_of_run(samples, terrain)
    assert errors.contacts == FEWEST
    assert (errors.log_bias, errors.log_deviation) == pytest.approx((0.1, 0.0), abs=1e-9)
    assert (errors.slip_bias, errors.slip_deviation) == pytest.approx((-0.02, 0.0), abs=1e-6)
    assert errors_of_run(samples[1:], terrain) is None
    assert errors_of_run(samples, ground(0.8)) is None


def test_ground_weaker_than_felt_feels_stronger_by_that_share():
    samples = felt(0.35, 40, 0, strength_factor=0.8, height_bias=0.0)
    true = float(strength_of_slip(np.array(0.35)))
    median = float(np.median([sample.strength for sample in samples]))
    assert median / true == pytest.approx(1.25, rel=0.05)


def test_the_stack_crosses_env1_on_the_stand_in_and_repeats_itself():
    terrain = load_terrain('env1')
    task = Task(terrain='env1', start=terrain.start, goal=terrain.goal, seed=3, duration=120.0,
                strategy='psane_geodesic', threshold=0.5)
    runs = []
    for _ in range(2):
        loop = KinematicLoop(task, terrain, terrain.start_pose, KinematicSettings())
        runs.append((*loop.run(), loop.plan))
    (outcome, score, plan), (again, same, _) = runs
    assert outcome.ending is Ending.REACHED and plan.state is PlannerState.REACHED
    assert score.unsafe_time_s == 0.0 and score.false_certified_cells == 0
    assert (outcome.time, outcome.contacts, score) == (again.time, again.contacts, same)
    fastest = least_time(terrain, terrain.start, terrain.goal, speed=0.3, **DETAILS)
    assert fastest < outcome.time < 3.0 * fastest


# --- the yardstick

def test_on_even_ground_the_least_way_is_straight_and_its_time_is_that_of_the_slip():
    slip = np.full(load_terrain('env1').grid.shape, 0.3)
    terrain = Terrain.from_slip('even', slip, (2.0, 5.0), (7.0, 5.0))
    ends = (terrain.start, terrain.goal)
    length = least_length(terrain, *ends, **DETAILS)
    # First-order marching is long by a few per cent, never short.
    assert 4.7 - 0.05 <= length <= 4.7 * 1.05
    time = least_time(terrain, *ends, speed=0.3, **DETAILS)
    assert time == pytest.approx(length / (0.3 * 0.7 / (1.0 - FIRM_SLIP)), rel=0.03)


def test_a_wall_without_a_gap_leaves_no_way():
    slip = np.full(load_terrain('env1').grid.shape, 0.1)
    slip[:, 100:104] = 0.9
    terrain = Terrain.from_slip('wall', slip, (2.0, 5.0), (7.0, 5.0))
    assert math.isinf(least_length(terrain, terrain.start, terrain.goal, **DETAILS))
    assert math.isinf(least_time(terrain, terrain.start, terrain.goal, speed=0.3, **DETAILS))


def test_free_ground_keeps_the_clearance_to_every_unsafe_cell():
    terrain = load_terrain('env2')
    free = truly_free(terrain, 0.5, 0.2, 0.3)
    grid = terrain.grid
    unsafe = grid.points[(terrain.slip > 0.5).ravel()]
    draw = np.random.default_rng(0)
    for point in draw.permutation(grid.points[free.ravel()])[:200]:
        assert np.hypot(*(unsafe - point).T).min() - grid.resolution / 2.0 >= 0.2 - 1e-9


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(1.5, 4.0))
def test_travel_time_scales_with_slowness_and_never_falls_where_ground_gets_slower(seed, factor):
    draw = np.random.default_rng(seed)
    grid = load_terrain('env1').grid
    slowness = np.where(draw.uniform(size=grid.shape) < 0.1, np.inf,
                        draw.uniform(1.0, 3.0, grid.shape))
    row, column = grid.index_of(np.array((5.0, 5.0)))
    slowness[row, column] = 1.0
    times = travel_time(slowness, grid, np.array((5.0, 5.0)))
    scaled = travel_time(slowness * factor, grid, np.array((5.0, 5.0)))
    reached = np.isfinite(times)
    np.testing.assert_array_equal(reached, np.isfinite(scaled))
    np.testing.assert_allclose(scaled[reached], factor * times[reached], rtol=1e-6)
    slower = slowness.copy()
    slower[:, :80] *= 1.3
    assert (travel_time(slower, grid, np.array((5.0, 5.0)))[reached]
            >= times[reached] - 1e-9).all()
