# SPDX-License-Identifier: Apache-2.0
"""What the sensors publish: exact without noise, and as noisy as is said with it."""

import numpy as np
import pytest

from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.feed_forward import Sweep
from psane_sim.robot.truth import Truth
from psane_sim.touch.sensing import Sensors

CONFIG = SimulatorConfiguration()
COUNT = 4000


def truth():
    """Return a robot that is turned by 30 degrees and moves."""
    half = np.radians(30.0) / 2.0
    cosine, sine = np.cos(2.0 * half), np.sin(2.0 * half)
    return Truth(
        time=1.5, position=np.array([1.0, 2.0, 0.14]),
        quaternion=np.array([0.0, 0.0, np.sin(half), np.cos(half)]),
        rotation=np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]),
        velocity=np.array([0.3 * cosine, 0.3 * sine, 0.0]),
        angular_velocity=np.array([0.0, 0.0, 0.4]), specific_force=np.array([0.0, 0.0, 9.81]),
        joint_angle=np.linspace(-1.0, 1.0, 6), joint_speed=np.linspace(0.0, 5.0, 6),
        joint_torque=np.full(6, 2.0), hip_force=np.tile([10.0, 0.0, 30.0], (6, 1)),
        hip_moment=np.tile([0.0, -2.0, 0.0], (6, 1)), foot_force=np.zeros((6, 3)),
        foot=np.zeros((6, 3)), foot_depth=np.zeros(6), belly_depth=-0.1, belly_force=np.zeros(3),
        sweep=Sweep(0.0, 0.0))


def test_without_noise_every_sample_is_exact_and_in_its_frame():
    exact, sensors = truth(), Sensors(SimulatorConfiguration(noise_scale=0.0), seed=1)
    joints, wrenches = sensors.joints(exact), sensors.wrenches(exact)
    imu, odometry = sensors.imu(exact), sensors.odometry(exact)
    np.testing.assert_array_equal(joints.position, exact.joint_angle)
    np.testing.assert_array_equal(joints.velocity, exact.joint_speed)
    np.testing.assert_array_equal(joints.effort, exact.joint_torque)
    np.testing.assert_array_equal(wrenches.force, exact.hip_force)
    np.testing.assert_array_equal(wrenches.moment, exact.hip_moment)
    np.testing.assert_array_equal(imu.specific_force, exact.specific_force)
    np.testing.assert_allclose(imu.quaternion, exact.quaternion)
    np.testing.assert_allclose(odometry.velocity, [0.3, 0.0, 0.0], atol=1e-12)
    np.testing.assert_array_equal(odometry.position, exact.position)
    assert odometry.yaw == pytest.approx(exact.yaw) == pytest.approx(np.radians(30.0))
    assert {sample.time for sample in (joints, wrenches, imu, odometry)} == {1.5}


def test_noise_has_the_deviation_that_the_configuration_says():
    exact, sensors = truth(), Sensors(CONFIG, seed=2)
    force = np.array([sensors.wrenches(exact).force for _ in range(COUNT)])
    effort = np.array([sensors.joints(exact).effort for _ in range(COUNT)])
    odometry = [sensors.odometry(exact) for _ in range(COUNT)]
    velocity = np.array([sample.velocity for sample in odometry])
    position = np.array([sample.position for sample in odometry])
    # The deviation of a deviation from 4000 draws is about 1 %.
    np.testing.assert_allclose(force.std(axis=0)[0], [1.3, 1.0, 1.9], rtol=0.06)
    np.testing.assert_allclose(effort.std(axis=0), 0.2, rtol=0.06)
    np.testing.assert_allclose(velocity.std(axis=0), [0.029, 0.02, 0.02], rtol=0.06)
    np.testing.assert_allclose(position.std(axis=0), [0.005, 0.005, 0.001], rtol=0.06)
    np.testing.assert_allclose(position[:, :2].mean(axis=0), [1.0, 2.0], atol=5e-4)


def test_height_and_tilt_carry_a_constant_error_of_their_own_in_each_run():
    exact = truth()
    heights, tilts = [], []
    for seed in range(150):
        sensors = Sensors(CONFIG, seed)
        heights.append(np.mean([sensors.odometry(exact).position[2] for _ in range(40)]) - 0.14)
        tilts.append(2.0 * np.mean([sensors.imu(exact).quaternion[0] for _ in range(40)]))
    assert np.std(heights) == pytest.approx(CONFIG.height_bias, rel=0.25)
    assert np.std(tilts) == pytest.approx(CONFIG.attitude_bias, rel=0.25)


def test_attitudes_stay_unit_quaternions():
    sensors = Sensors(SimulatorConfiguration(noise_scale=10.0), seed=3)
    norms = [np.linalg.norm(sensors.imu(truth()).quaternion) for _ in range(50)]
    np.testing.assert_allclose(norms, 1.0)


def test_the_same_seed_gives_the_same_noise_and_sensors_do_not_share_a_stream():
    exact = truth()
    one, other = Sensors(CONFIG, seed=4), Sensors(CONFIG, seed=4)
    for _ in range(10):
        other.imu(exact)
    np.testing.assert_array_equal(one.joints(exact).position, other.joints(exact).position)
    np.testing.assert_array_equal(one.odometry(exact).position, other.odometry(exact).position)
    different = Sensors(CONFIG, seed=5)
    assert (different.joints(exact).position != one.joints(exact).position).all()
