# SPDX-License-Identifier: Apache-2.0
"""The simulator's parameters: engine, gait, soil and the noise of what is published."""

from dataclasses import dataclass

from psane_mapping.errors import ParameterError
from psane_mapping.parameters import Configuration, parameter

SOIL_NAMES = ('granular', 'scm_published', 'scm_highlands', 'penetration', 'soft_contact', 'rigid')


@dataclass(frozen=True, kw_only=True)
class SimulatorConfiguration(Configuration):
    """Everything that shapes the simulated robot and its ground, besides the robot's geometry."""

    time_step: float = parameter(
        0.001, 'step of the physics engine', unit='s', low=0.0002, high=0.002, read_only=True)
    gui: bool = parameter(False, "show the physics engine's own window", read_only=True)
    settling_time: float = parameter(
        0.6, 'time in which the robot settles on its legs before the clock starts', unit='s',
        low=0.0, high=10.0, read_only=True)

    stride_frequency: float = parameter(
        0.75, 'turns of each leg', unit='1/s', low=0.1, high=10.0, read_only=True)
    duty: float = parameter(
        0.55, 'share of a turn that a leg spends in stance', low=0.5, high=0.9, read_only=True)
    sweep_limit: float = parameter(
        1.9, 'largest angle that a leg sweeps in stance', unit='rad', low=0.1, high=2.5,
        read_only=True)
    sweep_rate: float = parameter(
        4.0, 'how fast the sweep follows a new command', unit='rad/s', low=0.1, high=100.0,
        read_only=True)
    speed_per_sweep: float = parameter(
        0.323, 'forward speed for a sweep of 1 rad at 1 turn/s', unit='m/rad', low=0.01,
        high=5.0, read_only=True)
    turn_per_sweep: float = parameter(
        0.346, 'yaw rate for a half difference of sweeps of 1 rad at 1 turn/s', low=0.01,
        high=20.0, read_only=True)
    turn_gain: float = parameter(
        0.0405, 'growth of turn_per_sweep with the mean sweep', unit='1/rad', low=0.0, high=20.0,
        read_only=True)
    turn_exponent: float = parameter(
        0.86, 'power of the half difference of sweeps with which the yaw rate grows', low=0.5,
        high=2.0, read_only=True)
    speed_per_turn: float = parameter(
        0.232, 'forward speed that a half difference of 1 rad adds at 1 turn/s', unit='m/rad',
        low=0.0, high=5.0, read_only=True)
    backward_speed_per_sweep: float = parameter(
        0.26, 'speed for a sweep of 1 rad at 1 turn/s when walking backward', unit='m/rad',
        low=0.01, high=5.0, read_only=True)
    backward_centre: float = parameter(
        -0.35, 'angle of the legs in the middle of their stance when they walk backward; on their '
        'toes their speed depends less on the ground', unit='rad', low=-1.0, high=1.0,
        read_only=True)
    backward_turn_per_sweep: float = parameter(
        0.327, 'turn_per_sweep when walking backward', low=0.01, high=20.0, read_only=True)
    spot_turn_per_sweep: float = parameter(
        0.612, 'turn_per_sweep when turning on the spot', low=0.01, high=20.0, read_only=True)
    spot_turn_exponent: float = parameter(
        1.12, 'power of the half difference of sweeps with which a turn on the spot grows',
        low=0.5, high=2.0, read_only=True)
    speed_limit: float = parameter(
        0.3, 'largest forward speed that is obeyed', unit='m/s', low=0.0, high=5.0)
    turn_limit: float = parameter(
        0.4, 'largest yaw rate that is obeyed', unit='rad/s', low=0.0, high=5.0)
    stand_gain: float = parameter(
        20.0, 'how fast the legs come to rest when the robot is told to stand', unit='1/s',
        low=5.0, high=100.0, read_only=True)
    stand_rate: float = parameter(
        12.0, 'largest speed of a leg that is put down to stand', unit='rad/s', low=1.0,
        high=50.0, read_only=True)

    soil: str = parameter(
        'granular', 'how the ground pushes: resistive force theory, the soil contact model (of '
        'the published run, of a lunar highlands simulant), penetration resistance with dry '
        'friction, springs and dampers, hard ground', choices=SOIL_NAMES, read_only=True)
    footprints: bool = parameter(
        False, 'ground that was pressed down stays down', read_only=True)
    footprint_share: float = parameter(
        0.5, 'share of a footprint that stays open when the foot leaves it', low=0.0, high=1.0,
        read_only=True)
    footprint_refill_time: float = parameter(
        0.0, 'time in which sand flows back into a footprint (0: it stays)', unit='s', low=0.0,
        high=1e6, read_only=True)
    footprint_compaction: float = parameter(
        0.3, 'growth of the strength in a footprint of 5 cm', low=0.0, high=10.0, read_only=True)
    footprint_cell: float = parameter(
        0.02, 'edge of a cell of the field that holds the footprints', unit='m', low=0.005,
        high=0.2, read_only=True)
    soil_displacement: float = parameter(
        0.0015, 'displacement at which granular ground yields fully', unit='m', low=0.0001,
        high=0.02, read_only=True)
    soil_damping: float = parameter(
        0.002, 'time constant of the damping of small displacements', unit='s', low=0.0,
        high=0.02, read_only=True)

    noise_scale: float = parameter(
        1.0, 'multiplies every noise and bias of what is published (0: none)', low=0.0, high=10.0)
    force_noise: float = parameter(
        1.0, 'noise of each hip force', unit='N', low=0.0, high=100.0)
    force_noise_share: float = parameter(
        0.03, 'noise of each hip force as a share of it', low=0.0, high=1.0)
    torque_noise: float = parameter(
        0.1, 'noise of each hip moment and motor torque', unit='N m', low=0.0, high=10.0)
    torque_noise_share: float = parameter(
        0.05, 'noise of each hip moment and motor torque as a share of it', low=0.0, high=1.0)
    joint_angle_noise: float = parameter(
        0.0035, 'noise of a joint angle', unit='rad', low=0.0, high=0.5)
    joint_velocity_noise: float = parameter(
        0.05, 'noise of a joint velocity', unit='rad/s', low=0.0, high=5.0)
    attitude_noise: float = parameter(
        0.0035, 'white noise of roll, pitch and yaw', unit='rad', low=0.0, high=0.5)
    attitude_bias: float = parameter(
        0.0052, 'deviation of the constant error of roll and pitch', unit='rad', low=0.0,
        high=0.5)
    angular_velocity_noise: float = parameter(
        0.005, 'noise of each angular velocity', unit='rad/s', low=0.0, high=1.0)
    acceleration_noise: float = parameter(
        0.05, 'noise of each acceleration', unit='m/s^2', low=0.0, high=10.0)
    velocity_noise: float = parameter(
        0.02, 'noise of each body velocity', unit='m/s', low=0.0, high=1.0)
    velocity_noise_share: float = parameter(
        0.03, 'noise of each body velocity as a share of it', low=0.0, high=1.0)
    height_noise: float = parameter(
        0.001, 'white noise of the height', unit='m', low=0.0, high=0.1)
    height_bias: float = parameter(
        0.005, 'deviation of the constant error of the height', unit='m', low=0.0, high=0.1)
    position_noise: float = parameter(
        0.005, 'white noise of the position along x and y', unit='m', low=0.0, high=1.0)

    def __post_init__(self) -> None:
        """Check that the fast part of the gait is faster than its slow part."""
        super().__post_init__()
        if self.time_step * self.stand_gain > 0.1:
            raise ParameterError('stand_gain', self.stand_gain,
                                 f'at most 0.1 / time_step = {0.1 / self.time_step:g}', '1/s')
