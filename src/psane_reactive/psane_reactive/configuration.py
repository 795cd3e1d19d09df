# SPDX-License-Identifier: Apache-2.0
"""Parameters of the steering, each written once."""

from dataclasses import dataclass

from psane_mapping.errors import ParameterError
from psane_mapping.parameters import Configuration, parameter


@dataclass(frozen=True, kw_only=True)
class ReactiveConfiguration(Configuration):
    """How the robot is steered inside the region that it may use."""

    map_frame: str = parameter('map', 'frame of region, subgoal and pose', read_only=True)
    steering_map: str = parameter(
        'harmonic', 'how the way through the region is found',
        choices=('harmonic', 'purging', 'field'))
    holonomic: bool = parameter(
        False, 'drive sideways, too, for a robot that can; the yaw stays what it is')
    rate: float = parameter(20.0, 'rate of velocity commands', unit='Hz', low=5.0, high=100.0,
                            read_only=True)

    linear_limit: float = parameter(0.3, 'largest speed', unit='m/s', low=0.02, high=2.0)
    angular_limit: float = parameter(0.4, 'largest yaw rate', unit='rad/s', low=0.05, high=3.0)
    linear_acceleration: float = parameter(
        0.6, 'largest change of speed per second', unit='m/s^2', low=0.05, high=10.0)
    angular_acceleration: float = parameter(
        1.6, 'largest change of yaw rate per second', unit='rad/s^2', low=0.05, high=20.0)
    sweep_per_speed: float = parameter(
        4.103, 'sweep of a stance leg per speed, 1.2 / (0.39 f) at f = 0.75 Hz',
        unit='rad s/m', low=0.0, high=50.0)
    sweep_per_yaw_rate: float = parameter(
        1.379, 'sweep of a stance leg per yaw rate, 0.5 * 1.2 / (0.58 f) at f = 0.75 Hz',
        unit='s', low=0.0, high=50.0)
    sweep_limit: float = parameter(
        1.9, 'largest sweep that speed and yaw rate may ask for together', unit='rad',
        low=0.1, high=100.0)

    mesh_edge: float = parameter(0.1, 'edge of the mesh of the region', unit='m', low=0.02,
                                 high=1.0)
    mesh_size: int = parameter(
        3000, 'number of mesh vertices above which the edge is made longer', low=200, high=100000)
    smoothing_radius: float = parameter(
        0.002, 'radius of the finest corner that the map follows; necks below four are shut',
        unit='m', low=0.0005, high=0.05)
    hole_stiffness: float = parameter(
        1.0, 'pull of a hole on its border; large values shrink it to a point', low=0.01,
        high=1000.0)
    longest_detour: float = parameter(
        1.1, 'times the way on the other side of a hole from which the harmonic way is too long',
        low=1.0, high=100.0)
    purge_switch: str = parameter(
        'scale_free', 'switch of the purging map; exponential is the published one',
        choices=('scale_free', 'exponential'))
    purge_pieces: str = parameter(
        'convex', 'what the purging map cuts obstacles into', choices=('convex', 'triangles'))
    purge_width: float = parameter(
        0.5, 'how far from an obstacle the purging map bends space at most', unit='m', low=0.02,
        high=5.0)
    field_cell: float = parameter(0.05, 'cell of the fallback field', unit='m', low=0.01, high=0.5)
    field_length: float = parameter(
        0.2, 'decay length of the fallback field', unit='m', low=0.02, high=2.0)
    stall_time: float = parameter(
        20.0, 'time without progress after which the fallback field steers', unit='s', low=2.0,
        high=600.0)

    look_ahead: float = parameter(
        1.5, 'how far along its way the robot aims', unit='m', low=0.1, high=5.0)
    straight_reach: float = parameter(
        3.0, 'distance within which a visible subgoal is driven at straight', unit='m', low=0.0,
        high=100.0)
    edge_margin: float = parameter(
        0.05, 'distance kept from the edge of the region where there is room', unit='m', low=0.0,
        high=0.5)

    direction_time: float = parameter(
        0.1, 'time in which the direction of travel follows its target', unit='s', low=0.001,
        high=5.0)
    direction_rate: float = parameter(
        3.0, 'largest turn of the direction of travel per second', unit='rad/s', low=0.1,
        high=100.0)
    heading_gain: float = parameter(1.5, 'yaw rate per heading error', unit='1/s', low=0.1,
                                    high=10.0)
    approach_gain: float = parameter(0.8, 'speed per distance left', unit='1/s', low=0.1,
                                     high=10.0)
    slowest: float = parameter(0.05, 'speed that the profiles do not go below', unit='m/s',
                               low=0.005, high=0.5)
    turn_first_above: float = parameter(
        1.2, 'heading error above which the robot turns before it drives', unit='rad', low=0.1,
        high=3.0)
    turn_until: float = parameter(
        0.4, 'heading error at which a turn in place ends', unit='rad', low=0.02, high=2.0)
    arc_radius: float = parameter(
        0.8, 'tightest arc that the gait walks; what is tighter is turned in place', unit='m',
        low=0.0, high=10.0)
    arc_room: float = parameter(
        0.3, 'share of the way of an arc that must be free ahead for it to be driven', low=0.0,
        high=5.0)
    edge_time: float = parameter(
        0.8, 'time in which the robot would reach the edge ahead, at least', unit='s', low=0.1,
        high=10.0)
    reverse_reach: float = parameter(
        0.6, 'way left to the goal below which one behind is driven at backwards; 0 never',
        unit='m', low=0.0, high=5.0)
    reverse_above: float = parameter(
        2.0, 'heading error from which a target counts as behind', unit='rad', low=1.6, high=3.1)
    arrival_tolerance: float = parameter(
        0.1, 'distance at which a subgoal counts as reached', unit='m', low=0.01, high=1.0)

    stop_delay: float = parameter(
        0.15, 'time until a command takes effect', unit='s', low=0.0, high=2.0)
    stop_horizon: float = parameter(
        0.5, 'time over which the motion must stay inside the region', unit='s', low=0.05,
        high=5.0)
    stop_margin: float = parameter(
        0.002, 'distance from the edge at which the predicted motion must end', unit='m',
        low=0.0, high=0.1)
    slip_share: float = parameter(
        0.5, 'share of the commanded speed or yaw rate that slip may take', low=0.0, high=1.0)
    outside_tolerance: float = parameter(
        0.01, 'distance outside the region from which the robot is led back', unit='m', low=0.0,
        high=0.5)
    retreat_speed: float = parameter(
        0.2, 'speed at which the robot is led back, backs out, or leaves where it leans',
        unit='m/s', low=0.01, high=0.5)
    lean_limit: float = parameter(
        0.28, 'tilt of the body above which it walks straight out instead of turning; 3.2 never',
        unit='rad', low=0.02, high=3.2)
    lean_way: float = parameter(
        0.3, 'longest straight way of a leaning robot before it turns all the same', unit='m',
        low=0.0, high=2.0)
    backward_limit: float = parameter(
        0.5, 'tilt of the body above which it does not walk backward; 3.2 never', unit='rad',
        low=0.02, high=3.2)
    fallen_above: float = parameter(
        1.2, 'tilt of the body above which it lies and its legs are kept still; 3.2 never',
        unit='rad', low=0.1, high=3.2)
    nose: float = parameter(0.28, 'reach of the body ahead of its centre', unit='m', low=0.0,
                            high=2.0)
    nose_allowance: float = parameter(
        0.12, 'how far the nose may be outside the region while the robot turns much', unit='m',
        low=0.0, high=2.0)
    back_out_above: float = parameter(
        1.0, 'turn that is preceded by backing out when the nose is outside', unit='rad',
        low=0.1, high=3.2)
    back_out_length: float = parameter(
        0.4, 'largest way driven backwards before a turn', unit='m', low=0.0, high=2.0)

    march_speed: float = parameter(0.05, 'speed of the shuffle in place', unit='m/s', low=0.005,
                                   high=0.3)
    march_period: float = parameter(1.4, 'time of each half of the shuffle', unit='s', low=0.2,
                                    high=20.0)
    march_reach: float = parameter(
        0.08, 'largest distance from where the shuffle began', unit='m', low=0.01, high=0.5)

    odometry_age_limit: float = parameter(
        0.5, 'age from which odometry is too old to steer by', unit='s', low=0.05, high=10.0)
    region_age_limit: float = parameter(
        12.0, 'age from which a region is too old to steer in', unit='s', low=0.5, high=600.0)
    subgoal_age_limit: float = parameter(
        12.0, 'age from which a subgoal is too old to steer to', unit='s', low=0.5, high=600.0)

    def __post_init__(self) -> None:
        """Check each field, then the relations between them."""
        super().__post_init__()
        if self.turn_until >= self.turn_first_above:
            raise ParameterError('turn_until', self.turn_until,
                                 f'less than turn_first_above = {self.turn_first_above:g}', 'rad')
        if self.slowest > self.linear_limit:
            raise ParameterError('slowest', self.slowest,
                                 f'at most linear_limit = {self.linear_limit:g}', 'm/s')
