# SPDX-License-Identifier: Apache-2.0
"""What the simulator's and the contact sensor's nodes need to know beside their cores."""

from dataclasses import dataclass

from psane_mapping.parameters import Configuration, parameter


@dataclass(frozen=True, kw_only=True)
class SimulatorNodeConfiguration(Configuration):
    """World, pace and frames of the node `hexapod_sim`."""

    terrain: str = parameter(
        'env1', 'terrain by name (env1, env2, smooth:SEED, patchy:SEED, corridors:SEED) or as the '
        'path of a .csv, .npy or GeoTIFF file', read_only=True)
    strength_factor: float = parameter(
        1.0, "multiplies the terrain's strength, for a robot that needs firmer ground than the "
        'default one', low=0.001, high=1000.0, read_only=True)
    use_start: bool = parameter(
        False, "start at start_x, start_y, start_yaw instead of the terrain's own start",
        read_only=True)
    start_x: float = parameter(2.0, 'where the robot starts', unit='m', read_only=True)
    start_y: float = parameter(5.0, 'where the robot starts', unit='m', read_only=True)
    start_yaw: float = parameter(0.0, 'heading at the start', unit='rad', low=-6.3, high=6.3,
                                 read_only=True)
    seed: int = parameter(0, 'seed of the noise', low=0, high=2**31 - 1, read_only=True)
    pace: float = parameter(
        1.0, 'simulated seconds for each second on the wall, where the machine can keep up',
        low=0.01, high=100.0, read_only=True)
    follow_clock: bool = parameter(
        False, 'publish no /clock, and keep step with the one that another simulator publishes: '
        'for a second robot in its world', read_only=True)
    command_timeout: float = parameter(
        0.25, 'simulated time after the last command at which the robot stops by itself; it then '
        'stands within 0.2 s', unit='s', low=0.06, high=5.0)
    truth_file: str = parameter(
        '', 'write the true poses to this CSV file, for scoring (they are on no topic)',
        read_only=True)
    awaited_listener: str = parameter(
        '', 'time begins when the node of this name listens to all topics of the simulator, so '
        'that a recorder misses nothing', read_only=True)
    map_frame: str = parameter('map', 'fixed frame of transforms', read_only=True)
    odom_frame: str = parameter('odom', 'frame of odometry', read_only=True)
    base_frame: str = parameter('base_link', 'frame of the body', read_only=True)


@dataclass(frozen=True, kw_only=True)
class ContactSensorNodeConfiguration(Configuration):
    """Frames of the node `contact_sensor`."""

    map_frame: str = parameter('map', 'frame in which contacts are reported', read_only=True)
    odom_frame: str = parameter(
        'odom', 'frame that odometry must be in; its poses are taken as poses in the map frame '
        '(set it to the map frame for a localiser)', read_only=True)
    base_frame: str = parameter('base_link', 'frame that wrenches must be in', read_only=True)
