# SPDX-License-Identifier: Apache-2.0
"""The simulated hexapod: stands, walks, turns, stops, sinks, and never falls over."""

import numpy as np
import pytest

from psane_mapping.parameters import from_mapping
from psane_sim.calibration.ladder import REFERENCE, measure_creep, measure_slip
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.errors import StartError
from psane_sim.robot.gravity import GRAVITY
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.terrains.terrain import Terrain

CONFIG = SimulatorConfiguration()
CENTRE = (5.0, 5.0, 0.0)
STRIDE = 1.0 / CONFIG.stride_frequency
SLIP_TOLERANCE = 0.05
"""Agreement asked for with the independent prototype's ladder [-]."""


def simulator(strength, pose=CENTRE, **changes):
    return HexapodSimulator(from_mapping(SimulatorConfiguration, changes),
                            Terrain.uniform(strength), pose)


def run(robot, seconds):
    robot.step(round(seconds / robot.config.time_step))
    return robot.truth()


def test_slip_falls_with_strength_and_agrees_with_the_reference():
    strengths = (0.048, 0.119, 0.3, 1.194)
    slips = [measure_slip(strength, warm_up=2 * STRIDE, duration=4 * STRIDE).slip
             for strength in strengths]
    assert (np.diff(slips) < 0.0).all()
    reference = [REFERENCE[strength][0] for strength in strengths]
    np.testing.assert_allclose(slips, reference, atol=SLIP_TOLERANCE)


@pytest.mark.parametrize('strength', [0.03, 0.119, 0.475, 3.0])
def test_a_standing_robot_creeps_less_than_a_twentieth_of_a_millimetre_per_second(strength):
    assert measure_creep(strength, settle=1.5, duration=1.0) < 0.05e-3


@pytest.mark.parametrize('strength', [0.119, 1.0])
def test_at_rest_the_ground_carries_exactly_the_weight(strength):
    with simulator(strength) as robot:
        truth = run(robot, 3.0)
    carried = truth.foot_force[:, 2].sum() + truth.belly_force[2]
    assert carried == pytest.approx(robot.robot.mass * GRAVITY, rel=1e-3)
    assert truth.hip_force[:, 2].sum() == pytest.approx(
        truth.foot_force[:, 2].sum() - 6.0 * robot.robot.leg_mass * GRAVITY, rel=1e-2)
    np.testing.assert_allclose(truth.specific_force, truth.rotation.T @ [0.0, 0.0, GRAVITY],
                               atol=0.01)


def test_hip_wrenches_are_the_ground_load_less_the_legs_own_weight():
    with simulator(0.3, (5.0, 5.0, 0.7)) as robot:
        robot.command(0.25, 0.1)
        run(robot, 1.5)
        truths = [run(robot, 0.005) for _ in range(400)]
    rotation = np.array([truth.rotation for truth in truths])
    hip = np.einsum('nij,nlj->nli', rotation, [truth.hip_force for truth in truths])
    ground = np.array([truth.foot_force for truth in truths])
    deep = np.array([truth.foot_depth for truth in truths]) > 0.003
    for leg in range(6):
        for axis in range(3):
            seen = deep[:, leg]
            assert np.corrcoef(hip[seen, leg, axis], ground[seen, leg, axis])[0, 1] > 0.99


def test_ground_of_slip_one_holds_a_robot_that_tries_to_leave():
    with simulator(0.015) as robot:
        robot.command(0.3, 0.0)
        truth = run(robot, 15.0)
    assert np.hypot(truth.position[0] - 5.0, truth.position[1] - 5.0) < 0.05
    assert truth.belly_touches


@pytest.mark.parametrize('delay', [0.1, 0.35, 0.6, 0.95])
def test_the_robot_stands_half_a_second_after_it_is_told_to(delay):
    with simulator(1.0) as robot:
        robot.command(0.3, 0.0)
        run(robot, 3.0 + delay)
        robot.command(0.0, 0.0)
        stopped = run(robot, 0.5)
        later = run(robot, 1.0)
    assert np.linalg.norm(stopped.velocity) < 0.05
    assert np.linalg.norm(later.position - stopped.position) < 0.01
    assert np.linalg.norm(later.velocity) < 0.005
    assert (later.foot_depth > 0.0).all()
    assert later.tilt < 0.25


