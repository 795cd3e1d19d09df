# SPDX-License-Identifier: Apache-2.0
"""The check of a robot's topics finds nothing wrong with a good robot, and each fault of a bad."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heard_robot import good_recording, with_column, with_contacts, with_topic
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_sim.check.command import main, report
from psane_sim.check.settings import CheckSettings
from psane_sim.check.topic_check import EXPECTATIONS, judge
from psane_sim.check.topic_record import Endpoint, Recording, TopicRecord

SETTINGS = CheckSettings()
GOOD = good_recording()
law = settings(deadline=None, derandomize=True, max_examples=25)


def faults(recording, check=SETTINGS):
    return [finding for finding in judge(recording, check) if finding.is_fault]


def said(recording, topic):
    """Return what is wrong, after checking that it is said of the right topic alone."""
    found = faults(recording)
    assert found
    assert {finding.topic for finding in found} == {topic}
    return ' | '.join(finding.sentence for finding in found)


def test_nothing_is_wrong_with_the_simulated_robot():
    assert len(GOOD.topic('leg_contacts').contacts) >= 6
    assert faults(GOOD) == []
    assert report(GOOD, judge(GOOD, SETTINGS), SETTINGS).endswith('all is well')


def test_nothing_is_wrong_with_a_robot_that_publishes_contacts_of_its_own():
    topics = {name: record for name, record in GOOD.topics.items()
              if name in ('odom', 'leg_contacts', 'cmd_vel')}
    assert faults(replace(GOOD, topics=topics)) == []


def test_an_empty_graph_lacks_odometry_contacts_and_somebody_who_obeys():
    empty = Recording(duration=10.0, clock=TopicRecord(), topics={})
    assert {finding.topic for finding in faults(empty)} == {'odom', 'leg_contacts', 'cmd_vel'}


@pytest.mark.parametrize('topic', ['odom', 'joint_states', 'hip_wrenches', 'imu'])
def test_a_topic_that_nobody_publishes_is_missing(topic):
    topics = {name: record for name, record in GOOD.topics.items() if name != topic}
    assert 'missing' in said(replace(GOOD, topics=topics), topic)


@pytest.mark.parametrize('topic', list(EXPECTATIONS))
def test_a_publisher_of_another_type_is_named(topic):
    other = Endpoint(node='stranger', kind='std_msgs/msg/String')
    sentence = said(with_topic(GOOD, topic, publishers=(other,)), topic)
    assert 'stranger' in sentence
    assert EXPECTATIONS[topic].kind in sentence


@pytest.mark.parametrize('topic', ['odom', 'joint_states', 'hip_wrenches', 'imu'])
@pytest.mark.parametrize(('stamps', 'phrase'), [
    (lambda stamp: np.full_like(stamp, 3.0), 'do not advance'),
    (lambda stamp: np.where(np.arange(stamp.size) % 7 == 3, stamp - 0.1, stamp), 'go back'),
])
def test_stamps_that_do_not_run_forward_are_found(topic, stamps, phrase):
    record = GOOD.topic(topic)
    found = faults(with_topic(GOOD, topic, stamp=stamps(record.stamp)))
    assert any(finding.topic == topic and phrase in finding.sentence for finding in found)


@pytest.mark.parametrize('topic', list(EXPECTATIONS))
@pytest.mark.parametrize(('age', 'phrase'), [
    (5.0, 'behind'), (-2.0, 'ahead'), (-1.7e9, 'use_sim_time'),
    (1.7e9, 'nothing publishes /clock'),
])
def test_stamps_far_from_the_time_of_the_graph_are_found(topic, age, phrase):
    record = GOOD.topic(topic)
    assert phrase in said(with_topic(GOOD, topic, age=np.full_like(record.age, age)), topic)


@pytest.mark.parametrize('topic', ['odom', 'joint_states', 'hip_wrenches', 'imu'])
def test_a_rate_just_below_the_lowest_is_found_and_one_just_above_is_not(topic):
    least = EXPECTATIONS[topic].least_rate
    record = GOOD.topic(topic)
    columns = {key: value[:40] for key, value in record.columns.items()}

    def at(rate):
        stamp = np.arange(40) / rate
        arrival = np.linspace(0.0, GOOD.duration, 40)
        # Where the robot moves is not the matter here.
        still = {key: np.repeat(value[:1], 40, axis=0) * ('velocity' not in key)
                 for key, value in columns.items()}
        if 'force' in still:
            still['force'] = np.repeat(record.columns['force'].mean(axis=0)[None], 40, axis=0)
        return with_topic(GOOD, topic, arrival=arrival, stamp=stamp, age=np.zeros(40),
                          columns=still)
    assert 'Hz' in said(at(0.9 * least), topic)
    assert faults(at(1.1 * least)) == []


@pytest.mark.parametrize('topic', ['odom', 'joint_states', 'hip_wrenches', 'imu'])
def test_a_topic_that_stopped_is_stale(topic):
    record = GOOD.topic(topic)
    assert 'stale' in said(with_topic(GOOD, topic, arrival=0.5 * record.arrival), topic)


@pytest.mark.parametrize('topic', ['odom', 'hip_wrenches', 'imu', 'leg_contacts'])
def test_a_wrong_frame_is_named_with_the_right_one(topic):
    sentence = said(with_topic(GOOD, topic, frames=frozenset({'world'})), topic)
    assert "'world'" in sentence
    assert repr({'odom': 'odom', 'leg_contacts': 'map'}.get(topic, 'base_link')) in sentence


def test_a_twist_in_another_frame_than_the_body_is_found():
    assert 'child_frame_id' in said(with_topic(GOOD, 'odom', child_frames=frozenset({'odom'})),
                                    'odom')

    def to_fixed(velocity):
        x, y, z, w = GOOD.topic('odom').columns['quaternion'].T
        yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        turned = velocity.copy()
        turned[:, 0] = np.cos(yaw) * velocity[:, 0] - np.sin(yaw) * velocity[:, 1]
        turned[:, 1] = np.sin(yaw) * velocity[:, 0] + np.cos(yaw) * velocity[:, 1]
        return turned
    assert 'fixed frame' in said(with_column(GOOD, 'odom', 'velocity', to_fixed), 'odom')


def test_messages_that_a_node_would_drop_are_counted_with_their_reason():
    reason = "joint_states lacks ['left_front_hip']"
    sentence = said(with_topic(GOOD, 'joint_states', refused=3, refusal=reason), 'joint_states')
    assert '3 of' in sentence
    assert reason in sentence


def test_contacts_sent_best_effort_would_not_be_heard():
    other = Endpoint(node='robot', kind=EXPECTATIONS['leg_contacts'].kind, is_reliable=False)
    assert 'reliably' in said(with_topic(GOOD, 'leg_contacts', publishers=(other,)),
                              'leg_contacts')


@pytest.mark.parametrize('topic', ['odom', 'imu'])
def test_sensors_sent_best_effort_are_heard(topic):
    other = Endpoint(node='robot', kind=EXPECTATIONS[topic].kind, is_reliable=False)
    assert faults(with_topic(GOOD, topic, publishers=(other,))) == []


@pytest.mark.parametrize(('listener', 'phrase'), [
    ((), 'nobody listens'),
    ((Endpoint(node='base', kind='geometry_msgs/msg/TwistStamped'),), 'TwistStamped'),
    ((Endpoint(node='base', kind='geometry_msgs/msg/Twist', is_latched=True),), 'volatile'),
])
def test_a_robot_that_would_not_obey_is_found(listener, phrase):
    assert phrase in said(with_topic(GOOD, 'cmd_vel', subscribers=listener), 'cmd_vel')


def test_two_publishers_of_one_topic_are_named():
    both = tuple(Endpoint(node=node, kind=EXPECTATIONS['odom'].kind) for node in ('a', 'b'))
    assert 'a, b' in said(with_topic(GOOD, 'odom', publishers=both), 'odom')


def test_a_clock_that_stands_still_is_found():
    still = replace(GOOD.clock, stamp=np.full_like(GOOD.clock.stamp, 2.0))
    assert 'does not advance' in said(replace(GOOD, clock=still), '/clock')


DEGREES = 180.0 / math.pi


@pytest.mark.parametrize(('topic', 'column', 'change', 'phrase'), [
    ('joint_states', 'position', lambda v: DEGREES * v, 'positions in degrees'),
    ('joint_states', 'velocity', lambda v: DEGREES * v, 'velocities in degrees'),
    ('joint_states', 'position', lambda v: -v, 'sign'),
    ('joint_states', 'effort', lambda v: 1e3 * v, 'effort'),
    ('hip_wrenches', 'force', lambda v: v / 9.81, 'kilogrammes-force'),
    ('hip_wrenches', 'force', lambda v: 1e3 * v, 'millinewtons'),
    ('hip_wrenches', 'force', lambda v: -v, 'sign turned round'),
    ('hip_wrenches', 'force', np.zeros_like, 'weight'),
    ('imu', 'specific_force', lambda v: v / 9.81, 'in g'),
    ('imu', 'specific_force', lambda v: -v, 'upright'),
    ('imu', 'specific_force', lambda v: v - (0.0, 0.0, 9.81), 'gravity been taken off'),
    ('imu', 'angular_velocity', lambda v: DEGREES * v, 'degrees'),
    ('imu', 'angular_velocity', lambda v: -v, 'sign'),
    ('imu', 'quaternion', lambda v: np.roll(v, 1, axis=1), 'tilted'),
    ('odom', 'angular_velocity', lambda v: DEGREES * v, 'degrees'),
    ('odom', 'velocity', lambda v: 1e3 * v, 'another unit'),
    ('odom', 'velocity', lambda v: 0.01 * v, 'another unit'),
    ('odom', 'position', lambda v: v - (0.0, 0.0, 0.5), 'z = -0.3'),
    ('odom', 'position', lambda v: v + (0.0, 0.0, 5.0), 'z = 5.'),
])
def test_a_wrong_unit_or_sign_of_a_sensor_is_found(topic, column, change, phrase):
    assert phrase in said(with_column(GOOD, topic, column, change), topic)


@pytest.mark.parametrize(('changes', 'phrase'), [
    ({'depth': lambda d: 1e3 * d}, 'depth of'),
    ({'depth': lambda d: -d}, 'below the surface'),
    ({'measured': lambda f: 1e3 * f}, 'newtons'),
    ({'measured': lambda f: -f}, 'newtons'),
    ({'response': lambda f: 500.0 * f, 'deviation': lambda f: f}, 'strength 1'),
    ({'response': np.zeros_like}, 'none of'),
    ({'point': lambda p: 1e3 * p}, 'from the body'),
    ({'deviation': np.zeros_like}, 'deviation'),
    ({'lift_off': lambda t: t - 0.05}, 'header.stamp'),
    ({'touch_down': lambda t: t + 60.0}, 'after touch_down'),
])
def test_contacts_in_another_unit_or_sign_are_found(changes, phrase):
    assert phrase in said(with_contacts(GOOD, **changes), 'leg_contacts')


@law
@given(factor=st.one_of(st.floats(1e-4, 0.25), st.floats(2.6, 1e4)))
def test_forces_in_any_other_unit_are_found(factor):
    assert 'weight' in said(with_column(GOOD, 'hip_wrenches', 'force', lambda v: factor * v),
                            'hip_wrenches')


@law
@given(mass=st.floats(0.5, 200.0))
def test_forces_are_judged_by_the_robots_own_mass(mass):
    scaled = with_column(GOOD, 'hip_wrenches', 'force', lambda v: v * mass / SETTINGS.mass)
    scaled = replace(scaled, topics={name: record for name, record in scaled.topics.items()
                                     if name != 'leg_contacts'})
    assert faults(scaled, CheckSettings(mass=mass)) == []


def test_a_robot_that_stands_is_well_but_said_to_be_hard_to_judge():
    still = GOOD
    for topic in ('odom', 'joint_states', 'imu'):
        for column in GOOD.topic(topic).columns:
            still = with_column(still, topic, column,
                                lambda v: np.repeat(v[:1], v.shape[0], axis=0))
    for topic, column in (('odom', 'velocity'), ('joint_states', 'velocity'),
                          ('odom', 'angular_velocity'), ('imu', 'angular_velocity')):
        still = with_column(still, topic, column, np.zeros_like)
    assert faults(still) == []
    notes = {finding.topic for finding in judge(still, SETTINGS) if not finding.is_fault}
    assert {'odom', 'joint_states'} <= notes


@pytest.mark.parametrize(('argument', 'sentence'), [
    (['--duration', '0'], 'duration = 0.0 s, expected'),
    (['--mass', '-1'], 'mass = -1.0 kg, expected'),
])
def test_a_bad_argument_is_answered_with_a_sentence(argument, sentence, capsys):
    with pytest.raises(SystemExit) as ended:
        main(argument)
    assert ended.value.code == 2
    assert sentence in capsys.readouterr().err
