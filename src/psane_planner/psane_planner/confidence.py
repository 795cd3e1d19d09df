# SPDX-License-Identifier: Apache-2.0
"""Confidence intervals of slip that only ever narrow, until the data contradict them."""

from typing import NamedTuple

import numpy as np

from psane_mapping.grid import FloatArray
from psane_planner.errors import MapError


class Bounds(NamedTuple):
    """Interval of slip of every cell.

    Parameters
    ----------
    lower, upper : (rows, columns) float [-], slip ratio
        Ends of the interval, infinite where nothing is known.
    newest : (rows, columns) float [-], slip ratio
        Upper end of c_t alone, at the narrower width that a certificate has to keep up with.
    resets : int
        Cells whose interval came out empty in this update and was started over.
    """

    lower: FloatArray
    upper: FloatArray
    newest: FloatArray
    resets: int


class ConfidenceIntervals:
    """C_t = C_{t-1} n c_t with c_t = mean -+ sqrt(beta) std, one interval per cell.

    Notes
    -----
    Jiang et al., section "Slip-ratio Prediction Confidence Interval". Two differences: an empty
    intersection means that the model was wrong, so that cell starts over with c_t and is counted;
    and a cell that has lost its estimate starts over with (-inf, inf).
    """

    def __init__(self, shape: tuple[int, int], confidence_scale: float,
                 revocation_scale: float) -> None:
        """Start with nothing known on a grid of (rows, columns)."""
        self._half_widths = float(np.sqrt(confidence_scale))
        self._revoking = float(np.sqrt(revocation_scale))
        self._lower = np.full(shape, -np.inf)
        self._upper = np.full(shape, np.inf)
        self.total_resets = 0

    def update(self, mean: FloatArray, std: FloatArray) -> Bounds:
        """Intersect with the interval of a new posterior.

        Parameters
        ----------
        mean, std : (rows, columns) float [-], slip ratio
            NaN where there is no estimate.

        Raises
        ------
        MapError
            For a wrong shape, a negative deviation or an infinite number.
        """
        _check(mean, std, self._lower.shape)
        half = self._half_widths * std
        unknown = np.isnan(mean) | np.isnan(std)
        lower = np.where(unknown, -np.inf, mean - half)
        upper = np.where(unknown, np.inf, mean + half)
        kept_lower = np.maximum(self._lower, lower)
        kept_upper = np.minimum(self._upper, upper)
        empty = (kept_lower > kept_upper) & ~unknown
        over = empty | unknown
        self._lower = np.where(over, lower, kept_lower)
        self._upper = np.where(over, upper, kept_upper)
        self._lower.setflags(write=False)
        self._upper.setflags(write=False)
        newest = np.where(unknown, np.inf, mean + self._revoking * std)
        resets = int(np.count_nonzero(empty))
        self.total_resets += resets
        return Bounds(self._lower, self._upper, newest, resets)


def _check(mean: FloatArray, std: FloatArray, shape: tuple[int, ...]) -> None:
    for name, array in (('slip_mean', mean), ('slip_std', std)):
        if array.shape != shape:
            raise MapError(f'{name} has shape {array.shape}, expected {shape}')
        if np.isinf(array).any():
            raise MapError(f'{name} holds an infinite number; use NaN for no estimate')
    if (std < 0.0).any():
        raise MapError('slip_std holds a negative number')
