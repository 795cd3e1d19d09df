# SPDX-License-Identifier: Apache-2.0
"""The check of a robot's topics on a real graph: a good robot, and one with everything wrong."""

import time

import numpy as np
from felt_stances import stance
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from node_process import PATIENCE
from sensor_msgs.msg import Imu, JointState

from psane_mapping.conversions import contact_message
from psane_mapping.quality_of_service import COMMANDS, DEFAULT, ODOMETRY, ODOMETRY_INPUT, SENSORS
from psane_msgs.msg import LegContact
from psane_sim.conversions import HIP_NAMES, imu_message, joint_message, odometry_message
from psane_sim.touch.sensing import ImuSample, JointSample, OdometrySample

LISTENING = 5.0
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def finish(process, probe, every):
    """Go on until the check has ended; return its exit status and what it printed."""
    end = time.monotonic() + PATIENCE
    while process.is_running and time.monotonic() < end:
        every()
        probe.spin(0.015)
    return process.wait(), process.output


def test_the_walking_simulator_passes_the_check(probe, start_node):
    probe.listen(Odometry, 'odom', ODOMETRY_INPUT)
    probe.speak(Twist, 'cmd_vel', COMMANDS)
    start_node('psane_sim', 'hexapod_sim', '--ros-args', '-p', 'terrain:=env1')
    probe.until(lambda: probe.heard['odom'] and probe.is_heard_on('cmd_vel'))
    command = Twist()
    command.linear.x, command.angular.z = 0.2, 0.15

    def walk():
        probe.publish('cmd_vel', command)
    for _ in range(20):
        walk()
        probe.spin(0.05)
    check = start_node('psane_sim', 'check', '--duration', str(LISTENING))
    status, said = finish(check, probe, walk)
    assert status == 0, said
    assert said.rstrip().endswith('all is well')
    for topic in ('odom', 'joint_states', 'hip_wrenches', 'imu', 'cmd_vel'):
        assert f'ok    {topic}' in said


def bad_robot(probe):
    """Prepare a robot that gets everything wrong; return what publishes its next messages."""
    probe.speak(Odometry, 'odom', ODOMETRY)
    probe.speak(JointState, 'joint_states', SENSORS)
    probe.speak(Imu, 'imu', SENSORS)
    probe.speak(LegContact, 'leg_contacts', SENSORS)
    probe.listen(TwistStamped, 'cmd_vel', DEFAULT)

    def publish():
        now = time.time()
        odom = OdometrySample(now - 3.0, np.array([5.0, 5.0, 145.0]), LEVEL, np.zeros(3),
                              np.zeros(3))
        probe.publish('odom', odometry_message(odom, 'world', 'base_link'))
        joints = joint_message(JointSample(now, np.zeros(6), np.zeros(6), np.zeros(6)),
                               'base_link')
        joints.name = HIP_NAMES[1:] + ['tail']
        probe.publish('joint_states', joints)
        imu = ImuSample(now, LEVEL, np.array([0.0, np.nan, 0.0]), np.zeros(3))
        probe.publish('imu', imu_message(imu, 'imu_link'))
        contact = stance(point=(5000.0, 5000.0), time=now)
        probe.publish('leg_contacts', contact_message(contact, 'map'))
    return publish


def test_each_fault_of_a_bad_robot_is_named_and_the_status_says_so(probe, start_node):
    publish = bad_robot(probe)
    check = start_node('psane_sim', 'check', '--duration', str(LISTENING))
    status, said = finish(check, probe, publish)
    assert status == 1, said
    for sentence in ("frame_id is 'world', expected 'odom'", "behind the graph's time",
                     'z = 145 m', "lacks ['left_front_hip']", 'expected finite numbers',
                     "frame_id is 'imu_link', expected 'base_link'", 'from the body',
                     'publishes it best effort', 'listens for geometry_msgs/msg/TwistStamped'):
        assert sentence in said, f'{sentence!r} is not in:\n{said}'
    assert 'FAULT hip_wrenches' in said
    assert 'missing' in said


def test_the_check_follows_a_robot_into_its_namespace(probe, start_node):
    probe.speak(Odometry, '/spirit/odom', ODOMETRY)

    def publish():
        sample = OdometrySample(time.time(), np.array([5.0, 5.0, 0.15]), LEVEL, np.zeros(3),
                                np.zeros(3))
        probe.publish('/spirit/odom', odometry_message(sample, 'odom', 'base_link'))
    check = start_node('psane_sim', 'check', '--duration', '10', '--profile', 'contacts',
                       '--ros-args', '-r', '__ns:=/spirit')
    status, said = finish(check, probe, publish)
    assert status == 1
    assert 'ok    odom' in said, said
    assert 'FAULT leg_contacts' in said
