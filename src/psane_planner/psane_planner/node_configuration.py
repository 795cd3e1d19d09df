# SPDX-License-Identifier: Apache-2.0
"""What the planner's node needs to know beside how to plan."""

from dataclasses import dataclass

from psane_mapping.parameters import Configuration, parameter


@dataclass(frozen=True, kw_only=True)
class PlannerNodeConfiguration(Configuration):
    """Frames and rates of the node `safe_planner`."""

    map_frame: str = parameter('map', 'frame of maps, goals and everything published',
                               read_only=True)
    odom_frame: str = parameter(
        'odom', 'frame that odometry must be in; its poses are taken as poses in the map frame '
        '(set it to the map frame for a localiser)', read_only=True)
    explore: bool = parameter(
        False, 'without a goal: certify as much ground as can be reached, instead of waiting')
    plan_rate: float = parameter(5.0, 'most plans made in a second', unit='Hz', low=0.5,
                                 high=50.0, read_only=True)
    odometry_age_limit: float = parameter(
        0.5, 'age from which odometry is too old to plan from', unit='s', low=0.05, high=10.0)
    republish_period: float = parameter(
        5.0, 'the last region, subgoal and safe map are sent again after this time', unit='s',
        low=0.5, high=10.0, read_only=True)
