# SPDX-License-Identifier: Apache-2.0
"""How far strides carry a robot on ground of each strength, whatever it steers meanwhile.

Notes
-----
The calibrated slip curve is that of a straight walk. A robot that steers by different sweeps on
its two sides loses way besides, the more the softer the ground is: on ground where a straight walk
slips by .24 a tight arc advances half as far as on firm ground. So a stride's advance says nothing
of slip until it is compared with strides of the same sweeps. `calibrate` walks them all on uniform
ground.
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from psane_mapping.errors import ParameterError
from psane_mapping.grid import FloatArray

COLUMNS = ['strength', 'mean_rad', 'half_difference_rad', 'advance_m', 'turn_rad', 'slip']


@dataclass(frozen=True)
class SteeredWalks:
    """Advance of a stride over strength of the ground, mean and half difference of the sweeps.

    Parameters
    ----------
    strength : (n,) float [-]
        Rising.
    mean, half : (k,), (l,) float [rad]
        Of the sweeps of the two sides; both begin at 0.
    advance, turn : (n, k, l) float [m], [rad]
        Along the body's heading, and of the heading, in one stride.
    slip : (n,) float [-]
        Of a straight walk on the same ground.
    """

    strength: FloatArray
    mean: FloatArray
    half: FloatArray
    advance: FloatArray
    turn: FloatArray
    slip: FloatArray

    def advances(self, mean: FloatArray, half: FloatArray) -> FloatArray:
        """Return the advance of a stride on each ground, (m, n) [m], for sweeps (m,) [rad]."""
        column, right = _between(self.mean, mean)
        row, up = _between(self.half, np.abs(half))
        table = np.moveaxis(self.advance, 0, -1)
        right, up = right[:, None], up[:, None]
        low = (1.0 - right) * table[column, row] + right * table[column + 1, row]
        high = (1.0 - right) * table[column, row + 1] + right * table[column + 1, row + 1]
        return np.asarray((1.0 - up) * low + up * high)

    def slip_of(self, way: float, ways: FloatArray) -> float:
        """Return the slip of a straight walk on ground where the same sweeps lead as far.

        Parameters
        ----------
        way : float [m]
            That was made.
        ways : (n,) float [m]
            That the same sweeps make on each ground.

        Notes
        -----
        Linear between the grounds. Beyond them slip changes by the share of the way by which the
        robot went farther, or less far, so that nothing is cut off.
        """
        rising = np.maximum.accumulate(ways)
        if way > rising[-1]:
            return float(self.slip[-1] - (way - rising[-1]) / rising[-1])
        if way < rising[0]:
            return float(self.slip[0] + (rising[0] - way) / rising[-1])
        return float(np.interp(way, rising, self.slip))

    def write(self, path: Path) -> None:
        """Write the table as CSV."""
        with path.open('w', newline='') as file:
            writer = csv.writer(file, lineterminator='\n')
            writer.writerow(COLUMNS)
            for (i, j, k), advance in np.ndenumerate(self.advance):
                writer.writerow([f'{value:.5g}' for value in (
                    self.strength[i], self.mean[j], self.half[k], advance, self.turn[i, j, k],
                    self.slip[i])])


def _between(grid: FloatArray, values: FloatArray) -> tuple[np.ndarray, FloatArray]:
    """Return the interval of each value and where in it the value lies; ends hold beyond."""
    values = np.clip(values, grid[0], grid[-1])
    index = np.clip(np.searchsorted(grid, values, side='right') - 1, 0, len(grid) - 2)
    return index, (values - grid[index]) / (grid[index + 1] - grid[index])


def read_walks(path: Path) -> SteeredWalks:
    """Read a table.

    Raises
    ------
    ParameterError
        When the file is not such a table.
    """
    with path.open(newline='') as file:
        rows = list(csv.reader(file))
    if not rows or rows[0] != COLUMNS:
        raise ParameterError('walks', str(path), f'a table with the columns {COLUMNS}')
    table = np.array(rows[1:], dtype=np.float64)
    strength, mean, half = (np.unique(table[:, column]) for column in range(3))
    shape = (len(strength), len(mean), len(half))
    if len(table) != np.prod(shape):
        raise ParameterError('walks', str(path), f'{np.prod(shape)} rows, one for each '
                             f'combination, not {len(table)}')
    table = table[np.lexsort(table[:, 2::-1].T)]
    return SteeredWalks(strength, mean, half, table[:, 3].reshape(shape),
                        table[:, 4].reshape(shape), table[:, 5].reshape(shape)[:, 0, 0])
