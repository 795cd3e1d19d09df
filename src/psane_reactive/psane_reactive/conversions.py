# SPDX-License-Identifier: Apache-2.0
"""Between ROS messages and what the steering core works with."""

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from shapely.geometry import MultiPolygon, Polygon

from psane_mapping.conversions import pose_of, require_finite, require_frame
from psane_mapping.errors import MessageError
from psane_mapping.grid import FloatArray
from psane_msgs.msg import Ring, SafeRegion
from psane_reactive.balance import Tilt
from psane_reactive.command import Command, Mode

TROUBLES = (Mode.STOPPED, Mode.STUCK)
"""What somebody should look at."""

LARGEST_RING = 100_000
"""Most corners that a ring may have; more is a mistake of the sender."""


def region_of(message: SafeRegion, frame: str) -> MultiPolygon | None:
    """Return the region of a message; None when it is empty.

    Raises
    ------
    MessageError
        For another frame, a ring of fewer than three points, or numbers that are not finite.
    """
    require_frame(message.header, frame)
    polygons = [Polygon(_corners(polygon.outer), [_corners(hole) for hole in polygon.holes])
                for polygon in message.polygons]
    return MultiPolygon(polygons) if polygons else None


def _corners(ring: Ring) -> FloatArray:
    if not 3 <= len(ring.points) <= LARGEST_RING:
        raise MessageError(f'a ring has {len(ring.points)} points, expected 3 to {LARGEST_RING}')
    corners = np.array([(point.x, point.y) for point in ring.points])
    if not np.isfinite(corners).all():
        raise MessageError('a ring holds a number that is not finite')
    return corners


def motion_of(message: Odometry,
              frame: str) -> tuple[tuple[float, float, float], tuple[float, float], float]:
    """Return pose (x, y, yaw), velocity (linear, angular) and time [s] of an odometry message."""
    pose, time = pose_of(message, frame)
    linear, angular = message.twist.twist.linear.x, message.twist.twist.angular.z
    require_finite('twist', linear, angular)
    return (float(pose[0]), float(pose[1]), float(pose[2])), (linear, angular), time


def tilt_of(message: Odometry) -> Tilt:
    """Return how the body leans by an odometry message."""
    attitude = message.pose.pose.orientation
    return Tilt.of_quaternion(attitude.x, attitude.y, attitude.z, attitude.w)


def twist_of(command: Command) -> Twist:
    """Return the velocity of a command."""
    message = Twist()
    message.linear.x = float(command.linear)
    message.linear.y = float(command.lateral)
    message.angular.z = float(command.angular)
    return message


def steering_status_of(command: Command, subgoal: FloatArray | None,
                       name: str) -> DiagnosticStatus:
    """Return what the steering does, why, and where it was sent, (2,) [m]."""
    values = {'mode': command.mode.value}
    if subgoal is not None:
        values |= {'subgoal_x': f'{subgoal[0]:.4f}', 'subgoal_y': f'{subgoal[1]:.4f}'}
    return DiagnosticStatus(
        level=DiagnosticStatus.WARN if command.mode in TROUBLES else DiagnosticStatus.OK,
        name=name, message=f'{command.mode.value}: {command.reason}', hardware_id='psane',
        values=[KeyValue(key=key, value=value) for key, value in values.items()])
