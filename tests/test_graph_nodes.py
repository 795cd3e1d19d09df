# SPDX-License-Identifier: Apache-2.0
"""Each node alone on a real graph, against a scripted publisher."""

import math
import time

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from felt_stances import stance
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import OccupancyGrid, Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from shapely.geometry import Point, Polygon

from psane_mapping import conversions
from psane_mapping.configuration import MappingConfiguration
from psane_mapping.grid import Grid
from psane_mapping.map_cells import MapSteps, cells_of_maps
from psane_mapping.mapper import TerrainMapper, TerrainSample
from psane_mapping.quality_of_service import (
    COMMANDS,
    CONTACTS,
    DEFAULT,
    LATCHED,
    ODOMETRY,
    ODOMETRY_INPUT,
    SENSORS,
)
from psane_msgs.msg import HipWrenches, LegContact, MapScale, PlannerStatus, SafeRegion
from psane_msgs.msg import TerrainSample as TerrainSampleMessage
from psane_planner.conversions import CERTIFIED, region_message
from psane_reactive.conversions import region_of
from psane_sim import conversions as sim_conversions
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.terrains.terrain import Terrain
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.contact_sensing import ContactSensor
from psane_sim.touch.sensing import OdometrySample, Sensors

GRID = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1)


def now():
    return time.time()


def odometry(x, y, yaw=0.0, stamp=None):
    sample = OdometrySample(now() if stamp is None else stamp, np.array([x, y, 0.1]),
                            np.array([0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)]),
                            np.zeros(3), np.zeros(3))
    return sim_conversions.odometry_message(sample, 'odom', 'base_link')


# --- hexapod_sim

@pytest.fixture
def simulator(probe, start_node):
    for kind, topic, quality in ((Clock, '/clock', DEFAULT), (Odometry, 'odom', ODOMETRY_INPUT),
                                 (JointState, 'joint_states', SENSORS),
                                 (HipWrenches, 'hip_wrenches', SENSORS), (Imu, 'imu', SENSORS)):
        probe.listen(kind, topic, quality)
    probe.speak(Twist, 'cmd_vel', COMMANDS)
    process = start_node('psane_sim', 'hexapod_sim', '--ros-args', '-p', 'terrain:=env1',
                         '-p', 'noise_scale:=0.0')
    probe.until(lambda: probe.heard['odom'] and probe.is_heard_on('cmd_vel'))
    return process


def speed_of(message):
    velocity = message.twist.twist.linear
    return math.hypot(velocity.x, velocity.y)


def drive(linear, angular=0.0):
    message = Twist()
    message.linear.x, message.angular.z = linear, angular
    return message


def simulated(message):
    return conversions.seconds(message.header.stamp)


def test_the_simulator_publishes_its_sensors_in_the_frames_and_rates_of_the_interface(
        simulator, probe):
    probe.until(lambda: len(probe.heard['odom']) > 50 and all(
        len(probe.heard[name]) > 200 for name in ('imu', 'joint_states', 'hip_wrenches')))
    odom, imu, joints = (probe.heard[name] for name in ('odom', 'imu', 'joint_states'))
    assert odom[-1].header.frame_id == 'odom'
    assert odom[-1].child_frame_id == 'base_link'
    assert imu[-1].header.frame_id == 'base_link'
    assert list(joints[-1].name) == sim_conversions.HIP_NAMES
    assert probe.last('hip_wrenches').header.frame_id == 'base_link'
    # Stamps tell the rate, even where late messages were lost: the others are whole periods apart.
    for messages, period in ((odom, 0.02), (imu, 0.005), (joints, 0.005)):
        steps = np.diff([simulated(message) for message in messages]) / period
        assert steps == pytest.approx(np.round(steps), abs=1e-3)
        assert steps.min() == pytest.approx(1.0, abs=1e-3)


