# SPDX-License-Identifier: Apache-2.0
"""The posterior of one window of ground, kept exactly and updated one measurement at a time.

A window serves a block of cells and listens to every measurement in a rectangle around it. Both
representations answer one question: how is a new measurement correlated with the window's cells,
given all measurements before it?
"""

from typing import NamedTuple, Protocol

import numpy as np
from scipy.linalg import solve_triangular

from psane_mapping.basis import RectangleBasis
from psane_mapping.grid import FloatArray
from psane_mapping.kalman import observe, packed_identity, spread
from psane_mapping.kernels import Kernel


class Evidence(NamedTuple):
    """What one measurement tells a window.

    Parameters
    ----------
    covariance : (rows, columns) float
        Of the measured value with each cell, before the measurement.
    innovation : float
        Measured value less its prediction.
    innovation_variance : float
        Of the prediction plus the noise.
    """

    covariance: FloatArray
    innovation: float
    innovation_variance: float


class Window(Protocol):
    """A block of cells with the posterior of the ground around it."""

    def observe(self, x: float, y: float, value: float, variance: float) -> Evidence:
        """Take in a measurement at a point from the window's corner [m]; the prior mean is 0."""


class SpectralWindow:
    """RBF ground as independent modes; cost and memory do not depend on the history.

    Every measurement is absorbed into the mean and covariance of the modes' weights. Those are
    sufficient statistics, so any number of measurements of one place is merged without bias.

    Parameters
    ----------
    basis : RectangleBasis
    deviation : float
        Prior standard deviation of the ground.
    shape : (rows, columns) of the cells it serves, at most the basis's own.
    """

    def __init__(self, basis: RectangleBasis, deviation: float, shape: tuple[int, int]) -> None:
        self._basis = basis
        self._deviation = deviation
        self._shape = shape
        self._weights = np.zeros(basis.count)
        self._covariance = packed_identity(basis.count)
        self._pending, self._pending_variance = np.zeros(basis.count), 1.0

    def observe(self, x: float, y: float, value: float, variance: float) -> Evidence:
        """Take in a measurement at a point from the window's corner [m]; the prior mean is 0."""
        gain, innovation, innovation_variance = self._absorb(x, y, value, variance)
        basis = self._basis
        spectrum = np.zeros((basis.cells_y.shape[1], basis.cells_x.shape[0]))
        spectrum[basis.mode_y, basis.mode_x] = self._deviation * gain
        covariance = spread(spectrum, basis.cells_y, basis.cells_x, *self._shape)
        return Evidence(covariance, innovation, innovation_variance)

    def restore(self, records: FloatArray) -> None:
        """Take in measurements (n, 4): x, y [m], value, variance; equal to the last bit."""
        for record in records.tolist():
            self._absorb(*record)

    def _absorb(self, x: float, y: float, value: float, variance: float
                ) -> tuple[FloatArray, float, float]:
        features = self._deviation * self._basis.at_point(x, y)
        taken = observe(self._covariance, self._weights, self._pending, self._pending_variance,
                        features, value, variance)
        self._pending, _, self._pending_variance = taken
        return taken


class DenseWindow:
    """Ground with any kernel, by a growing Cholesky factor over the measured places.

    Exact, but its cost grows with the number of distinct places. Measurements of one place (within
    `merge_distance`) are merged into their precision-weighted mean whenever the factor has
    grown to twice what it needs.

    Parameters
    ----------
    kernel : Kernel
    cells : (rows * columns, 2) float [m]
        Centres of the cells, from the window's corner.
    shape : (rows, columns)
    merge_distance : float
        Edge of the squares in which measurements are merged [m]; 0 merges equal places only.
    """

    _SLACK = 64

    def __init__(self, kernel: Kernel, cells: FloatArray, shape: tuple[int, int],
                 merge_distance: float) -> None:
        self._kernel = kernel
        self._cells = cells
        self._shape = shape
        self._merge_distance = merge_distance
        self._sites: dict[tuple[float, float], FloatArray] = {}
        self._count = 0
        self._points = np.zeros((0, 2))
        self._factor = np.zeros((0, 0))
        self._whitened = np.zeros(0)
        self._shared = np.zeros((0, cells.shape[0]))
        self._allocate(self._SLACK)

    def observe(self, x: float, y: float, value: float, variance: float) -> Evidence:
        """Take in a measurement at a point from the window's corner [m]; the prior mean is 0."""
        if self._count >= 2 * len(self._sites) + self._SLACK:
            self._rebuild()
        elif self._count == self._factor.shape[0]:
            self._allocate(2 * self._count)
        n = self._count
        point = np.array([[x, y]])
        row = solve_triangular(self._factor[:n, :n], self._prior(self._points[:n], point)[:, 0],
                               lower=True) if n else np.zeros(0)
        innovation = value - float(row @ self._whitened[:n])
        innovation_variance = self._kernel.deviation**2 + variance - float(row @ row)
        innovation_variance = max(innovation_variance, variance)
        covariance = self._prior(point, self._cells)[0] - row @ self._shared[:n]
        self._append(point[0], row, innovation, innovation_variance, covariance)
        self._remember(x, y, value, variance)
        return Evidence(covariance.reshape(self._shape), innovation, innovation_variance)

    def _prior(self, one: FloatArray, other: FloatArray) -> FloatArray:
        distance = np.sqrt(((one[:, None] - other[None]) ** 2).sum(axis=-1))
        return self._kernel.deviation**2 * self._kernel.correlation(distance)

    def _append(self, point: FloatArray, row: FloatArray, innovation: float,
                innovation_variance: float, covariance: FloatArray) -> None:
        n = self._count
        pivot = np.sqrt(innovation_variance)
        self._points[n] = point
        self._factor[n, :n] = row
        self._factor[n, n] = pivot
        self._whitened[n] = innovation / pivot
        self._shared[n] = covariance / pivot
        self._count = n + 1

    def _remember(self, x: float, y: float, value: float, variance: float) -> None:
        edge = self._merge_distance
        key = (x // edge, y // edge) if edge > 0.0 else (x, y)
        sums = np.array([x, y, value, 1.0]) / variance
        self._sites[key] = self._sites.get(key, np.zeros(4)) + sums

    def _allocate(self, capacity: int) -> None:
        n = self._count
        points, factor = np.zeros((capacity, 2)), np.zeros((capacity, capacity))
        whitened, shared = np.zeros(capacity), np.zeros((capacity, self._cells.shape[0]))
        if n:
            points[:n], factor[:n, :n] = self._points[:n], self._factor[:n, :n]
            whitened[:n], shared[:n] = self._whitened[:n], self._shared[:n]
        self._points, self._factor = points, factor
        self._whitened, self._shared = whitened, shared

    def _rebuild(self) -> None:
        """Start again from one measurement for each distinct place."""
        sums = np.array(list(self._sites.values()))
        precision = sums[:, 3]
        places, values = sums[:, :2] / precision[:, None], sums[:, 2] / precision
        n = precision.size
        self._count = 0
        self._allocate(n + self._SLACK)
        self._factor[:n, :n] = np.linalg.cholesky(
            self._prior(places, places) + np.diag(1.0 / precision))
        self._points[:n] = places
        lower = self._factor[:n, :n]
        self._whitened[:n] = solve_triangular(lower, values, lower=True)
        self._shared[:n] = solve_triangular(lower, self._prior(places, self._cells), lower=True)
        self._count = n
