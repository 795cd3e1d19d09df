# SPDX-License-Identifier: Apache-2.0
"""Maps as int8 cells of an OccupancyGrid, rounded so that no ground looks safer than it is.

A cell is 0..100, or -1 where there is no estimate (NaN). Slip is 1 % a step and rounded up, its
standard deviation is `std_scale` a step and rounded up: the decoded upper bound is never below
the true one. Strength is logarithmic between two documented ends and rounded down.
"""

import math

import numba
import numpy as np
from numpy.typing import NDArray

from psane_mapping.errors import ParameterError
from psane_mapping.grid import FloatArray

Cells = NDArray[np.int8]

UNKNOWN = -1
STEPS = 100
SLIP_STEP = 1.0 / STEPS
_WHOLE = 1e-9


def encode_slip_mean(mean: FloatArray) -> Cells:
    """Return slip ratios as cells, rounded up; below 0 is shown as 0, above 1 as 1."""
    return _encode_up(mean, SLIP_STEP)


def decode_slip_mean(cells: Cells) -> FloatArray:
    """Return slip ratios [-] from cells; NaN where there is no estimate."""
    return _decode(cells, SLIP_STEP)


def encode_std(std: FloatArray, std_scale: float) -> Cells:
    """Return standard deviations as cells, rounded up.

    Raises
    ------
    ParameterError
        When one does not fit below ``100 std_scale``: it would be shown too small.
    """
    largest = float(np.nanmax(std, initial=0.0))
    if not (math.isfinite(std_scale) and std_scale > 0.0):
        raise ParameterError('std_scale', std_scale, 'a finite value above 0')
    if largest > STEPS * std_scale * (1.0 + 1e-9):
        raise ParameterError('std_scale', std_scale,
                             f'at least {largest / STEPS:g}, to hold a deviation of {largest:g}')
    return _encode_up(std, std_scale)


def decode_std(cells: Cells, std_scale: float) -> FloatArray:
    """Return standard deviations from cells; NaN where there is no estimate."""
    return _decode(cells, std_scale)


def encode_log_strength(mean: FloatArray, lowest: float, highest: float) -> Cells:
    """Return log-strengths as cells, rounded down; `lowest` and `highest` are strengths [-]."""
    step = _log_step(lowest, highest)
    return _encode((mean - math.log(lowest)) / step, is_up=False)


def decode_log_strength(cells: Cells, lowest: float, highest: float) -> FloatArray:
    """Return log-strengths [-] from cells; NaN where there is no estimate."""
    return _decode(cells, _log_step(lowest, highest)) + math.log(lowest)


def _log_step(lowest: float, highest: float) -> float:
    if not 0.0 < lowest < highest < math.inf:
        raise ParameterError('highest', highest, f'a finite value above lowest = {lowest:g} > 0')
    return math.log(highest / lowest) / STEPS


def _encode_up(values: FloatArray, step: float) -> Cells:
    return _encode(np.asarray(values, dtype=np.float64) / step, is_up=True)


def _encode(steps: FloatArray, is_up: bool) -> Cells:
    steps = np.asarray(steps, dtype=np.float64)
    cells = np.empty(steps.shape, dtype=np.int8)
    _round_to_cells(np.ascontiguousarray(steps).reshape(-1), is_up, cells.reshape(-1))
    return cells


@numba.njit(cache=True)
def _round_to_cells(steps: FloatArray, is_up: bool, cells: Cells) -> None:
    """Round steps (n,) and write them to cells (n,)."""
    for i in range(steps.size):
        value = steps[i]
        if not math.isfinite(value):
            cells[i] = UNKNOWN
            continue
        rounded = np.rint(value)
        # A value that is a whole step up to round-off is that step, and not the next one.
        if not abs(value - rounded) < _WHOLE:
            rounded = math.ceil(value) if is_up else math.floor(value)
        cells[i] = int(min(max(rounded, 0.0), float(STEPS)))


def _decode(cells: Cells, step: float) -> FloatArray:
    cells = np.asarray(cells)
    return np.where(cells >= 0, cells * step, np.nan)
