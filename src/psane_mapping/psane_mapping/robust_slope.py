# SPDX-License-Identifier: Apache-2.0
"""Slope through the origin of samples of which a few may be far off, compiled.

Sums are added up in the order of `numpy.sum`, so that results agree with it to the last bit.
"""

import numba
import numpy as np

from psane_mapping.grid import FloatArray

_LANES = 8
_BLOCK = 128


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
