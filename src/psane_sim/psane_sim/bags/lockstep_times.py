# SPDX-License-Identifier: Apache-2.0
"""What is told and heard in lockstep, and when each node's time moves on."""

INPUTS = {'/leg_contacts': 'psane_msgs/msg/LegContact', '/odom': 'nav_msgs/msg/Odometry',
          '/goal_pose': 'geometry_msgs/msg/PoseStamped'}
"""Topics that the nodes are told, and their types."""

OUTPUTS = {'/terrain_samples': 'psane_msgs/msg/TerrainSample',
           '/slip/mean': 'nav_msgs/msg/OccupancyGrid', '/slip/std': 'nav_msgs/msg/OccupancyGrid',
           '/safe_region': 'psane_msgs/msg/SafeRegion',
           '/subgoal': 'geometry_msgs/msg/PoseStamped',
           '/planner_status': 'psane_msgs/msg/PlannerStatus',
           '/cmd_vel': 'geometry_msgs/msg/Twist'}
"""Topics that the nodes speak on, and their types."""

EVENTS, EVENT_KIND = '/events', 'std_msgs/msg/String'
"""Topic of what happens to the nodes, such as ``restart terrain_mapper``."""

MILLISECOND = 1_000_000
STEP, PLAN_STEP = 50, 200
"""Time between commands, and odometry messages, and between plans [ms]."""

MAP_RETRY = 10
"""A mapper that has no time to publish now does so in a later tick of its clock [ms]."""


def is_plan_time(now: int) -> bool:
    """Tell whether maps and plans are due at a time [ms]."""
    return now % PLAN_STEP == 0
