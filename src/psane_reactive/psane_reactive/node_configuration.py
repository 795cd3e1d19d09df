# SPDX-License-Identifier: Apache-2.0
"""What the controller's node needs to know beside how to steer."""

from dataclasses import dataclass

from psane_mapping.parameters import Configuration, parameter


@dataclass(frozen=True, kw_only=True)
class ReactiveNodeConfiguration(Configuration):
    """Frames of the node `reactive_controller`, where maps are built, the form of commands."""

    odom_frame: str = parameter(
        'odom', 'frame that odometry must be in; its poses are taken as poses in the map frame '
        '(set it to the map frame for a localiser)', read_only=True)
    base_frame: str = parameter('base_link', 'frame of the commands', read_only=True)
    build_beside: bool = parameter(
        True, 'build the map of a new region beside the control loop; false builds it within the '
        'command that first needs it, so that the same inputs give the same commands',
        read_only=True)
    enable_stamped_cmd_vel: bool = parameter(
        False, 'publish TwistStamped instead of Twist, as Nav2 does', read_only=True)
