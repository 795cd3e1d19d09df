# SPDX-License-Identifier: Apache-2.0
"""Compiled rank-one updates; single-threaded and in a fixed order, so that runs are repeatable.

A symmetric matrix is kept as the rows of its lower triangle, one after the other: half the memory,
and half of what an update has to read and write.
"""

import numba
import numpy as np

from psane_mapping.grid import FloatArray

# Sums may be vectorised. The compiler then fixes their order, which is the same in every run.
_SUMS = {'reassoc', 'nsz', 'contract'}
_FAR = 7.0


def packed_identity(count: int) -> FloatArray:
    """Return the lower triangle of an identity matrix."""
    triangle = np.zeros(count * (count + 1) // 2)
    rows = np.arange(count)
    triangle[rows * (rows + 3) // 2] = 1.0
    return triangle


@numba.njit(cache=True)
def axis_modes(position: float, lattice: FloatArray, rotation: FloatArray, lengthscale: float,
               amplitude: float) -> FloatArray:
    """Return the modes of one axis at a position [m], shape (axis modes,); see `AxisBasis`."""
    modes = np.zeros(rotation.shape[1])
    for node in range(lattice.size):
        scaled = (position - lattice[node]) / lengthscale
        # Beyond, the response is below 1e-21.
        if abs(scaled) < _FAR:
            response = amplitude * np.exp(-scaled * scaled)
            for mode in range(modes.size):
                modes[mode] += response * rotation[node, mode]
    return modes


@numba.njit(cache=True, fastmath=_SUMS)
def observe(covariance: FloatArray, weights: FloatArray, pending: FloatArray,
            pending_variance: float, features: FloatArray, value: float, variance: float
            ) -> tuple[FloatArray, float, float]:
    """Condition Gaussian weights on one measurement ``value = features . weights + noise``.

    What a measurement takes off the covariance is taken off on the way through it for the next
    one, because a pass over the memory costs more than the arithmetic.

    Parameters
    ----------
    covariance : (m (m + 1) / 2,) float, changed in place
        Lower triangle, row after row, before the last measurement.
    weights : (m,) float, changed in place
        Mean of the weights.
    pending : (m,) float
        The gain of the last measurement; zeros before the first.
    pending_variance : float
        The innovation variance of the last measurement, above 0.
    features : (m,) float
    value : float
    variance : float
        Of the measurement's noise.

    Returns
    -------
    gain : (m,) float
        ``covariance @ features`` as it was before the measurement.
    innovation, innovation_variance : float
    """
    count = features.size
    gain = np.zeros(count)
    start = 0
    for j in range(count):
        row = covariance[start:start + j]
        feature, taken, total = features[j], pending[j] / pending_variance, 0.0
        for i in range(j):
            left = row[i] - taken * pending[i]
            row[i] = left
            gain[i] += feature * left
            total += features[i] * left
        own = covariance[start + j] - taken * pending[j]
        covariance[start + j] = own
        gain[j] += total + feature * own
        start += j + 1
    innovation = value
    innovation_variance = variance
    for j in range(count):
        innovation -= features[j] * weights[j]
        innovation_variance += features[j] * gain[j]
    # The prediction's variance is not negative; round-off may say so after exact measurements.
    innovation_variance = max(innovation_variance, variance)
    for j in range(count):
        weights[j] += gain[j] * innovation / innovation_variance
    return gain, innovation, innovation_variance


@numba.njit(cache=True, fastmath={'contract'})
def spread(gain: FloatArray, cells_y: FloatArray, cells_x: FloatArray,
           rows: int, columns: int) -> FloatArray:
    """Return the covariance of the measured value with each cell, shape (rows, columns).

    Two rows of cells and four modes at a time, because reading takes longer than adding up.

    Parameters
    ----------
    gain : (axis modes y, axis modes x) float
        Zero where a pair of modes was left out.
    cells_y : (>= rows, axis modes y) float
    cells_x : (axis modes x, >= columns) float
    rows, columns : int
        How many cells of the rectangle exist.
    """
    modes_y, modes_x = gain.shape
    # In whole fours, the last ones with nothing in them.
    fours = (modes_x + 3) // 4 * 4
    along = np.zeros((fours, columns))
    along[:modes_x] = cells_x[:, :columns]
    across = np.zeros((2, fours))
    covariance = np.zeros((rows + rows % 2, columns))
    for row in range(0, rows, 2):
        across[:] = 0.0
        for k in range(modes_y):
            one, two = cells_y[row, k], cells_y[min(row + 1, rows - 1), k]
            for i in range(modes_x):
                across[0, i] += one * gain[k, i]
                across[1, i] += two * gain[k, i]
        for k in range(0, fours, 4):
            a, b, c, d = across[0, k], across[0, k + 1], across[0, k + 2], across[0, k + 3]
            e, f, g, h = across[1, k], across[1, k + 1], across[1, k + 2], across[1, k + 3]
            for column in range(columns):
                p, q = along[k, column], along[k + 1, column]
                r, s = along[k + 2, column], along[k + 3, column]
                covariance[row, column] += (a * p + b * q) + (c * r + d * s)
                covariance[row + 1, column] += (e * p + f * q) + (g * r + h * s)
    return covariance[:rows]


@numba.njit(cache=True)
def assimilate(mean: FloatArray, variance: FloatArray, covariance: FloatArray, innovation: float,
               innovation_variance: float) -> None:
    """Update the mean and variance of cells (rows, columns) in place for one measurement."""
    step, shrinkage = innovation / innovation_variance, 1.0 / innovation_variance
    for row in range(covariance.shape[0]):
        for column in range(covariance.shape[1]):
            shared = covariance[row, column]
            mean[row, column] += shared * step
            left = variance[row, column] - shared * shared * shrinkage
            variance[row, column] = max(left, 0.0)