def test_no_topic_carries_the_truth(simulator, probe):
    known = {'/clock', '/odom', '/joint_states', '/hip_wrenches', '/imu', '/diagnostics'}

    def published():
        topics = {name for name, _ in probe.node.get_topic_names_and_types()}
        return {name for name in topics if probe.node.count_publishers(name)
                and 'parameter' not in name} - {'/rosout', '/cmd_vel'}
    probe.until(lambda: known <= published())
    probe.spin(1.0)
    assert published() <= {*known, '/tf'}


def test_the_robot_walks_on_command_and_stands_soon_after_the_last_one(simulator, probe):
    begin = probe.last('odom').pose.pose.position
    end = simulated(probe.last('odom')) + 4.0
    while simulated(probe.last('odom')) < end:
        probe.publish('cmd_vel', drive(0.2))
        probe.spin(0.04)
    # It has the last command and has simulated on since, more than one burst.
    probe.until_taken('cmd_vel')
    heard = len(probe.heard['odom'])
    probe.until(lambda: len(probe.heard['odom']) > heard + 12)
    last_command = simulated(probe.last('odom'))
    position = probe.last('odom').pose.pose.position
    assert math.hypot(position.x - begin.x, position.y - begin.y) > 0.2
    probe.until(lambda: simulated(probe.last('odom')) > last_command + 1.5)
    after = [message for message in probe.heard['odom']
             if last_command + 0.5 < simulated(message)]
    assert max(speed_of(message) for message in after) < 0.02


def test_a_command_that_is_not_a_number_is_dropped(simulator, probe):
    probe.publish('cmd_vel', drive(math.nan))
    simulator.wait_for_output('dropped a message on cmd_vel')
    probe.spin(0.5)
    assert speed_of(probe.last('odom')) < 0.02


@pytest.mark.parametrize(('parameter', 'sentence'), [
    ('terrain:=mars2', "unknown terrain 'mars2'; available"),
    ('pace:=-1.0', 'pace = -1.0, expected'),
    ('time_step:=0.5', 'time_step = 0.5 s, expected'),
])
def test_a_bad_parameter_ends_the_simulator_with_a_sentence(start_node, parameter, sentence):
    process = start_node('psane_sim', 'hexapod_sim', '--ros-args', '-p', parameter)
    assert process.wait() == 2
    assert sentence in process.output
    assert 'Traceback' not in process.output


# --- contact_sensor

def test_the_contact_sensor_reports_what_its_core_feels(probe, start_node):
    start_node('psane_sim', 'contact_sensor')
    for kind, topic, quality in ((JointState, 'joint_states', SENSORS), (Imu, 'imu', SENSORS),
                                 (HipWrenches, 'hip_wrenches', SENSORS),
                                 (Odometry, 'odom', ODOMETRY)):
        probe.speak(kind, topic, quality)
    probe.listen(LegContact, 'leg_contacts', CONTACTS)
    probe.until(lambda: all(map(probe.is_heard_on, ('joint_states', 'imu', 'hip_wrenches',
                                                    'odom'))))
    config = SimulatorConfiguration()
    with HexapodSimulator(config, Terrain.uniform(0.1)) as robot:
        sensors, core = Sensors(config, 0), ContactSensor(TouchConfiguration(), robot.robot)
        robot.command(0.2, 0.0)
        expected = []
        for tick in range(500):
            robot.step(5)
            truth = robot.truth()
            if tick % 4 == 0:
                sample = sensors.odometry(truth)
                core.set_odometry(sample)
                probe.publish('odom', sim_conversions.odometry_message(sample, 'odom',
                                                                       'base_link'))
                probe.until_worked_off('contact_sensor')
            joints, wrenches, imu = (sensors.joints(truth), sensors.wrenches(truth),
                                     sensors.imu(truth))
            expected += core.update(joints, wrenches, imu)
            probe.publish('joint_states', sim_conversions.joint_message(joints, 'base_link'))
            probe.publish('hip_wrenches', sim_conversions.wrench_message(wrenches, 'base_link'))
            probe.publish('imu', sim_conversions.imu_message(imu, 'base_link'))
            probe.until_worked_off('contact_sensor')
    probe.until(lambda: len(probe.heard['leg_contacts']) >= len(expected) - 1)
    assert len(expected) >= 6
    got = [conversions.contact_of(message, 'map') for message in probe.heard['leg_contacts']]
    # Sensor topics are best effort: a sample may be lost, and odometry may come one sample late.
    for contact in got:
        twin = min(expected, key=lambda other: abs(other.lift_off - contact.lift_off)
                   + 10.0 * (other.leg != contact.leg))
        assert twin.leg == contact.leg
        assert abs(twin.lift_off - contact.lift_off) < 0.03
        assert np.hypot(*(twin.point - contact.point)) < 0.02


