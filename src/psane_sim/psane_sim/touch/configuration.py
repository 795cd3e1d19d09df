# SPDX-License-Identifier: Apache-2.0
"""The contact sensor's parameters."""

from dataclasses import dataclass

from psane_mapping.errors import ParameterError
from psane_mapping.parameters import Configuration, parameter


@dataclass(frozen=True, kw_only=True)
class TouchConfiguration(Configuration):
    """When a leg counts as standing, and how noisy what it feels is."""

    touch_down_force: float = parameter(
        6.0, 'upward force above which a leg has touched down', unit='N', low=0.0, high=500.0)
    lift_off_force: float = parameter(
        4.0, 'upward force below which a leg has lifted off', unit='N', low=0.0, high=500.0)
    lift_off_time: float = parameter(
        0.05, 'time without load that ends a stance (a leg rebounds for 20 ms when it brakes)',
        unit='s', low=0.0, high=1.0)
    fewest_samples: int = parameter(
        12, 'shortest stance that is handed on', low=3, high=1000)
    longest_stance: float = parameter(
        2.5, 'a leg that stands for longer says nothing new', unit='s', low=0.1, high=60.0)
    longest_gap: float = parameter(
        0.1, 'gap between measurements after which every stance is forgotten', unit='s',
        low=0.001, high=5.0)
    odometry_timeout: float = parameter(
        0.5, 'age at which odometry is of no use', unit='s', low=0.01, high=10.0)
    moment_arm: float = parameter(
        0.1, 'divides a hip moment so that it weighs like a force', unit='m', low=0.001,
        high=10.0)
    force_deviation: float = parameter(
        1.0, 'noise of a hip force', unit='N', low=0.0, high=100.0)
    force_deviation_share: float = parameter(
        0.03, 'noise of a hip force as a share of it', low=0.0, high=1.0)
    torque_deviation: float = parameter(
        0.1, 'noise of a motor torque', unit='N m', low=0.0, high=100.0)
    torque_deviation_share: float = parameter(
        0.05, 'noise of a motor torque as a share of it', low=0.0, high=1.0)
    velocity_deviation: float = parameter(
        0.008, 'deviation of the velocity of a leg, smoothed over a stance: forces felt while a '
        'leg moves more slowly count less', unit='m/s', low=0.0, high=1.0)
    position_deviation: float = parameter(
        0.01, 'deviation of where odometry says that the body is', unit='m', low=0.0, high=10.0)
    learn_height: bool = parameter(
        True, 'learn from the stances how far off the height and the tilt of odometry are')
    height_deviation: float = parameter(
        0.005, "deviation of the odometry's height before anything was learnt", unit='m',
        low=0.0001, high=0.5, read_only=True)
    tilt_deviation: float = parameter(
        0.005, 'the same of pitch and roll', unit='rad', low=0.0001, high=0.5, read_only=True)
    stance_height_deviation: float = parameter(
        0.003, "deviation of one stance's height around what all have in common", unit='m',
        low=0.0001, high=0.1, read_only=True)
    height_drift: float = parameter(
        0.0003, "drift of the odometry's height over one second", unit='m', low=0.0, high=0.1,
        read_only=True)
    yield_displacement: float = parameter(
        0.0015, 'displacement at which the modelled ground yields fully', unit='m', low=0.0001,
        high=0.05, read_only=True)
    yield_damping: float = parameter(
        0.002, 'time constant of the modelled ground for small displacements', unit='s', low=0.0,
        high=0.1, read_only=True)

    def __post_init__(self) -> None:
        """Check that lifting off needs less force than touching down."""
        super().__post_init__()
        if self.lift_off_force > self.touch_down_force:
            raise ParameterError('lift_off_force', self.lift_off_force,
                                 f'at most touch_down_force = {self.touch_down_force}', 'N')
