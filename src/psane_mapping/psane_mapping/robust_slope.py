# SPDX-License-Identifier: Apache-2.0
"""Slope through the origin of samples of which a few may be far off, and its error, compiled.

Sums are added up in the order of `numpy.sum`, so that results agree with it to the last bit.
"""

import math

import numba
import numpy as np

from psane_mapping.grid import FloatArray

_LANES = 8
_BLOCK = 128
_ROUNDS = 6
_HUBER = 1.5
_LEAST_SCALE = 1.0


@numba.njit(cache=True)
def pairwise_sum(values: FloatArray) -> float:
    """Return the sum of values (n,), added up in pairs (Higham 1993) as `numpy.sum` does."""
    count = values.size
    if count < _LANES:
        total = 0.0
        for value in values:
            total += value
        return total
    if count > _BLOCK:
        half = count // 2
        half -= half % _LANES
        return float(pairwise_sum(values[:half]) + pairwise_sum(values[half:]))
    lanes = values[:_LANES].copy()
    whole = count - count % _LANES
    for first in range(_LANES, whole, _LANES):
        for lane in range(_LANES):
            lanes[lane] += values[first + lane]
    total = (((lanes[0] + lanes[1]) + (lanes[2] + lanes[3]))
             + ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7])))
    for index in range(whole, count):
        total += values[index]
    return float(total)


@numba.njit(cache=True)
def _median(values: FloatArray) -> float:
    ordered = np.sort(values)
    middle = ordered.size // 2
    if ordered.size % 2 == 1:
        return float(ordered[middle])
    return 0.5 * float(ordered[middle - 1] + ordered[middle])


@numba.njit(cache=True, error_model='numpy')
def huber_slope(predictor: FloatArray, measured: FloatArray, weights: FloatArray,
                residual: FloatArray, rounds: int, bend: float, least_scale: float) -> float:
    """Return the slope, and write the samples' weights and residuals.

    Parameters
    ----------
    predictor, measured : (n,) float
        Scaled by the noise [-].
    weights, residual : (n,) float
        Written.
    rounds : int
        Of reweighting [count].
    bend : float
        Residual, as a multiple of the scale, beyond which a sample counts less [-].
    least_scale : float
        The scale is not below this [-].
    """
    slope = np.nan
    weights[:] = 1.0
    for _ in range(rounds):
        slope = (pairwise_sum(weights * predictor * measured)
                 / pairwise_sum(weights * predictor**2))
        residual[:] = measured - slope * predictor
        scale = 1.4826 * _median(np.abs(residual))
        if not scale > least_scale:
            scale = least_scale
        weights[:] = np.minimum(1.0, bend * scale / np.maximum(np.abs(residual), 1e-12))
    return float(slope)


@numba.njit(cache=True, error_model='numpy')
def regress(predictor: FloatArray, measured: FloatArray, depth: FloatArray
            ) -> tuple[float, float, float, float]:
    """Return what a regression through the origin tells, with Huber's weights.

    Their scale comes from the median absolute residual: a knock or a slipping grain that lasts a
    few samples does not tilt the line.

    Parameters
    ----------
    predictor, measured : (channels, n) float
        Scaled by the noise [-].
    depth : (n,) float [m]
        Above 0.

    Returns
    -------
    slope : float [-]
    r_squared : float
        Share of the weighted square of the measurement that the slope explains [-].
    scatter : float
        Standard error of the logarithm of the slope, from the residuals [-].
    inverse_depth : float
        Mean of 1 / depth, each sample weighted by how much it tells of the slope [1/m].
    """
    weights, residual = np.empty_like(measured), np.empty_like(measured)
    slope = huber_slope(predictor.reshape(-1), measured.reshape(-1), weights.reshape(-1),
                        residual.reshape(-1), _ROUNDS, _HUBER, _LEAST_SCALE)
    total = pairwise_sum((weights * measured**2).reshape(-1))
    missed = pairwise_sum((weights * residual**2).reshape(-1))
    r_squared = 1.0 - missed / total if total > 0.0 else 0.0
    leverage = weights * predictor**2
    scatter = _standard_error(residual, weights, leverage) / slope
    inverse_depth = (pairwise_sum((leverage / depth).reshape(-1))
                     / pairwise_sum(leverage.reshape(-1)))
    return slope, r_squared, scatter, inverse_depth


@numba.njit(cache=True, error_model='numpy')
def disagreement(predictor: FloatArray, measured: FloatArray) -> float:
    """Return by how much more than by chance the first two channels' log-slopes differ [-].

    Parameters
    ----------
    predictor, measured : (channels, n) float
        Scaled by the noise [-].
    """
    logs, variance = np.zeros(2), 0.0
    for channel in range(2):
        x, y = predictor[channel:channel + 1], measured[channel:channel + 1]
        if not pairwise_sum((x**2).reshape(-1)) > 0.0:
            return 0.0
        weights, residual = np.empty_like(y), np.empty_like(y)
        slope = huber_slope(x.reshape(-1), y.reshape(-1), weights.reshape(-1),
                            residual.reshape(-1), _ROUNDS, _HUBER, _LEAST_SCALE)
        if slope <= 0.0:
            return 0.0
        logs[channel] = math.log(slope)
        variance += (_standard_error(residual, weights, weights * x**2) / slope) ** 2
    return math.sqrt(max(0.0, (logs[0] - logs[1]) ** 2 - variance))


@numba.njit(cache=True, error_model='numpy')
def _standard_error(residual: FloatArray, weights: FloatArray, leverage: FloatArray) -> float:
    """Return the standard error of the slope, for samples (channels, n) alike in time.

    The number of samples is divided by ``(1 + r) / (1 - r)``, r being the correlation of
    neighbouring residuals (an AR(1) process); their scale is not below that of the noise.
    """
    misfit = pairwise_sum((weights * residual**2).reshape(-1))
    scale = max(_LEAST_SCALE, math.sqrt(misfit / pairwise_sum(weights.reshape(-1))))
    power = pairwise_sum((residual**2).reshape(-1))
    neighbours = pairwise_sum((residual[:, 1:] * residual[:, :-1]).reshape(-1))
    repeated = neighbours / power if power > 0.0 else 0.0
    repeated = min(max(repeated, 0.0), 1.0 - 1.0 / residual.shape[1])
    inflation = (1.0 + repeated) / (1.0 - repeated)
    return scale * math.sqrt(inflation / pairwise_sum(leverage.reshape(-1)))
