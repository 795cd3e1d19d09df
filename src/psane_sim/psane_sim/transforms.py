# SPDX-License-Identifier: Apache-2.0
"""Publishes map -> odom -> base_link on /tf, where tf2_msgs is installed."""

from geometry_msgs.msg import Transform, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from rclpy.node import Node

from psane_mapping.conversions import quaternion_of
from psane_mapping.quality_of_service import DEFAULT

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # The wheels of ROS 2 on PyPI do not bring it; RViz users have it from apt.
    TFMessage = None


class TransformPublisher:
    """Publishes the transforms of each odometry message; does nothing without tf2_msgs.

    Parameters
    ----------
    node : Node
    map_frame : str
        Fixed frame; the same as that of odometry, since nothing in the simulation drifts.
    """

    def __init__(self, node: Node, map_frame: str) -> None:
        self._map_frame = map_frame
        self._publisher = (None if TFMessage is None
                           else node.create_publisher(TFMessage, '/tf', DEFAULT))

    def publish(self, odometry: Odometry) -> None:
        """Publish where the odometry frame and the base are."""
        if self._publisher is not None:
            self._publisher.publish(TFMessage(transforms=transforms_of(odometry,
                                                                       self._map_frame)))


def transforms_of(odometry: Odometry, map_frame: str) -> list[TransformStamped]:
    """Return map -> odom (the identity) and odom -> base of an odometry message."""
    position, orientation = odometry.pose.pose.position, odometry.pose.pose.orientation
    fixed = TransformStamped(child_frame_id=odometry.header.frame_id,
                             transform=Transform(rotation=quaternion_of(0.0)))
    fixed.header.stamp, fixed.header.frame_id = odometry.header.stamp, map_frame
    moving = TransformStamped(
        header=odometry.header, child_frame_id=odometry.child_frame_id,
        transform=Transform(translation=Vector3(x=position.x, y=position.y, z=position.z),
                            rotation=orientation))
    return [fixed, moving]
