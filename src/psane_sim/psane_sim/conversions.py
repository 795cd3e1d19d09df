# SPDX-License-Identifier: Apache-2.0
"""Between ROS messages and the samples of the robot's sensors."""

import numpy as np
from geometry_msgs.msg import Quaternion, Twist, Vector3, Wrench
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState

from psane_mapping.conversions import header, require_finite, require_frame, seconds, yaw_of
from psane_mapping.errors import MessageError
from psane_mapping.grid import FloatArray
from psane_mapping.leg import LEG_NAMES
from psane_msgs.msg import HipWrenches
from psane_sim.touch.sensing import ImuSample, JointSample, OdometrySample, WrenchSample

HIP_NAMES = [f'{name}_hip' for name in LEG_NAMES]
"""Names of the joints, in the order of every array of six."""


def _vector(values: FloatArray) -> Vector3:
    return Vector3(x=float(values[0]), y=float(values[1]), z=float(values[2]))


def _quaternion(values: FloatArray) -> Quaternion:
    x, y, z, w = (float(value) for value in values)
    return Quaternion(x=x, y=y, z=z, w=w)


def _array(name: str, *values: float) -> FloatArray:
    require_finite(name, *values)
    return np.array(values)


def _attitude(orientation: Quaternion) -> FloatArray:
    yaw_of(orientation)
    return np.array([orientation.x, orientation.y, orientation.z, orientation.w])


def joint_message(sample: JointSample, frame: str) -> JointState:
    """Return the six hips as a JointState."""
    return JointState(header=header(sample.time, frame), name=HIP_NAMES,
                      position=sample.position.tolist(), velocity=sample.velocity.tolist(),
                      effort=sample.effort.tolist())


def joints_of(message: JointState) -> JointSample:
    """Return the six hips of a JointState, whatever the order of its names.

    Raises
    ------
    MessageError
        When a hip is missing, or an array has another size than the names.
    """
    missing = [name for name in HIP_NAMES if name not in message.name]
    if missing:
        raise MessageError(f'joint_states lacks {missing}; it has {list(message.name)}')
    order = [list(message.name).index(name) for name in HIP_NAMES]
    columns = {}
    for name in ('position', 'velocity', 'effort'):
        values = getattr(message, name)
        if len(values) != len(message.name):
            raise MessageError(f'joint_states has {len(values)} values of {name}, expected '
                               f'{len(message.name)}, one for each name')
        columns[name] = _array(name, *(values[index] for index in order))
    return JointSample(seconds(message.header.stamp), **columns)


def wrench_message(sample: WrenchSample, frame: str) -> HipWrenches:
    """Return the reactions of the six hips, in the frame of the base."""
    wrenches = [Wrench(force=_vector(force), torque=_vector(moment))
                for force, moment in zip(sample.force, sample.moment, strict=True)]
    return HipWrenches(header=header(sample.time, frame), wrenches=wrenches)


def wrenches_of(message: HipWrenches, frame: str) -> WrenchSample:
    """Return the reactions of the six hips."""
    require_frame(message.header, frame)
    force = [_array('force', w.force.x, w.force.y, w.force.z) for w in message.wrenches]
    moment = [_array('torque', w.torque.x, w.torque.y, w.torque.z) for w in message.wrenches]
    return WrenchSample(seconds(message.header.stamp), np.array(force), np.array(moment))


def imu_message(sample: ImuSample, frame: str) -> Imu:
    """Return attitude, angular velocity and specific force."""
    return Imu(header=header(sample.time, frame), orientation=_quaternion(sample.quaternion),
               angular_velocity=_vector(sample.angular_velocity),
               linear_acceleration=_vector(sample.specific_force))


def imu_of(message: Imu) -> ImuSample:
    """Return attitude, angular velocity and specific force."""
    rate, force = message.angular_velocity, message.linear_acceleration
    return ImuSample(seconds(message.header.stamp), _attitude(message.orientation),
                     _array('angular_velocity', rate.x, rate.y, rate.z),
                     _array('linear_acceleration', force.x, force.y, force.z))


def odometry_message(sample: OdometrySample, frame: str, base_frame: str) -> Odometry:
    """Return the odometry: pose in `frame`, twist in `base_frame`."""
    message = Odometry(header=header(sample.time, frame), child_frame_id=base_frame)
    position = message.pose.pose.position
    position.x, position.y, position.z = (float(value) for value in sample.position)
    message.pose.pose.orientation = _quaternion(sample.quaternion)
    message.twist.twist = Twist(linear=_vector(sample.velocity),
                                angular=_vector(sample.angular_velocity))
    return message


def odometry_of(message: Odometry, frame: str) -> OdometrySample:
    """Return the odometry of a message."""
    require_frame(message.header, frame)
    position = message.pose.pose.position
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    return OdometrySample(
        seconds(message.header.stamp), _array('position', position.x, position.y, position.z),
        _attitude(message.pose.pose.orientation),
        _array('linear', linear.x, linear.y, linear.z),
        _array('angular', angular.x, angular.y, angular.z))


def velocity_of(message: Twist) -> tuple[float, float]:
    """Return forward speed [m/s] and yaw rate [rad/s] of a command."""
    require_finite('cmd_vel', message.linear.x, message.angular.z)
    return float(message.linear.x), float(message.angular.z)
