# SPDX-License-Identifier: Apache-2.0
"""Granular soil: agreement with plain resistive force theory, rest, and the belly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.leg import RobotModel, elements_in_base
from psane_mapping.leg_response import LegMotion, leg_response
from psane_mapping.rft import flowing_forces
from psane_sim.soils.element_soil import ElementSoil
from psane_sim.soils.family import granular_law
from psane_sim.soils.soil import BODY, RobotState
from psane_sim.terrains.terrain import Terrain

law = settings(deadline=None, derandomize=True, max_examples=30)
ROBOT = RobotModel()
STRENGTH = 0.4
TICK = 0.001


def soil(strength=STRENGTH):
    field = Terrain.uniform(strength).strength_field
    return ElementSoil(ROBOT, field, granular_law(field))


def random_state(seed, height=0.12):
    """Return a level robot with random leg angles and motion."""
    generator = np.random.default_rng(seed)
    state = RobotState.zeros()
    state.position[:] = (1.0, 2.0, height)
    state.angle[:] = generator.uniform(-0.5, 0.5, 6)
    state.speed[:] = generator.uniform(-2.0, 2.0, 6)
    state.velocity[:] = generator.uniform(-0.3, 0.3, 3)
    state.angular_velocity[:] = generator.uniform(-0.3, 0.3, 3)
    return state


def loads(ground, state, ticks):
    for _ in range(ticks):
        load = ground.load(state, TICK)
    return load


@law
@given(seed=st.integers(0, 1000), leg=st.integers(0, 5))
def test_ground_that_has_yielded_pushes_as_resistive_force_theory_says(seed, leg):
    state = random_state(seed)
    # The state is held while the memory saturates; then only the direction of motion counts.
    load = loads(soil(), state, 4000)
    position, normal = elements_in_base(ROBOT, leg, state.angle[leg])
    spin = np.array([0.0, state.speed[leg], 0.0])
    velocity = (state.velocity + np.cross(state.angular_velocity, position)
                + np.cross(spin, position - ROBOT.hips[leg]))
    depth = -(state.position[2] + position[:, 2])
    surface = ROBOT.leg
    force = flowing_forces(velocity, normal, np.array(surface.area), np.array(surface.side),
                           depth, np.full(len(depth), STRENGTH))
    np.testing.assert_allclose(load.force[leg], force.sum(axis=0), rtol=1e-6, atol=1e-6)
    moment = np.cross(position - ROBOT.hips[leg], force).sum(axis=0)
    np.testing.assert_allclose(load.moment[leg], moment, rtol=1e-6, atol=1e-6)
    assert load.depth[leg] == pytest.approx(depth.max())


@law
@given(seed=st.integers(0, 1000), leg=st.integers(0, 5))
def test_the_mapper_and_the_simulator_feel_the_same_leg(seed, leg):
    state = random_state(seed)
    ground = soil()
    felt = []
    heights = 0.18 - 0.0005 * np.arange(100)
    for height in heights:
        state.position[2] = height
        felt.append(ground.load(state, TICK).force[leg].copy())
    count = len(heights)
    # The mapper's first sample has no step before it; one sample earlier makes up for it.
    lead = np.concatenate(([heights[0]], heights))
    motion = LegMotion(
        time=TICK * np.arange(count + 1), angle=np.full(count + 1, state.angle[leg]),
        speed=np.full(count + 1, state.speed[leg]), height=lead,
        rotation=np.tile(state.rotation, (count + 1, 1, 1)),
        velocity=np.tile(state.velocity, (count + 1, 1)),
        angular_velocity=np.tile(state.angular_velocity, (count + 1, 1)))
    response = leg_response(ROBOT, leg, motion)
    np.testing.assert_allclose(felt, STRENGTH * response.force[1:], rtol=1e-9, atol=1e-9)


@law
@given(seed=st.integers(0, 1000))
def test_nothing_is_felt_above_the_ground(seed):
    load = loads(soil(), random_state(seed, height=0.25), 5)
    assert not load.force.any()
    assert not load.moment.any()
    assert (load.depth < 0.0).all()


def test_ground_that_was_pressed_holds_a_leg_that_has_come_to_rest():
    state = random_state(0)
    state.velocity[:] = (0.0, 0.0, -0.1)
    state.speed[:] = state.angular_velocity[:] = 0.0
    ground = soil()
    pressed = loads(ground, state, 100).force[:, 2].copy()
    state.velocity[:] = 0.0
    resting = loads(ground, state, 100).force[:, 2]
    assert (resting[:BODY] > 0.0).all()
    np.testing.assert_allclose(resting, pressed, rtol=1e-6)


def test_reset_forgets_the_displacement():
    state = random_state(0)
    ground = soil()
    loads(ground, state, 50)
    ground.reset()
    state.velocity[:] = state.angular_velocity[:] = 0.0
    state.speed[:] = 0.0
    assert not loads(ground, state, 1).force.any()


@law
@given(seed=st.integers(0, 1000))
def test_the_belly_is_never_sucked_down(seed):
    state = random_state(seed, height=0.02)
    assert loads(soil(), state, 20).force[BODY, 2] >= 0.0


def test_a_stronger_place_pushes_harder():
    state = random_state(3)
    weak = loads(soil(0.1), state, 50).force.copy()
    strong = loads(soil(0.2), state, 50).force
    np.testing.assert_allclose(strong, 2.0 * weak)