# --- terrain_mapper

@pytest.fixture
def mapper(probe, start_node):
    process = start_node('psane_mapping', 'terrain_mapper')
    probe.speak(LegContact, 'leg_contacts', CONTACTS)
    probe.listen(TerrainSampleMessage, 'terrain_samples', CONTACTS)
    for topic in ('slip/mean', 'slip/std', 'strength/mean', 'strength/std'):
        probe.listen(OccupancyGrid, topic, LATCHED)
    probe.listen(MapScale, 'map_scale', LATCHED)
    probe.until(lambda: probe.heard['slip/mean'] and probe.is_heard_on('leg_contacts'))
    return process


def test_the_mapper_publishes_the_maps_of_its_core(mapper, probe):
    contacts = [stance(strength=strength, point=(x, 5.0))
                for strength, x in ((0.3, 2.0), (0.2, 2.5), (1.0, 4.0))]
    core = TerrainMapper(MappingConfiguration())
    for contact in contacts:
        assert isinstance(core.add(contact), TerrainSample)
        probe.publish('leg_contacts', conversions.contact_message(contact, 'map'))
        probe.spin(0.05)
    probe.until(lambda: len(probe.heard['terrain_samples']) == 3)
    steps = MapSteps.of(MappingConfiguration())
    expected = cells_of_maps(core.maps(), steps)

    def is_current():
        return all(np.array_equal(conversions.cells_of(probe.last(topic), 'map')[1], cells)
                   for topic, cells in expected.items())
    probe.until(is_current)
    assert probe.last('slip/mean').header.stamp == probe.last('slip/std').header.stamp
    assert probe.last('map_scale').std_scale == steps.std_scale


@pytest.mark.parametrize('spoil', ['frame', 'number', 'size'])
def test_a_contact_that_makes_no_sense_is_dropped_with_a_reason(mapper, probe, spoil):
    message = conversions.contact_message(stance(strength=0.3, point=(2.0, 5.0)), 'map')
    if spoil == 'frame':
        message.header.frame_id = 'base_link'
    elif spoil == 'number':
        message.point.x = math.nan
    else:
        message.measured_forward = message.measured_forward[:-1]
    probe.publish('leg_contacts', message)
    mapper.wait_for_output('dropped a message on leg_contacts')
    assert mapper.is_running
    assert not probe.heard['terrain_samples']


def test_who_comes_late_still_gets_the_maps(mapper, probe):
    probe.listen(OccupancyGrid, '/slip/mean', LATCHED)
    probe.until(lambda: probe.heard['/slip/mean'])


# --- safe_planner

@pytest.fixture
def planner(probe, start_node):
    process = start_node('psane_planner', 'safe_planner')
    for topic in ('slip/mean', 'slip/std'):
        probe.speak(OccupancyGrid, topic, LATCHED)
    probe.speak(MapScale, 'map_scale', LATCHED)
    probe.speak(Odometry, 'odom', ODOMETRY)
    probe.speak(PoseStamped, 'goal_pose', DEFAULT)
    probe.listen(PoseStamped, 'subgoal', LATCHED)
    probe.listen(SafeRegion, 'safe_region', LATCHED)
    probe.listen(OccupancyGrid, 'safe_map', LATCHED)
    probe.listen(PlannerStatus, 'planner_status', LATCHED)
    probe.until(lambda: probe.is_heard_on('slip/mean') and probe.is_heard_on('goal_pose'))
    return process


