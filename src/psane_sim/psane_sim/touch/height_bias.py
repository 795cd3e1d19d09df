# SPDX-License-Identifier: Apache-2.0
"""How much higher the robot believes to be than it is, learnt from its stances.

A leg that is believed to be too high feels the ground before it should be there. The force that
grows with depth therefore tells the height's error apart from the ground's strength, and since the
error is the same for all legs and hardly changes, what the stances say of it is put together.
"""

import math
from dataclasses import dataclass

import numpy as np

from psane_mapping.grid import FloatArray

_ROUNDS = 6
_HUBER = 1.5
_LARGEST_SURPRISE = 4.0


@dataclass(frozen=True)
class HeightOffset:
    """What one stance says: how far the ground is above where it should be, and how surely.

    Parameters
    ----------
    offset, deviation : float [m]
    """

    offset: float
    deviation: float


def offset_of(measured: FloatArray, response: FloatArray, deeper: FloatArray,
              deviation: FloatArray, step: float) -> HeightOffset | None:
    """Return how much deeper a leg was than believed, from its forces alone.

    Parameters
    ----------
    measured, response, deviation : (n, channels) float [N]
        As in `LegContact`.
    deeper : (n, channels) float [N]
        The response if the leg had been deeper by `step` all the time.
    step : float [m]

    Returns
    -------
    None where the two columns cannot be told apart, or no force was felt.

    Notes
    -----
    Least squares with Huber's weights in ``measured = a response + (a b) (deeper - response) /
    step`` for strength `a` and offset `b`. The number of samples is divided by ``(1 + r) /
    (1 - r)``, with the correlation `r` of neighbouring residuals.
    """
    first = response / deviation
    second = (deeper - response) / (step * deviation)
    target = measured / deviation
    weight = np.ones_like(target)
    for _ in range(_ROUNDS):
        normal = np.array([[(weight * first**2).sum(), (weight * first * second).sum()],
                           [(weight * first * second).sum(), (weight * second**2).sum()]])
        if np.linalg.cond(normal * np.outer(*[1.0 / np.sqrt(np.diag(normal) + 1e-12)] * 2)) > 1e6:
            return None
        strength, product = np.linalg.solve(normal, [(weight * first * target).sum(),
                                                     (weight * second * target).sum()])
        residual = target - strength * first - product * second
        scale = max(1.0, 1.4826 * float(np.median(np.abs(residual))))
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(np.abs(residual), 1e-12))
    if strength <= 0.0:
        return None
    variance = scale**2 * _inflation(residual) * float(np.linalg.inv(normal)[1, 1]) / strength**2
    return HeightOffset(float(product / strength), math.sqrt(variance))


def _inflation(residual: FloatArray) -> float:
    power = float((residual**2).sum())
    repeated = float((residual[1:] * residual[:-1]).sum()) / power if power > 0.0 else 0.0
    repeated = min(max(repeated, 0.0), 1.0 - 1.0 / len(residual))
    return (1.0 + repeated) / (1.0 - repeated)


class HeightBias:
    """Offset and tilt that all stances share: a Kalman filter for three numbers that drift slowly.

    Parameters
    ----------
    deviation : float
        Of the offset before anything is known [m].
    tilt_deviation : float
        The same of the error of pitch and roll, which makes the offset differ from leg to leg
        [rad].
    stance_deviation : float
        Of one stance's offset around what is shared: unevenness, shape of the force law [m].
    drift : float
        Of the offset over one second [m].
    """

    def __init__(self, deviation: float, tilt_deviation: float, stance_deviation: float,
                 drift: float) -> None:
        self._prior = np.diag([deviation**2, tilt_deviation**2, tilt_deviation**2])
        self._own = stance_deviation**2
        self._drift = drift**2
        self._mean = np.zeros(3)
        self._covariance = self._prior.copy()
        self._time: float | None = None

    def at(self, hip: FloatArray) -> float:
        """Return the offset at a hip, (3,) base frame [m]."""
        return float(_row(hip) @ self._mean)

    @property
    def deviation(self) -> float:
        """Of the offset in the middle of the body, as it is known now [m]."""
        return math.sqrt(self._covariance[0, 0])

    def learn(self, found: HeightOffset, hip: FloatArray, time: float) -> None:
        """Take in what a stance of the leg at a hip says.

        One that contradicts all others counts the less the more it does.
        """
        if self._time is not None:
            self._covariance[0, 0] = min(
                self._prior[0, 0],
                self._covariance[0, 0] + self._drift * max(0.0, time - self._time))
        self._time = time
        row = _row(hip)
        noise = found.deviation**2 + self._own
        innovation = found.offset - float(row @ self._mean)
        expected = float(row @ self._covariance @ row)
        noise *= max(1.0, innovation**2 / (expected + noise) / _LARGEST_SURPRISE)
        gain = self._covariance @ row / (expected + noise)
        self._mean = self._mean + gain * innovation
        self._covariance = self._covariance - np.outer(gain, row @ self._covariance)


def _row(hip: FloatArray) -> FloatArray:
    return np.array([1.0, hip[0], hip[1]])
