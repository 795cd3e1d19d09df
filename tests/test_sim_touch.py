# SPDX-License-Identifier: Apache-2.0
"""Laws of contact sensing, on a robot that walks over ground of known strength."""

import math
from dataclasses import replace

import numpy as np
import pytest

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.strength import StrengthEstimate, estimate_strength
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.terrains.terrain import Terrain
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.contact_sensing import ContactSensor, Dropped
from psane_sim.touch.sensing import Sensors


def walk(strength, seconds, command, *, noise=1.0, seed=1, odometry_until=math.inf):
    """Return the contacts of a walk and the sensor that felt them."""
    config = SimulatorConfiguration(noise_scale=noise)
    contacts = []
    with HexapodSimulator(config, Terrain.uniform(strength), (5.0, 5.0, 0.3)) as simulator:
        sensors = Sensors(config, seed)
        touch = ContactSensor(TouchConfiguration(), simulator.robot)
        simulator.command(*command)
        for tick in range(round(seconds * 200)):
            simulator.step(5)
            truth = simulator.truth()
            if tick % 4 == 0 and truth.time < odometry_until:
                touch.set_odometry(sensors.odometry(truth))
            feet = truth.foot[:, :2].copy()
            for contact in touch.update(sensors.joints(truth), sensors.wrenches(truth),
                                        sensors.imu(truth)):
                contacts.append((contact, feet[contact.leg]))
    return contacts, touch


@pytest.fixture(scope='module')
def contacts():
    return walk(0.1, 8.0, (0.2, 0.0))[0]


@pytest.mark.parametrize('strength', [0.06, 0.12, 0.4])
def test_the_strength_that_is_felt_is_the_strength_of_the_ground(strength):
    # 0.25 is three times the log-RMSE of such a walk at this height bias: not a tight bound, but
    # a sign error, a wrong channel or a wrong frame is off by far more.
    found = [estimate_strength(contact, MappingConfiguration())
             for contact, _ in walk(strength, 5.0, (0.2, 0.0))[0]]
    errors = [math.log(e.strength / strength) for e in found if isinstance(e, StrengthEstimate)]
    assert len(errors) >= 8
    assert math.sqrt(np.mean(np.square(errors))) < 0.25


def test_without_noise_the_estimate_is_within_two_percent():
    found = [estimate_strength(contact, MappingConfiguration())
             for contact, _ in walk(0.1, 5.0, (0.2, 0.0), noise=0.0)[0]]
    errors = [math.log(e.strength / 0.1) for e in found if isinstance(e, StrengthEstimate)]
    assert abs(np.median(errors)) < 0.02


def test_a_contact_is_where_the_foot_felt_it_and_not_at_the_hip_or_body(contacts):
    away = [np.hypot(*(contact.point - foot)) for contact, foot in contacts]
    # The foot that just left the ground is at most a stride's slip and a leg's reach away.
    assert np.median(away) < 0.15


def test_every_leg_is_felt_once_or_twice_a_stride(contacts):
    counts = np.bincount([contact.leg for contact, _ in contacts], minlength=6)
    strides = 8.0 * SimulatorConfiguration().stride_frequency
    assert (counts >= strides - 2.0).all()
    # A rear leg may unload in the middle of its stance, and is then felt twice.
    assert (counts <= 2.0 * strides + 2.0).all()


def test_stances_do_not_overlap_in_time(contacts):
    for leg in range(6):
        own = [contact for contact, _ in contacts if contact.leg == leg]
        for before, after in zip(own[:-1], own[1:], strict=True):
            assert before.touch_down < before.lift_off < after.touch_down


def test_a_standing_robot_feels_nothing():
    assert not walk(0.3, 4.0, (0.0, 0.0))[0]


def test_without_odometry_no_contact_is_reported_and_the_loss_is_counted():
    contacts, touch = walk(0.3, 4.0, (0.2, 0.0), odometry_until=1.0)
    assert all(contact.lift_off < 1.6 for contact, _ in contacts)
    assert touch.dropped[Dropped.NO_ODOMETRY] > 0


def test_an_instant_that_comes_twice_changes_nothing():
    config = SimulatorConfiguration()
    with HexapodSimulator(config, Terrain.uniform(0.3)) as simulator:
        sensors = Sensors(config, 0)
        touch = ContactSensor(TouchConfiguration(), simulator.robot)
        truth = simulator.truth()
        touch.set_odometry(sensors.odometry(truth))
        sample = sensors.joints(truth), sensors.wrenches(truth), sensors.imu(truth)
        for _ in range(3):
            assert touch.update(*sample) == []


def test_the_lift_off_force_may_not_exceed_that_of_touch_down():
    with pytest.raises(ValueError, match='lift_off_force'):
        replace(TouchConfiguration(), lift_off_force=10.0)
