# SPDX-License-Identifier: Apache-2.0
"""What would be heard of the simulated hexapod on its topics while it walks a curve."""

from dataclasses import replace

import numpy as np

from psane_mapping.leg import RobotModel
from psane_sim.check.topic_check import EXPECTATIONS
from psane_sim.check.topic_record import Endpoint, Recording, TopicRecord
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.terrains.terrain import Terrain
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.contact_sensing import ContactSensor
from psane_sim.touch.sensing import Sensors

DURATION = 4.0
FRAMES = {'odom': 'odom', 'joint_states': 'base_link', 'hip_wrenches': 'base_link',
          'imu': 'base_link', 'leg_contacts': 'map'}


def walk():
    """Return the sensors' samples and the contacts of a walk, by topic."""
    configuration = SimulatorConfiguration()
    simulator = HexapodSimulator(configuration, Terrain.uniform(0.6), (5.0, 5.0, 1.0))
    sensors, touch = Sensors(configuration, 3), ContactSensor(TouchConfiguration(), RobotModel())
    heard = {name: [] for name in EXPECTATIONS}
    for tick in range(0, round(1000 * DURATION), 5):
        simulator.command(0.2, 0.25)
        simulator.step(5)
        truth = simulator.truth()
        if tick % 20 == 0:
            heard['odom'].append(sensors.odometry(truth))
            touch.set_odometry(heard['odom'][-1])
        instant = sensors.joints(truth), sensors.wrenches(truth), sensors.imu(truth)
        for name, sample in zip(('joint_states', 'hip_wrenches', 'imu'), instant, strict=True):
            heard[name].append(sample)
        heard['leg_contacts'] += touch.update(*instant)
    simulator.close()
    return heard


def record_of(name, samples):
    """Return the record of a topic whose messages come without delay."""
    is_contact = name == 'leg_contacts'
    stamp = np.array([sample.lift_off if is_contact else sample.time for sample in samples])
    columns = {} if is_contact else {
        key: np.array([getattr(sample, key) for sample in samples])
        for key in vars(samples[0]) if key != 'time'}
    return TopicRecord(
        publishers=(Endpoint(node='robot', kind=EXPECTATIONS[name].kind),), arrival=stamp,
        stamp=stamp, age=np.full(stamp.size, 0.01), frames=frozenset({FRAMES[name]}),
        child_frames=frozenset({'base_link'} if name == 'odom' else ()),
        columns=columns, contacts=tuple(samples) if is_contact else ())


def good_recording():
    """Return a recording in which all is well."""
    topics = {name: record_of(name, samples) for name, samples in walk().items()}
    topics['cmd_vel'] = TopicRecord(
        subscribers=(Endpoint(node='robot', kind='geometry_msgs/msg/Twist'),))
    tick = np.arange(0.005, DURATION, 0.005)
    clock = TopicRecord(publishers=(Endpoint(node='robot', kind='rosgraph_msgs/msg/Clock'),),
                        arrival=tick, stamp=tick)
    return Recording(duration=DURATION, clock=clock, topics=topics)


def with_topic(recording, name, **changes):
    """Return a recording in which a topic's record is another."""
    changed = replace(recording.topic(name), **changes)
    return replace(recording, topics={**recording.topics, name: changed})


def with_column(recording, name, column, change):
    """Return a recording in which one column of a topic went through a function."""
    columns = dict(recording.topic(name).columns)
    columns[column] = change(columns[column].copy())
    return with_topic(recording, name, columns=columns)


def with_contacts(recording, **changes):
    """Return a recording in which fields of every contact went through functions."""
    contacts = [replace(contact, **{key: change(getattr(contact, key))
                                    for key, change in changes.items()})
                for contact in recording.topic('leg_contacts').contacts]
    return with_topic(recording, 'leg_contacts', contacts=tuple(contacts))
