# SPDX-License-Identifier: Apache-2.0
"""Which stance sweeps make a commanded Twist on firm ground.

Three ways to walk: forward (every leg swings forward over the top, and the sides differ in
sweep), backward (the mirrored gait), and on the spot (one side each way). Forward arcs tighter
than a radius of about 0.8 m do not exist for this gait, so what lies between is turned on the
spot.
"""

import math
from typing import NamedTuple

from psane_sim.configuration import SimulatorConfiguration

_LONGEST_MEAN = 1.4
_LONGEST_DIFFERENCE = 1.1
STRAIGHT_SWEEP = 1.2
"""Of both sides in the reference gait, a straight walk [rad]."""

UNPUSHED_SWEEP = 1.4
"""Mean sweep at which a difference between the sides adds no speed [rad]."""

_SPOT_SHARE = 0.7
_ITERATIONS = 12


class Sweep(NamedTuple):
    """Stance sweeps of the two sides [rad] and the sense in which their legs swing (+1, -1)."""

    left: float
    right: float
    swing_left: float = 1.0
    swing_right: float = 1.0

    @property
    def kind(self) -> str:
        """'forward', 'backward' or 'spot'."""
        if self.swing_left != self.swing_right:
            return 'spot'
        return 'forward' if self.swing_left > 0.0 else 'backward'


def sweeps_of(linear: float, angular: float, config: SimulatorConfiguration) -> Sweep:
    """Return the sweeps that make a Twist on firm ground.

    Parameters
    ----------
    linear, angular : float
        Forward speed [m/s] and yaw rate [rad/s]; each is first clipped to its own limit.
    config : SimulatorConfiguration

    Returns
    -------
    Sweep
        Where both sides together ask for more than `sweep_limit`, both shrink alike.
    """
    linear = max(-config.speed_limit, min(config.speed_limit, linear))
    angular = max(-config.turn_limit, min(config.turn_limit, angular))
    least = _SPOT_SHARE * config.speed_per_turn / config.turn_per_sweep * abs(angular)
    if abs(linear) < least:
        return _on_the_spot(angular, config)
    if linear < 0.0:
        return _backward(linear, angular, config)
    return _forward(linear, angular, config)


def _forward(linear: float, angular: float, config: SimulatorConfiguration) -> Sweep:
    """Solve v / f = a m + b |d| (1 - m / 1.4), w / f = (c + e m) d^p for mean m, difference d."""
    speed = linear / config.stride_frequency
    turn = angular / config.stride_frequency
    mean, difference = speed / config.speed_per_sweep, 0.0
    for _ in range(_ITERATIONS):
        wanted = turn / (config.turn_per_sweep + config.turn_gain * mean)
        difference = math.copysign(abs(wanted) ** (1.0 / config.turn_exponent), turn)
        difference = max(-_LONGEST_DIFFERENCE, min(_LONGEST_DIFFERENCE, difference))
        pushed = config.speed_per_turn * abs(difference) * max(0.0, 1.0 - mean / UNPUSHED_SWEEP)
        wanted = (speed - pushed) / config.speed_per_sweep
        mean = 0.5 * (mean + max(0.0, min(_LONGEST_MEAN, wanted)))
    return _limited(mean, difference, 1.0, 1.0, config)


def _backward(linear: float, angular: float, config: SimulatorConfiguration) -> Sweep:
    """Walk the mirrored gait, whose steps are shorter; neither side's sweep turns positive."""
    mean = linear / (config.backward_speed_per_sweep * config.stride_frequency)
    difference = angular / (config.backward_turn_per_sweep * config.stride_frequency)
    difference = max(mean, min(-mean, difference))
    return _limited(mean, difference, -1.0, -1.0, config)


def _on_the_spot(angular: float, config: SimulatorConfiguration) -> Sweep:
    """Walk forward on one side and backward on the other."""
    sense = 1.0 if angular >= 0.0 else -1.0
    turn = abs(angular) / (config.spot_turn_per_sweep * config.stride_frequency)
    difference = sense * turn ** (1.0 / config.spot_turn_exponent)
    return _limited(0.0, difference, -sense, sense, config)


def _limited(mean: float, difference: float, swing_left: float, swing_right: float,
             config: SimulatorConfiguration) -> Sweep:
    scale = min(1.0, config.sweep_limit / max(abs(mean) + abs(difference), 1.0e-9))
    return Sweep(scale * (mean - difference), scale * (mean + difference), swing_left,
                 swing_right)
