# SPDX-License-Identifier: Apache-2.0
"""What holds of every soil: it gives no energy, carries a robot and lets it walk."""

import numpy as np
import pytest

from psane_mapping.leg import RobotModel
from psane_sim.calibration.ladder import measure_slip
from psane_sim.configuration import SOIL_NAMES, SimulatorConfiguration
from psane_sim.robot.gravity import GRAVITY
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.soils.element_soil import ElementSoil, SoilLaw
from psane_sim.soils.family import SOILS
from psane_sim.soils.laws import CONTACT
from psane_sim.soils.soil import BODY, RobotState
from psane_sim.terrains.terrain import Terrain

ROBOT = RobotModel()
TICK = 0.001
STRIDE = 1.0 / SimulatorConfiguration().stride_frequency


def ground(name, strength):
    field = Terrain.uniform(strength).strength_field
    return ElementSoil(ROBOT, field, SOILS[name](field))


def loop(generator, count, size):
    """Return positions and rates of a random closed path, (count,), and its rate."""
    phase = 2.0 * np.pi * np.arange(count) / count
    value, rate = np.zeros(count), np.zeros(count)
    for harmonic in range(1, 5):
        a, b = size * generator.normal(size=2) / harmonic
        value += a * np.cos(harmonic * phase) + b * np.sin(harmonic * phase)
        rate += harmonic * (b * np.cos(harmonic * phase) - a * np.sin(harmonic * phase))
    return value, rate * 2.0 * np.pi / (count * TICK)


def work_of_a_cycle(soil, seed, size, height):
    """Return net work of the soil on a body on a closed path, and the largest energy it held.

    The body does not turn; all legs turn alike. The path begins and ends above the ground.
    """
    generator = np.random.default_rng(seed)
    count = 1000
    x, vx = loop(generator, count, size)
    y, vy = loop(generator, count, 0.3 * size)
    z, vz = loop(generator, count, size)
    angle, speed = loop(generator, count, size / ROBOT.leg_radius)
    start = int(np.argmax(z))
    z = z - z.max() + height
    state = RobotState.zeros()
    work, lowest, highest = 0.0, 0.0, 0.0
    for i in (start + np.arange(count + 1)) % count:
        state.position[:] = x[i], y[i], z[i]
        state.velocity[:] = vx[i], vy[i], vz[i]
        state.angle[:], state.speed[:] = angle[i], speed[i]
        load = soil.load(state, TICK)
        power = float(load.force.sum(axis=0) @ state.velocity + load.moment[:BODY, 1].sum()
                      * speed[i])
        work += power * TICK
        lowest, highest = min(lowest, work), max(highest, work)
    assert (load.depth < 0.0).all(), 'the path does not end above the ground'
    return work, highest - lowest


@pytest.mark.parametrize('size', [0.003, 0.02, 0.06])
@pytest.mark.parametrize('name', SOIL_NAMES)
def test_no_soil_does_positive_work_over_a_closed_cycle(name, size):
    # Each tick's power is that of its end, so that even a perfect spring is off by a share of what
    # it held that falls with the tick: 2 % here.
    for seed in range(12):
        work, held = work_of_a_cycle(ground(name, 0.3), seed, size, 0.1755)
        assert work <= 0.02 * held
        assert held > 0.0


def spring():
    """Return ground without friction or damping, which gives back all that it takes."""
    field = Terrain.uniform(0.3).strength_field
    return ElementSoil(ROBOT, field, SoilLaw(CONTACT, np.zeros(2),
                                             np.full(field.log_strength.shape, np.log(3.0e5))))


class Giving:
    """A spring that pushes a little harder when it lets go."""

    def __init__(self):
        self._soil = spring()

    def load(self, state, dt):
        load = self._soil.load(state, dt)
        factor = 1.1 if state.velocity[2] > 0.0 else 0.9
        load.force[:] *= factor
        load.moment[:] *= factor
        return load


def test_the_measure_of_work_is_right():
    cycles = [work_of_a_cycle(spring(), seed, 0.02, 0.1755) for seed in range(12)]
    assert all(abs(work) <= 0.02 * held for work, held in cycles)
    cycles = [work_of_a_cycle(Giving(), seed, 0.02, 0.1755) for seed in range(12)]
    assert any(work > 0.02 * held for work, held in cycles)


def test_the_configuration_names_every_soil():
    assert set(SOIL_NAMES) == set(SOILS)


@pytest.mark.parametrize('name', SOIL_NAMES)
def test_a_robot_stands_and_walks_on_every_soil(name):
    config = SimulatorConfiguration(soil=name)
    with HexapodSimulator(config, Terrain.uniform(1.0), (5.0, 5.0, 0.3)) as robot:
        robot.step(2000)
        before = robot.truth()
        robot.step(1000)
        after = robot.truth()
    carried = after.foot_force[:, 2].sum() + after.belly_force[2]
    assert carried == pytest.approx(robot.robot.mass * GRAVITY, rel=0.05)
    assert np.linalg.norm(after.position - before.position) < 0.001
    walked = measure_slip(1.0, config=config, warm_up=2 * STRIDE, duration=3 * STRIDE)
    assert walked.speed > 0.25
    assert walked.tilt < 0.3


@pytest.mark.parametrize('name', [name for name in SOIL_NAMES if name != 'rigid'])
def test_a_robot_sinks_and_is_held_where_a_soil_is_weak(name):
    config = SimulatorConfiguration(soil=name)
    firm, weak = (measure_slip(strength, config=config, warm_up=3 * STRIDE, duration=2 * STRIDE)
                  for strength in (1.0, 0.008))
    assert weak.depth > firm.depth + 0.05
    assert weak.speed < 0.5 * firm.speed


def test_hard_ground_is_the_ground_that_slip_is_measured_against():
    walked = measure_slip(1.0, config=SimulatorConfiguration(soil='rigid'), warm_up=2 * STRIDE,
                          duration=4 * STRIDE)
    assert abs(walked.slip) < 0.01
    assert walked.depth < 0.005