@pytest.mark.parametrize('strength', [0.3, 1.0])
@pytest.mark.parametrize('rate', [0.2, -0.4])
def test_it_turns_on_the_spot_about_as_fast_as_it_is_told(strength, rate):
    stride = measure_slip(strength, linear=0.0, angular=rate, warm_up=2 * STRIDE,
                          duration=4 * STRIDE)
    assert stride.yaw_rate == pytest.approx(rate, rel=0.2)
    assert abs(stride.speed) < 0.06


@pytest.mark.parametrize(('linear', 'angular'), [(0.1, 0.0), (0.25, 0.0), (0.2, 0.15),
                                                 (0.28, -0.1), (-0.15, 0.0)])
@pytest.mark.parametrize('strength', [0.3, 1.0])
def test_it_follows_a_twist_within_a_seventh_on_firm_ground(strength, linear, angular):
    stride = measure_slip(strength, linear=linear, angular=angular, warm_up=2 * STRIDE,
                          duration=4 * STRIDE)
    assert stride.speed == pytest.approx(linear, rel=0.15)
    assert stride.yaw_rate == pytest.approx(angular, rel=0.15, abs=0.01)


@pytest.mark.parametrize(('seed', 'strength'), [(0, 1.0), (1, 0.3), (2, 0.1), (3, 3.0)])
def test_it_never_falls_over_whatever_it_is_told(seed, strength):
    generator = np.random.default_rng(seed)
    with simulator(strength) as robot:
        for _ in range(12):
            stand = generator.random() < 0.2
            robot.command(*((0.0, 0.0) if stand else generator.uniform(-0.5, 0.5, 2)))
            truth = run(robot, float(generator.uniform(0.2, 2.0)))
            assert truth.tilt < 0.6


def test_half_and_double_the_time_step_agree():
    speeds = [measure_slip(0.3, config=SimulatorConfiguration(time_step=step),
                           warm_up=2 * STRIDE, duration=3 * STRIDE).speed
              for step in (0.0005, 0.001, 0.002)]
    np.testing.assert_allclose(speeds, speeds[1], rtol=0.02)


def test_two_simulators_in_one_process_do_not_disturb_each_other():
    with simulator(0.5) as alone:
        alone.command(0.2, 0.1)
        expected = run(alone, 1.0).position
    with simulator(0.5) as one, simulator(0.1) as other:
        one.command(0.2, 0.1)
        other.command(-0.2, 0.0)
        for _ in range(100):
            one.step(10)
            other.step(10)
        np.testing.assert_array_equal(one.truth().position, expected)


def test_time_counts_the_ticks_since_the_robot_had_settled():
    with simulator(1.0) as robot:
        assert robot.time == 0.0
        robot.step(250)
        assert robot.time == pytest.approx(0.25)


def test_a_truth_does_not_change_as_the_simulation_goes_on():
    with simulator(1.0) as robot:
        robot.command(0.3, 0.0)
        before = run(robot, 0.5)
        copies = {name: np.copy(value) for name, value in vars(before).items()}
        run(robot, 0.3)
    for name, value in copies.items():
        np.testing.assert_array_equal(getattr(before, name), value)


@pytest.mark.parametrize(('pose', 'problem'), [
    ((11.0, 5.0, 0.0), 'outside the workspace'),
    ((5.0, float('nan'), 0.0), 'not finite'),
])
def test_a_start_that_is_not_in_the_workspace_is_refused(pose, problem):
    terrain = Terrain.from_slip('flat', np.full((201, 201), 0.1), (2.0, 2.0), (8.0, 8.0))
    with pytest.raises(StartError, match=problem):
        HexapodSimulator(CONFIG, terrain, pose)
