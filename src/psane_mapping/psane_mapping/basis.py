# SPDX-License-Identifier: Apache-2.0
"""A few hundred smooth functions that span every map an RBF process can draw on a rectangle.

Notes
-----
The RBF covariance is the autocorrelation of a narrower Gaussian ``g``: white noise seen through
``g`` is the process. Sampling the white noise on a lattice of spacing ``l / 3`` leaves an aliasing
error of ``2 exp(-pi^2 9 / 2) ~ 1e-19`` (Poisson summation), below round-off. The process on
an interval is then ``G w`` with independent unit weights ``w``; the right singular vectors
of ``G`` rotate the weights into modes of falling variance, and the modes that carry nothing
are left out. The kernel is separable, so that products of modes of the two axes do for a rectangle
(the eigenfunctions of the covariance; Rasmussen and Williams 2006, section 4.3).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_mapping.kalman import axis_modes

_SPACINGS_PER_LENGTHSCALE = 3.0
_LATTICE_OVERHANG = 6.0
_NODES_PER_LENGTHSCALE = 12.0
ROUND_OFF = 1e-17


class AxisBasis:
    """Modes of a unit-variance RBF process on the interval [0, length].

    Parameters
    ----------
    length, lengthscale : float [m]
    floor : float
        Modes that carry a smaller share of the mean variance [-] are left out.
    """

    def __init__(self, length: float, lengthscale: float, floor: float) -> None:
        spacing = lengthscale / _SPACINGS_PER_LENGTHSCALE
        overhang = _LATTICE_OVERHANG * lengthscale
        self._lattice = np.arange(-overhang, length + overhang + spacing, spacing)
        self._lengthscale = lengthscale
        self._gain = math.sqrt(spacing / (lengthscale * math.sqrt(math.pi / 2.0)))
        count = int(length / lengthscale * _NODES_PER_LENGTHSCALE) + 24
        responses = self._responses(np.linspace(0.0, length, count)) / math.sqrt(count)
        _, singular, rotation = np.linalg.svd(responses, full_matrices=False)
        kept = singular**2 > max(floor, ROUND_OFF)
        self.shares = singular[kept] ** 2
        self._rotation = np.ascontiguousarray(rotation[kept].T)

    def __call__(self, positions: FloatArray) -> FloatArray:
        """Return the modes at positions (n,) [m], shape (n, modes) [-]."""
        return self._responses(np.atleast_1d(positions)) @ self._rotation

    def at(self, position: float) -> FloatArray:
        """Return the modes at one position [m], shape (modes,) [-]; the same, compiled."""
        return axis_modes(position, self._lattice, self._rotation, self._lengthscale, self._gain)

    def _responses(self, positions: FloatArray) -> FloatArray:
        scaled = (positions[:, None] - self._lattice) / self._lengthscale
        return self._gain * np.exp(-(scaled**2))


@dataclass(frozen=True)
class RectangleBasis:
    """Modes of a unit-variance RBF process on a rectangle, with their values at its cells.

    Parameters
    ----------
    along_y, along_x : AxisBasis
    mode_y, mode_x : (modes,) int
        The pair of axis modes whose product each mode is.
    cells_y : (rows, axis modes) float [-]
        Modes along y at the rows of cells.
    cells_x : (axis modes, columns) float [-]
        Modes along x at the columns of cells.
    """

    along_y: AxisBasis
    along_x: AxisBasis
    mode_y: NDArray[np.int64]
    mode_x: NDArray[np.int64]
    cells_y: FloatArray
    cells_x: FloatArray

    @classmethod
    def spanning(cls, size: tuple[float, float], cells: tuple[FloatArray, FloatArray],
                 lengthscale: float, floor: float) -> 'RectangleBasis':
        """Build the basis.

        Parameters
        ----------
        size : (height along y, width along x) of the rectangle [m]
        cells : centres of the cells along y and x, from the rectangle's corner [m]
        lengthscale : float [m]
        floor : float
            Modes that carry a smaller share of the mean variance [-] are left out.
        """
        along_y = AxisBasis(size[0], lengthscale, floor)
        along_x = AxisBasis(size[1], lengthscale, floor)
        shares = np.outer(along_y.shares, along_x.shares)
        mode_y, mode_x = np.nonzero(shares > max(floor, ROUND_OFF))
        return cls(along_y, along_x, mode_y, mode_x, along_y(cells[0]),
                   np.ascontiguousarray(along_x(cells[1]).T))

    @property
    def count(self) -> int:
        """Number of modes."""
        return int(self.mode_y.size)

    def at(self, points: FloatArray) -> FloatArray:
        """Return the modes at points (n, 2): x, y from the corner [m]; shape (n, modes) [-]."""
        along_y = self.along_y(points[:, 1])
        along_x = self.along_x(points[:, 0])
        return np.asarray(along_y[:, self.mode_y] * along_x[:, self.mode_x])

    def at_point(self, x: float, y: float) -> FloatArray:
        """Return the modes at one point from the corner [m], shape (modes,) [-]."""
        return self.along_y.at(y)[self.mode_y] * self.along_x.at(x)[self.mode_x]

    def variance_left_out(self) -> FloatArray:
        """Return the prior variance that the modes miss at each cell, (rows, columns) [-]."""
        kept = np.zeros((self.cells_y.shape[1], self.cells_x.shape[0]))
        kept[self.mode_y, self.mode_x] = 1.0
        return np.asarray(1.0 - self.cells_y**2 @ kept @ self.cells_x**2)


def mode_count(size: tuple[float, float], lengthscale: float, floor: float) -> int:
    """Return how many modes a rectangle of a size (height, width) [m] needs."""
    shares_y = AxisBasis(size[0], lengthscale, floor).shares
    shares_x = AxisBasis(size[1], lengthscale, floor).shares
    return int((np.outer(shares_y, shares_x) > max(floor, ROUND_OFF)).sum())
