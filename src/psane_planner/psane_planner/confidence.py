# SPDX-License-Identifier: Apache-2.0
"""Confidence intervals of slip that only ever narrow, until the data contradict them."""

import math
from typing import NamedTuple

import numpy as np

from psane_mapping.grid import FloatArray
from psane_planner.compiled import compiled
from psane_planner.errors import MapError
from psane_planner.transfer import Transfer
from psane_planner.window import Window


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
    version : int
        Number of updates that changed an interval.
    changed : Window or None
        Cells outside of it are as they were in the version before; None when all may differ.
    """

    lower: FloatArray
    upper: FloatArray
    newest: FloatArray
    resets: int
    version: int = 0
    changed: Window | None = None


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
        self._newest = np.full(shape, np.inf)
        self._last: tuple[FloatArray, FloatArray] | None = None
        self._version = 0
        self._changed: Window | None = None
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
        _check_shape(mean, std, self._lower.shape)
        changed = None if self._is_last(mean, std) else self._note_changes(mean, std)
        resets = 0
        if changed is not None:
            # The arrays of earlier bounds belong to whoever holds them.
            self._lower, self._upper, self._newest = (
                self._lower.copy(), self._upper.copy(), self._newest.copy())
            resets = self._narrow(mean[changed], std[changed], changed)
            self._version += 1
            self._changed = changed
            for array in (self._lower, self._upper, self._newest):
                array.setflags(write=False)
        self.total_resets += resets
        return Bounds(self._lower, self._upper, self._newest, resets, self._version,
                      self._changed)

    def move(self, transfer: Transfer) -> None:
        """Go on on a grid of another extent; nothing is known of cells that are new."""
        self._lower = transfer.of(self._lower, -np.inf)
        self._upper = transfer.of(self._upper, np.inf)
        self._newest = transfer.of(self._newest, np.inf)
        if self._last is not None:
            self._last = (transfer.of(self._last[0], np.nan), transfer.of(self._last[1], np.nan))
        self._version += 1
        self._changed = None

    def _note_changes(self, mean: FloatArray, std: FloatArray) -> Window | None:
        """Return where the map differs from the last one; there is nothing to do elsewhere.

        An interval that is intersected with the same c_t again stays what it is.
        """
        if self._last is None:
            changed: Window | None = Window(slice(0, mean.shape[0]), slice(0, mean.shape[1]))
        else:
            before, now = self._last, (mean, std)
            first_row, last_row, first_column, last_column = _differing(
                *(_as_read_only(array) for array in (*before, *now)))
            changed = None if last_row < 0 else Window(slice(first_row, last_row + 1),
                                                       slice(first_column, last_column + 1))
        if changed is not None:
            _check_numbers(mean[changed], std[changed])
            self._last = (_kept(mean), _kept(std))
        return changed

    def _is_last(self, mean: FloatArray, std: FloatArray) -> bool:
        """Tell whether these are the arrays that came last, which nobody can have changed."""
        return (self._last is not None and self._last[0] is mean and self._last[1] is std)

    def _narrow(self, mean: FloatArray, std: FloatArray, where: Window) -> int:
        """Intersect the intervals of a window; return how many were started over."""
        # Copies are all of one type, of which the compiled code needs to exist only once.
        lower, upper, newest = (array[where].copy()
                                for array in (self._lower, self._upper, self._newest))
        empty = _intersect(lower, upper, newest, mean.copy(), std.copy(), self._half_widths,
                           self._revoking)
        self._lower[where], self._upper[where], self._newest[where] = lower, upper, newest
        return empty


def _kept(array: FloatArray) -> FloatArray:
    """Return an array that nobody changes: itself where it is frozen."""
    return array.copy() if array.flags.writeable else array


def _as_read_only(array: FloatArray) -> FloatArray:
    """Return a view of the one type that there is compiled code for."""
    view = np.ascontiguousarray(array).view()
    view.setflags(write=False)
    return view


@compiled
def _differing(mean: FloatArray, std: FloatArray, new_mean: FloatArray, new_std: FloatArray
               ) -> tuple[int, int, int, int]:
    """Return first and last row, first and last column of what differs; a last row -1 if none."""
    rows, columns = mean.shape
    first_row, last_row, first_column, last_column = rows, -1, columns, -1
    for row in range(rows):
        for column in range(columns):
            one, other = mean[row, column], new_mean[row, column]
            if one == other or (math.isnan(one) and math.isnan(other)):
                one, other = std[row, column], new_std[row, column]
                if one == other or (math.isnan(one) and math.isnan(other)):
                    continue
            first_row, last_row = min(first_row, row), row
            first_column, last_column = min(first_column, column), max(last_column, column)
    return first_row, last_row, first_column, last_column


def _check_shape(mean: FloatArray, std: FloatArray, shape: tuple[int, ...]) -> None:
    for name, array in (('slip_mean', mean), ('slip_std', std)):
        if array.shape != shape:
            raise MapError(f'{name} has shape {array.shape}, expected {shape}')


def _check_numbers(mean: FloatArray, std: FloatArray) -> None:
    for name, array in (('slip_mean', mean), ('slip_std', std)):
        if np.isinf(array).any():
            raise MapError(f'{name} holds an infinite number; use NaN for no estimate')
    if (std < 0.0).any():
        raise MapError('slip_std holds a negative number')


@compiled
def _intersect(lower: FloatArray, upper: FloatArray, newest: FloatArray, mean: FloatArray,
               std: FloatArray, half_widths: float, revoking: float) -> int:
    """Narrow intervals (rows, columns) in place; return how many were empty and start over."""
    empty = 0
    for row in range(mean.shape[0]):
        for column in range(mean.shape[1]):
            middle, deviation = mean[row, column], std[row, column]
            if math.isnan(middle) or math.isnan(deviation):
                lower[row, column], upper[row, column] = -np.inf, np.inf
                newest[row, column] = np.inf
                continue
            low = middle - half_widths * deviation
            high = middle + half_widths * deviation
            kept_low, kept_high = max(lower[row, column], low), min(upper[row, column], high)
            if kept_low > kept_high:
                kept_low, kept_high = low, high
                empty += 1
            lower[row, column], upper[row, column] = kept_low, kept_high
            newest[row, column] = middle + revoking * deviation
    return empty
