# SPDX-License-Identifier: Apache-2.0
"""Calibration: what it fits, what it writes, and that the shipped files are current."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
import yaml

import psane_sim
from psane_mapping.configuration import MappingConfiguration
from psane_mapping.errors import ParameterError
from psane_mapping.parameters import from_mapping
from psane_mapping.propagation import slip_model_of
from psane_mapping.slip import CalibratedSlipCurve
from psane_sim.calibration.calibrate import (
    BACKWARD,
    Walk,
    is_usual,
    plan,
    reference_speed,
    rotary_walking,
    strength_scale,
)
from psane_sim.calibration.calibration import (
    Calibration,
    SweepResponse,
    fit_feed_forward,
    fit_slip,
    mapper_parameters,
    read_calibration,
)
from psane_sim.calibration.ladder import REFERENCE, Stride
from psane_sim.calibration.twist_tracking import centred, tracking_of
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.robots import RobotFileError, read_robot, robot_names

SHIPPED = Path(psane_sim.__file__).parent / 'data' / 'calibration'
STRENGTH = np.geomspace(0.03, 3.0, 11)


def test_a_curve_is_found_again_and_its_band_holds_the_measurements():
    generator = np.random.default_rng(0)
    true = CalibratedSlipCurve(residual=0.1, amplitude=1.2, half_strength=0.08, exponent=1.8)
    slip = true.slip(STRENGTH) + 0.02 * generator.normal(size=11)
    fit = fit_slip(STRENGTH, slip)
    assert np.abs(fit.curve.slip(STRENGTH) - true.slip(STRENGTH)).max() < 0.04
    assert (np.diff(fit.curve.slip(np.geomspace(0.001, 100.0, 500))) <= 0.0).all()
    low, high = (np.interp(np.log(STRENGTH), np.log(fit.strength), band)
                 for band in (fit.low, fit.high))
    assert ((slip >= low - 0.01) & (slip <= high + 0.01)).mean() >= 0.7
    assert (fit.low <= fit.high).all()


def test_the_feed_forward_is_found_again():
    true = SimulatorConfiguration()
    generator = np.random.default_rng(1)

    def forward(mean, half):
        push = true.speed_per_turn * abs(half) * max(0.0, 1.0 - mean / 1.4)
        return SweepResponse(mean - half, mean + half, 0.75 * (true.speed_per_sweep * mean + push),
                             0.75 * (true.turn_per_sweep + true.turn_gain * mean)
                             * half**true.turn_exponent)

    found = fit_feed_forward(
        [forward(mean, half) for mean, half in generator.uniform(0.1, 1.2, (20, 2))],
        [SweepResponse(-m, -m, -0.75 * true.backward_speed_per_sweep * m, 0.0)
         for m in (0.3, 0.8)],
        [SweepResponse(-h, h, 0.0, 0.75 * true.spot_turn_per_sweep * np.sign(h)
                       * abs(h)**true.spot_turn_exponent) for h in (0.3, -0.8)],
        0.75)
    for name, value in found.items():
        if name != 'backward_turn_per_sweep':
            assert value == pytest.approx(getattr(true, name), rel=1e-6), name


@pytest.mark.parametrize('name', ['x_rhex', 'sandbot'])
def test_mapper_and_simulator_take_the_shipped_files(name):
    mapper, simulator = read_calibration(SHIPPED / f'{name}.yaml')
    model = slip_model_of(from_mapping(MappingConfiguration, mapper))
    assert float(model.slip(1e-3)) == 1.0
    robot = read_robot(name)
    from_mapping(SimulatorConfiguration, {**robot.gait, **simulator})
    content = yaml.safe_load((SHIPPED / f'{name}.yaml').read_text())
    assert set(content) == {'/**/terrain_mapper', '/**/hexapod_sim'}


def test_the_defaults_are_those_of_the_default_robots_calibration():
    mapper, simulator = read_calibration(SHIPPED / 'x_rhex.yaml')
    for name, value in simulator.items():
        assert value == pytest.approx(getattr(SimulatorConfiguration(), name), rel=0.03), name
    # The default curve is the reference's; the project's own lies within its error of 0.023 RMSE.
    curve = slip_model_of(from_mapping(MappingConfiguration, mapper))
    away = curve.slip(STRENGTH) - CalibratedSlipCurve().slip(STRENGTH)
    assert np.sqrt(np.mean(away**2)) < 0.03


def test_the_shipped_slip_curve_is_what_the_robot_does_now():
    mapper, _ = read_calibration(SHIPPED / 'x_rhex.yaml')
    curve = slip_model_of(from_mapping(MappingConfiguration, mapper))
    speed = reference_speed(read_robot('x_rhex'))
    rigid = Walk('rigid', 'x_rhex', 1.0, speed, 0.0, 4).run().speed
    assert rigid == pytest.approx(0.318, abs=0.003)
    for strength in (0.03, 0.048, 0.119, 0.3, 1.194):
        slip = 1.0 - Walk('slip', 'x_rhex', strength, speed, 0.0, 4).run().speed / rigid
        assert slip == pytest.approx(float(curve.slip(strength)), abs=0.03)
        assert slip == pytest.approx(REFERENCE[strength][0], abs=0.05)


def stride(linear, angular):
    return Stride(1.0, linear, angular, 0.0, 0.0, 0.0)


def test_a_centred_feed_forward_misses_as_far_above_as_below():
    walks = {Walk('twist', 'x_rhex', strength, *twist, 4): stride(*(factor * value
                                                                   for value in twist))
             for strength, factor in ((0.3, 0.9), (3.0, 1.3))
             for twist in ((0.2, 0.0), (0.2, 0.1), (-0.1, 0.05), (0.0, 0.3))}
    tracking = tracking_of(walks)
    assert {entry.kind for entry in tracking} == {'forward', 'backward', 'spot'}
    for entry in tracking:
        assert entry.turn == pytest.approx((-0.1, 0.3))
    plain = {entry.name: 1.0 for entry in fields(SimulatorConfiguration)
             if '_per_' in entry.name or entry.name == 'turn_gain'}
    found = centred(plain, tracking)
    assert all(value == pytest.approx(1.1) for value in found.values())


def test_the_shipped_feed_forward_is_followed_on_firm_ground():
    _, simulator = read_calibration(SHIPPED / 'x_rhex.yaml')
    for twist in ((0.22, 0.0), (0.22, 0.1), (-0.15, 0.0), (0.0, 0.2)):
        for strength in (0.3, 3.0):
            walk = Walk('twist', 'x_rhex', strength, *twist, 4, gait=tuple(simulator.items()))
            (tracking,) = tracking_of({walk: walk.run()})
            assert np.abs((tracking.speed, tracking.turn)).max() <= 0.16


def test_a_calibration_is_read_as_it_was_written(tmp_path):
    curve = CalibratedSlipCurve()
    written = Calibration(mapper_parameters(curve), {'speed_per_sweep': 0.3}, 0.318, 0.01)
    written.write(tmp_path / 'robot.yaml')
    assert read_calibration(tmp_path / 'robot.yaml') == (written.mapper, written.simulator)
    (tmp_path / 'other.yaml').write_text('a: 1\n')
    with pytest.raises(ParameterError, match='terrain_mapper'):
        read_calibration(tmp_path / 'other.yaml')


def test_a_heavier_robot_on_smaller_feet_needs_firmer_ground():
    sandbot = read_robot('sandbot')
    assert strength_scale(read_robot('x_rhex').model) == 1.0
    assert 3.0 < strength_scale(sandbot.model) < 8.0
    strengths = {walk.strength for walk in plan('sandbot', 4) if walk.purpose == 'slip'}
    assert all(is_usual(sweep, 1.9) for sweep in BACKWARD)
    assert max(strengths) == pytest.approx(3.0 * strength_scale(sandbot.model))
    assert rotary_walking(sandbot).mass == pytest.approx(2.3)


def test_sandbot_has_its_published_sizes_and_turns_from_walking_to_swimming():
    robot = read_robot('sandbot')
    model = robot.model
    assert (model.mass, model.body_length, model.leg_radius, model.hip_above_belly) == (
        pytest.approx(2.3), 0.30, 0.0355, 0.025)
    speed = reference_speed(robot)
    hard = Walk('rigid', 'sandbot', 1.0, speed, 0.0, 4).run().speed
    firm, weak = (Walk('slip', 'sandbot', strength, speed, 0.0, 4).run().speed
                  for strength in (1.5, 0.3))
    assert 0.5 < hard < 0.8
    assert 0.25 < firm < 0.45
    assert weak < 0.05


@pytest.mark.parametrize('name', robot_names())
def test_every_shipped_robot_can_be_read(name):
    assert read_robot(name).configuration().stride_frequency > 0.0


@pytest.mark.parametrize(('text', 'problem'), [
    ('robot: {}', 'two sections'), ('- 1', 'two sections'), ('robot: [1]\ngait: {}', 'by name'),
    ('robot: {leg_radius: 0.1, size: 2}\ngait: {}', 'size'),
    ('robot: {leg_radius: -1.0}\ngait: {}', 'leg_radius'), ('robot: {', 'line')])
def test_a_bad_robot_file_gets_a_sentence(tmp_path, text, problem):
    path = tmp_path / 'robot.yaml'
    path.write_text(text)
    with pytest.raises((RobotFileError, ParameterError), match=problem):
        read_robot(str(path))


def test_an_unknown_robot_gets_the_list():
    with pytest.raises(RobotFileError, match='sandbot'):
        read_robot('rex')
