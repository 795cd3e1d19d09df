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


@numba.njit(cache=True)
def spread(gain: FloatArray, cells_y: FloatArray, cells_x: FloatArray,
           rows: int, columns: int) -> FloatArray:
    """Return the covariance of the measured value with each cell, shape (rows, columns).

    Parameters
    ----------
    gain : (axis modes y, axis modes x) float
        Zero where a pair of modes was left out.
    cells_y : (>= rows, axis modes y) float
    cells_x : (axis modes x, >= columns) float
    rows, columns : int
        How many cells of the rectangle exist.
    """
    across = np.zeros((rows, gain.shape[1]))
    for row in range(rows):
        for k in range(gain.shape[0]):
            scale = cells_y[row, k]
            for i in range(gain.shape[1]):
                across[row, i] += scale * gain[k, i]
    covariance = np.zeros((rows, columns))
    for row in range(rows):
        for k in range(gain.shape[1]):
            scale = across[row, k]
            for column in range(columns):
                covariance[row, column] += scale * cells_x[k, column]
    return covariance


@numba.njit(cache=True)
def assimilate(mean: FloatArray, variance: FloatArray, covariance: FloatArray, innovation: float,
               innovation_variance: float) -> None:
    """Update the mean and variance of cells (rows, columns) in place for one measurement."""
    for row in range(covariance.shape[0]):
        for column in range(covariance.shape[1]):
            shared = covariance[row, column]
            mean[row, column] += shared * innovation / innovation_variance
            left = variance[row, column] - shared * shared / innovation_variance
            variance[row, column] = max(left, 0.0)
