# SPDX-License-Identifier: Apache-2.0
"""What may be commanded at all: speed, yaw rate, both together, and how fast they change."""

import math
from typing import NamedTuple

from psane_reactive.configuration import ReactiveConfiguration


class Velocity(NamedTuple):
    """Velocity in the body frame: forward [m/s] and yaw rate [rad/s]."""

    linear: float
    angular: float


STANDSTILL = Velocity(0.0, 0.0)


def wrap(angle: float) -> float:
    """Return an angle in (-pi, pi] [rad]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)


def clip(value: float, limit: float) -> float:
    """Return a value limited to [-limit, limit]."""
    return max(-limit, min(limit, value))


def limited(velocity: Velocity, configuration: ReactiveConfiguration) -> Velocity:
    """Return the nearest velocity that the legs can do; standstill for one that is not finite.

    Notes
    -----
    Forward speed needs stance sweep on both sides, yaw rate a difference of sweeps; when they ask
    for more than there is both shrink alike, which keeps the curvature.
    """
    if not (math.isfinite(velocity.linear) and math.isfinite(velocity.angular)):
        return STANDSTILL
    linear = clip(velocity.linear, configuration.linear_limit)
    angular = clip(velocity.angular, configuration.angular_limit)
    sweep = (configuration.sweep_per_speed * abs(linear)
             + configuration.sweep_per_yaw_rate * abs(angular))
    scale = min(1.0, configuration.sweep_limit / sweep) if sweep > 0.0 else 1.0
    return Velocity(scale * linear, scale * angular)


def rate_limited(wanted: Velocity, last: Velocity, step: float,
                 configuration: ReactiveConfiguration) -> Velocity:
    """Return the velocity nearest to the wanted one that can be had `step` [s] after the last."""
    return Velocity(
        last.linear + clip(wanted.linear - last.linear,
                           configuration.linear_acceleration * step),
        last.angular + clip(wanted.angular - last.angular,
                            configuration.angular_acceleration * step))


def walkable(velocity: Velocity, configuration: ReactiveConfiguration) -> Velocity:
    """Return a velocity with the yaw rate that the gait can walk at its speed; turns unchanged.

    Notes
    -----
    Of what asks for a tighter arc the gait makes a turn on the spot, and the robot stays there.
    """
    if velocity.linear == 0.0 or configuration.arc_radius == 0.0:
        return velocity
    largest = abs(velocity.linear) / configuration.arc_radius
    return Velocity(velocity.linear, clip(velocity.angular, largest))