def publish_maps(probe, radius=1.0, frame='map'):
    """Publish a map on which a disc around (3, 3) is known to be firm."""
    away = np.hypot(*(GRID.points - 3.0).T).reshape(GRID.shape)
    std = np.where(away < radius, 4, 100).astype(np.int8)
    stamp = now()
    for topic, cells in (('slip/mean', np.full(GRID.shape, 10, np.int8)), ('slip/std', std)):
        probe.publish(topic, conversions.occupancy_message(GRID, cells, stamp, frame))
    steps = MapSteps.of(MappingConfiguration())
    probe.publish('map_scale', conversions.scale_message(steps, stamp, 'map'))


def state(probe):
    return probe.last('planner_status').state if probe.heard['planner_status'] else None


def test_the_planner_sends_the_robot_towards_its_goal_inside_the_region(planner, probe):
    publish_maps(probe)
    goal = conversions.pose_message(np.array([6.0, 3.0]), 0.0, now(), 'map')
    probe.publish('goal_pose', goal)
    probe.until(lambda: state(probe) == PlannerStatus.SEEKING and all(
        probe.heard[topic] for topic in ('subgoal', 'safe_region', 'safe_map')),
                every=lambda: probe.publish('odom', odometry(3.0, 3.0)))
    region = region_of(probe.last('safe_region'), 'map')
    subgoal = Point(conversions.point_of(probe.last('subgoal'), 'map'))
    assert region.contains(subgoal)
    # Without this the robot could be sent anywhere in the disc.
    assert subgoal.x > 3.2
    _, cells = conversions.cells_of(probe.last('safe_map'), 'map')
    certified = GRID.points[(cells == CERTIFIED).ravel()]
    assert len(certified) > 100
    assert np.hypot(*(certified - 3.0).T).max() < 1.0 + GRID.resolution


def test_without_a_goal_the_planner_waits_and_says_why(planner, probe):
    publish_maps(probe)
    probe.until(lambda: state(probe) == PlannerStatus.WAITING,
                every=lambda: probe.publish('odom', odometry(3.0, 3.0)))
    assert probe.last('planner_status').cause
    assert not probe.last('planner_status').has_subgoal


def test_old_odometry_is_not_planned_from(planner, probe):
    publish_maps(probe)
    probe.publish('goal_pose', conversions.pose_message(np.array([6.0, 3.0]), 0.0, now(), 'map'))
    probe.until(lambda: state(probe) == PlannerStatus.SEEKING,
                every=lambda: probe.publish('odom', odometry(3.0, 3.0)))
    probe.until(lambda: state(probe) == PlannerStatus.WAITING)


@pytest.mark.parametrize('spoil', ['frame', 'number'])
def test_a_goal_that_makes_no_sense_is_dropped(planner, probe, spoil):
    goal = conversions.pose_message(np.array([6.0, 3.0]), 0.0, now(), 'map')
    if spoil == 'frame':
        goal.header.frame_id = 'moon'
    else:
        goal.pose.position.y = math.inf
    probe.publish('goal_pose', goal)
    planner.wait_for_output('dropped a message on goal_pose')
    assert planner.is_running


def test_a_map_in_another_frame_is_dropped(planner, probe):
    publish_maps(probe, frame='odom')
    planner.wait_for_output('dropped a message on slip/mean')


# --- reactive_controller

