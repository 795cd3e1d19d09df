# SPDX-License-Identifier: Apache-2.0
"""Messages say what the core said: there and back again loses nothing."""

import math

import numpy as np
import pytest
from felt_stances import stance
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import OccupancyGrid
from rclpy.serialization import deserialize_message, serialize_message
from shapely.geometry import MultiPolygon, Polygon

from psane_mapping import conversions
from psane_mapping.errors import MessageError
from psane_mapping.grid import Grid
from psane_planner.conversions import region_message
from psane_reactive.conversions import region_of
from psane_sim import conversions as sim_conversions
from psane_sim.touch.sensing import ImuSample, JointSample, OdometrySample, WrenchSample


def sent(message):
    """Return a message as it comes out at the other end."""
    return deserialize_message(serialize_message(message), type(message))


def same(first, second, names):
    for name in names:
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


@given(st.integers(0, 2**31 - 1), st.integers(0, 10**9 - 1))
def test_a_stamp_comes_back_to_the_microsecond(seconds, nanoseconds):
    time = seconds + 1e-9 * nanoseconds
    assert conversions.seconds(conversions.stamp(time)) == pytest.approx(time, abs=1e-6)


@given(st.floats(-3.1, 3.1))
def test_a_heading_comes_back(yaw):
    assert conversions.yaw_of(conversions.quaternion_of(yaw)) == pytest.approx(yaw)


def test_a_contact_comes_back_to_the_last_bit():
    contact = stance(seed=4, point=(1.25, 7.5))
    back = conversions.contact_of(sent(conversions.contact_message(contact, 'map')), 'map')
    same(contact, back, ('point', 'depth', 'measured', 'response', 'deviation'))
    assert (back.leg, back.has_velocity) == (contact.leg, contact.has_velocity)
    assert back.lift_off == pytest.approx(contact.lift_off, abs=1e-9)


def test_a_map_comes_back_with_its_grid():
    grid = Grid(origin_x=-0.05, origin_y=1.0, resolution=0.1, rows=30, columns=20)
    cells = np.arange(-1, 599).reshape(grid.shape).clip(-1, 100).astype(np.int8)
    message = sent(conversions.occupancy_message(grid, cells, 12.5, 'map'))
    found, back = conversions.cells_of(message, 'map')
    assert found == grid
    np.testing.assert_array_equal(back, cells)


@pytest.mark.parametrize('spoil', ['frame', 'size', 'rotation', 'resolution'])
def test_a_map_that_makes_no_sense_is_refused(spoil):
    grid = Grid.over_workspace(0.0, 0.0, 1.0, 1.0, 0.1)
    message = conversions.occupancy_message(grid, np.zeros(grid.shape, np.int8), 0.0, 'map')
    if spoil == 'frame':
        message.header.frame_id = 'odom'
    elif spoil == 'size':
        message.info.width += 1
    elif spoil == 'rotation':
        message.info.origin.orientation = conversions.quaternion_of(0.3)
    else:
        message.info.resolution = math.nan
    with pytest.raises(MessageError):
        conversions.cells_of(message, 'map')


def test_an_empty_map_is_refused():
    with pytest.raises(MessageError):
        message = OccupancyGrid()
        message.header.frame_id = 'map'
        message.info.origin.orientation.w = 1.0
        conversions.cells_of(message, 'map')


def test_a_region_with_holes_comes_back():
    first = Polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (1, 2), (2, 2), (2, 1)]])
    region = MultiPolygon([first, Polygon([(6, 6), (7, 6), (6, 7)])])
    back = region_of(sent(region_message(region, 0.15, 7, 1.0, 'map')), 'map')
    assert back.equals(region)


def test_the_outer_ring_of_a_region_runs_anticlockwise_whatever_it_was():
    clockwise = Polygon([(0, 0), (0, 1), (1, 1), (1, 0)])
    message = region_message(clockwise, 0.15, 1, 0.0, 'map')
    ring = Polygon([(point.x, point.y) for point in message.polygons[0].outer.points])
    assert ring.exterior.is_ccw


def test_no_region_comes_back_as_none():
    assert region_of(sent(region_message(None, 0.15, 1, 0.0, 'map')), 'map') is None


def test_sensor_samples_come_back():
    random = np.random.default_rng(0)
    joints = JointSample(1.5, *random.normal(size=(3, 6)))
    same(joints, sim_conversions.joints_of(
        sent(sim_conversions.joint_message(joints, 'base_link'))),
        ('position', 'velocity', 'effort'))
    wrenches = WrenchSample(1.5, *random.normal(size=(2, 6, 3)))
    same(wrenches, sim_conversions.wrenches_of(
        sent(sim_conversions.wrench_message(wrenches, 'base_link')), 'base_link'),
        ('force', 'moment'))
    level = np.array([0.0, 0.0, 0.6, 0.8])
    imu = ImuSample(1.5, level, *random.normal(size=(2, 3)))
    same(imu, sim_conversions.imu_of(sent(sim_conversions.imu_message(imu, 'base_link'))),
         ('quaternion', 'angular_velocity', 'specific_force'))
    odometry = OdometrySample(1.5, random.normal(size=3), level, *random.normal(size=(2, 3)))
    same(odometry, sim_conversions.odometry_of(
        sent(sim_conversions.odometry_message(odometry, 'odom', 'base_link')), 'odom'),
        ('position', 'quaternion', 'velocity', 'angular_velocity'))


def test_joints_are_found_by_name_in_any_order():
    sample = JointSample(0.0, np.arange(6.0), np.arange(6.0) + 10.0, np.arange(6.0) + 20.0)
    message = sim_conversions.joint_message(sample, 'base_link')
    for name in ('name', 'position', 'velocity', 'effort'):
        setattr(message, name, list(getattr(message, name))[::-1])
    same(sample, sim_conversions.joints_of(message), ('position', 'velocity', 'effort'))


def test_a_missing_joint_is_named():
    message = sim_conversions.joint_message(JointSample(0.0, *np.zeros((3, 6))), 'base_link')
    message.name = ['other', *list(message.name)[1:]]
    with pytest.raises(MessageError, match='left_front_hip'):
        sim_conversions.joints_of(message)
