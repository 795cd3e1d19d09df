# SPDX-License-Identifier: Apache-2.0
"""Put together what is known twice: a quick rate without a zero, and a noisy value with one.

The rate, added up, has the right shape and drifts; the value is right on average and noisy. Their
difference is slow, so that it can be smoothed over a long time without blurring anything.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from psane_mapping.grid import FloatArray


def smooth(time: FloatArray, values: FloatArray, at: FloatArray, width: float,
           drift_share: float = 0.3) -> FloatArray:
    """Return values smoothed by straight lines, each fitted to what lies near in time.

    Parameters
    ----------
    time : (m,) float [s]
        Not empty.
    values : (m, k) float
    at : (n,) float [s]
    width : float
        Standard deviation of the window [s].
    drift_share : float
        How little the line may slope: the slope is shrunk as if so many further values, one width
        away, had shown none. One value alone makes a constant.

    Returns
    -------
    (n, k) float
    """
    away = (at[:, None] - time[None, :]) / width
    # Beyond the ends of `time` the nearest values count, however far they are.
    nearest = np.abs(away).min(axis=1, keepdims=True)
    weight = np.exp(-0.5 * (away**2 - nearest**2))
    total = weight.sum(axis=1)
    centre = (weight * away).sum(axis=1) / total
    mean = weight @ values / total[:, None]
    moved = away - centre[:, None]
    spread = (weight * moved**2).sum(axis=1) + drift_share
    slope = (weight * moved) @ values / spread[:, None]
    return np.asarray(mean - slope * centre[:, None])


def added_up(time: FloatArray, rate: FloatArray, *, is_mean: bool = False) -> FloatArray:
    """Return the integral of a rate (n, k), 0 at the first sample.

    Parameters
    ----------
    time : (n,) float [s]
    rate : (n, k) float
    is_mean : bool
        True when each rate is the mean since the sample before.
    """
    step = np.diff(time)[:, None]
    part = rate[1:] if is_mean else 0.5 * (rate[1:] + rate[:-1])
    return np.concatenate((np.zeros((1, rate.shape[1])), np.cumsum(step * part, axis=0)))


def corrected(time: FloatArray, integral: FloatArray, value_time: FloatArray, value: FloatArray,
              width: float) -> FloatArray:
    """Return an integral (n, k) shifted, slowly, onto noisy values (m, k) of the same thing."""
    known = np.column_stack([np.interp(value_time, time, column) for column in integral.T])
    return integral + smooth(value_time, value - known, time, width)


def corrected_attitude(time: FloatArray, angular_velocity: FloatArray, quaternion: FloatArray,
                       width: float) -> FloatArray:
    """Return rotations (n, 3, 3), body to map, from rates and noisy attitudes.

    Parameters
    ----------
    time : (n,) float [s]
    angular_velocity : (n, 3) float, body frame [rad/s]
    quaternion : (n, 4) float
        Attitude of the body in the map, x y z w [-].
    width : float [s]
    """
    noisy = Rotation.from_quat(quaternion)
    mean_rate = 0.5 * (angular_velocity[1:] + angular_velocity[:-1])
    steps = Rotation.from_rotvec(np.diff(time)[:, None] * mean_rate).as_matrix()
    turned = np.empty((len(time), 3, 3))
    turned[0] = noisy[0].as_matrix()
    for i, step in enumerate(steps):
        turned[i + 1] = turned[i] @ step
    error = (noisy * Rotation.from_matrix(turned).inv()).as_rotvec()
    correction = Rotation.from_rotvec(smooth(time, error, time, width))
    return np.asarray(correction.as_matrix() @ turned)