@pytest.fixture
def controller(probe, start_node):
    process = start_node('psane_reactive', 'reactive_controller')
    probe.speak(SafeRegion, 'safe_region', LATCHED)
    probe.speak(PoseStamped, 'subgoal', LATCHED)
    probe.speak(PlannerStatus, 'planner_status', LATCHED)
    probe.speak(Odometry, 'odom', ODOMETRY)
    probe.listen(Twist, 'cmd_vel', COMMANDS)
    probe.until(lambda: probe.is_heard_on('safe_region') and probe.heard['cmd_vel'])
    return process


def give_task(probe):
    region = Polygon([(1.0, 1.0), (5.0, 1.0), (5.0, 5.0), (1.0, 5.0)])
    probe.publish('safe_region', region_message(region, 0.15, 1, now(), 'map'))
    probe.publish('subgoal', conversions.pose_message(np.array([4.0, 3.0]), 0.0, now(), 'map'))
    tell_that_it_seeks(probe)


def tell_that_it_seeks(probe):
    status = PlannerStatus(state=PlannerStatus.SEEKING, has_subgoal=True)
    status.header = conversions.header(now(), 'map')
    probe.publish('planner_status', status)


def moves(probe):
    return bool(probe.heard['cmd_vel']) and probe.last('cmd_vel').linear.x > 0.1


def test_the_controller_drives_to_the_subgoal_and_stops_when_odometry_ends(controller, probe):
    give_task(probe)

    def go_on():
        tell_that_it_seeks(probe)
        probe.publish('odom', odometry(2.0, 3.0))
    probe.until(lambda: moves(probe), every=go_on)
    probe.until(lambda: probe.last('cmd_vel') == Twist())
    controller.wait_for_output('odometry is')


def test_the_controller_stands_without_a_region(controller, probe):
    for _ in range(20):
        probe.publish('odom', odometry(2.0, 3.0))
        probe.spin(0.05)
    assert all(message == Twist() for message in probe.heard['cmd_vel'])


@pytest.mark.parametrize('spoil', ['frame', 'ring', 'number'])
def test_a_region_that_makes_no_sense_is_dropped(controller, probe, spoil):
    message = region_message(Polygon([(1, 1), (5, 1), (5, 5)]), 0.15, 1, now(), 'map')
    if spoil == 'frame':
        message.header.frame_id = 'odom'
    elif spoil == 'ring':
        del message.polygons[0].outer.points[1:]
    else:
        message.polygons[0].outer.points[1].x = math.nan
    probe.publish('safe_region', message)
    controller.wait_for_output('dropped a message on safe_region')
    assert controller.is_running


def test_a_parameter_is_checked_at_run_time(controller, probe):
    from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
    from rcl_interfaces.srv import SetParameters
    client = probe.node.create_client(SetParameters, '/reactive_controller/set_parameters')
    probe.until(client.service_is_ready)

    def put(value):
        parameter = Parameter(name='linear_limit', value=ParameterValue(
            type=ParameterType.PARAMETER_DOUBLE, double_value=value))
        future = client.call_async(SetParameters.Request(parameters=[parameter]))
        probe.until(future.done)
        return future.result().results[0]
    assert put(0.2).successful
    assert not put(50.0).successful


def test_a_zero_stamp_is_old_odometry(controller, probe):
    give_task(probe)
    message = odometry(2.0, 3.0)
    message.header.stamp = Time()
    for _ in range(10):
        probe.publish('odom', message)
        probe.spin(0.05)
    assert all(heard == Twist() for heard in probe.heard['cmd_vel'])


def test_transforms_lead_from_the_map_to_the_body():
    from psane_sim.transforms import transforms_of
    fixed, moving = transforms_of(odometry(2.0, 3.0, 0.5), 'map')
    assert (fixed.header.frame_id, fixed.child_frame_id) == ('map', 'odom')
    assert (moving.header.frame_id, moving.child_frame_id) == ('odom', 'base_link')
    assert fixed.transform.rotation.w == 1.0
    assert moving.transform.translation.x == 2.0
    assert conversions.yaw_of(moving.transform.rotation) == pytest.approx(0.5)
