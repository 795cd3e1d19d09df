# SPDX-License-Identifier: Apache-2.0
"""Buehler clock: alternating tripods, steered by a different stance sweep on each side.

Each leg turns once per stride, slowly through the ground (stance) and fast through the air
(swing). The stance sweep of a side sets its speed; legs that swing the other way over the top walk
the mirrored gait, so the robot drives like one with two wheels, spot turns included.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray
from psane_mapping.leg import SIDE, TRIPOD
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.feed_forward import Sweep, sweeps_of

_SIDE = np.array(SIDE)
_TRIPOD = np.array(TRIPOD)
_STANDING, _WALKING = 0.0, 1.0
_PHASE, _MODE, _LEFT, _RIGHT, _CENTRE = 0, 1, 2, 3, 4
_STANCE_DECAY, _SWING_DECAY = 0.8, 5.0


def wrap(angle: float) -> float:
    """Return the same direction within [-pi, pi) [rad]."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


_wrap = njit(cache=True)(wrap)


@njit(cache=True)
def _clock_angle(phase: float, sweep: float, direction: float, duty: float,
                 centre: float) -> float:
    """Return a leg's angle at a phase in [0, 1) of its stride [rad]."""
    if phase < duty:
        return centre + sweep * (phase / duty - 0.5)
    swing = (phase - duty) / (1.0 - duty)
    return centre + 0.5 * sweep + (2.0 * math.pi * direction - sweep) * swing


@njit(cache=True)
def _walk(state: FloatArray, angle: FloatArray, offset: FloatArray, direction: FloatArray,
          wanted: FloatArray, speed: FloatArray, dt: float, frequency: float, duty: float,
          sweep_rate: float) -> None:
    """Move the clock, the sweeps and the six reference angles on by one tick."""
    state[_PHASE] = (state[_PHASE] + frequency * dt) % 1.0
    limit = sweep_rate * dt
    for index in range(3):
        change = wanted[index] - state[_LEFT + index]
        state[_LEFT + index] += max(-limit, min(limit, change))
    for leg in range(6):
        sweep = state[_LEFT + _SIDE[leg]]
        phase = (state[_PHASE] + 0.5 * _TRIPOD[leg]) % 1.0
        in_stance = phase < duty
        if in_stance:
            direction[leg] = wanted[3 + _SIDE[leg]]
        decay = (_STANCE_DECAY if in_stance else _SWING_DECAY) * dt
        offset[leg] -= max(-decay, min(decay, offset[leg]))
        new = _clock_angle(phase, sweep, direction[leg], duty, state[_CENTRE]) + offset[leg]
        speed[leg] = _wrap(new - angle[leg]) / dt
        angle[leg] = _wrap(new)


@njit(cache=True)
def _come_to_rest(angle: FloatArray, target: FloatArray, speed: FloatArray, dt: float,
                  gain: float, rate: float) -> None:
    """Move the six reference angles towards where the robot stands, by one tick."""
    for leg in range(6):
        wanted = gain * _wrap(target[leg] - angle[leg])
        speed[leg] = max(-rate, min(rate, wanted))
        angle[leg] = _wrap(angle[leg] + speed[leg] * dt)


@dataclass(frozen=True)
class LegReference:
    """Where the six legs should be, in the order of `LEG_NAMES`.

    Parameters
    ----------
    angle : (6,) float [rad]
    speed : (6,) float [rad/s]
    """

    angle: FloatArray
    speed: FloatArray


class Gait:
    """Turns a commanded Twist into reference angles and speeds of the six legs.

    It starts standing on straight legs. A command of exactly (0, 0) makes it stand again: legs on
    the ground come to rest where they are, legs in the air are put down beside them; any other
    command walks, the smallest being a march in place.

    Parameters
    ----------
    config : SimulatorConfiguration
    """

    def __init__(self, config: SimulatorConfiguration) -> None:
        self._config = config
        self._state = np.array([0.0, _STANDING, 0.0, 0.0, 0.0])
        self._offset = np.zeros(6)
        self._direction = np.ones(6)
        self._wanted = np.array([0.0, 0.0, 0.0, 1.0, 1.0])
        self._target = np.zeros(6)
        self.reference = LegReference(np.zeros(6), np.zeros(6))

    @property
    def is_standing(self) -> bool:
        """True when the robot was told to stand (it may still be coming to rest)."""
        return bool(self._state[_MODE] == _STANDING)

    @property
    def sweep(self) -> Sweep:
        """Stance sweeps that are in force now; all 0 for a robot that was told to stand."""
        if self.is_standing:
            return Sweep(0.0, 0.0, 0.0, 0.0)
        return Sweep(float(self._state[_LEFT]), float(self._state[_RIGHT]),
                     float(self._wanted[3]), float(self._wanted[4]))

    def command(self, linear: float, angular: float) -> None:
        """Ask for a forward speed [m/s] and a yaw rate [rad/s]; exactly (0, 0) means stand."""
        if linear == 0.0 and angular == 0.0:
            if not self.is_standing:
                self._stand()
            return
        self.walk(sweeps_of(linear, angular, self._config))

    def walk(self, sweep: Sweep) -> None:
        """Ask for stance sweeps."""
        is_backward = sweep.swing_left < 0.0 and sweep.swing_right < 0.0
        centre = self._config.backward_centre if is_backward else 0.0
        self._wanted[:] = (sweep.left, sweep.right, centre, sweep.swing_left, sweep.swing_right)
        if self.is_standing:
            self._set_off()

    def tick(self) -> LegReference:
        """Move on by one time step and return the reference (its arrays are reused)."""
        config, reference = self._config, self.reference
        if self.is_standing:
            _come_to_rest(reference.angle, self._target, reference.speed, config.time_step,
                          config.stand_gain, config.stand_rate)
        else:
            _walk(self._state, reference.angle, self._offset, self._direction, self._wanted,
                  reference.speed, config.time_step, config.stride_frequency, config.duty,
                  config.sweep_rate)
        return reference

    def _phases(self) -> FloatArray:
        """Phase of each leg in its stride, (6,), 0..1; below the duty it is in stance."""
        return np.asarray((self._state[_PHASE] + 0.5 * _TRIPOD) % 1.0)

    def _stand(self) -> None:
        """Choose where each leg comes to rest."""
        reference = self.reference
        in_stance = self._phases() < self._config.duty
        stop = reference.angle + reference.speed / self._config.stand_gain
        for side in range(2):
            grounded = in_stance & (side == _SIDE)
            resting = float(np.mean(stop[grounded]))
            self._target[grounded] = stop[grounded]
            self._target[~in_stance & (side == _SIDE)] = resting
        self._state[_MODE] = _STANDING

    def _set_off(self) -> None:
        """Start the clock where the tripod whose turn it is lifts off, from the present angles."""
        duty = self._config.duty
        phases = self._phases()
        lifts_second = phases[1] >= duty or (phases[0] < duty and phases[1] > phases[0])
        phase = duty - 0.5 if lifts_second else duty
        self._state[:] = (phase, _WALKING, 0.0, 0.0, self._wanted[2])
        self._direction[:] = self._wanted[3 + _SIDE]
        for leg, share in enumerate(self._phases()):
            clock = _clock_angle(float(share), 0.0, float(self._direction[leg]), duty,
                                 float(self._state[_CENTRE]))
            self._offset[leg] = wrap(float(self.reference.angle[leg]) - clock)
