# SPDX-License-Identifier: Apache-2.0
"""Lengthscale and deviation of the ground from a mission's samples, by marginal likelihood."""

import math
import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from psane_mapping.errors import ShapeError
from psane_mapping.grid import FloatArray
from psane_mapping.kernels import Kernel, kernel_named

FEWEST = 20
"""Least samples to fit with [count]."""

_SMOOTHNESS = {'matern32': 1.5, 'matern52': 2.5}


@dataclass(frozen=True, kw_only=True)
class Measurements:
    """Values of one quantity at points.

    Parameters
    ----------
    points : (n, 2) float, map frame [m]
    values : (n,) float
    deviations : (n,) float
        Standard deviation of each value's noise.
    """

    points: FloatArray
    values: FloatArray
    deviations: FloatArray

    def where(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> 'Measurements':
        """Return those at indices, or where a mask is true."""
        return Measurements(points=self.points[chosen], values=self.values[chosen],
                            deviations=self.deviations[chosen])


@dataclass(frozen=True, kw_only=True)
class Prior:
    """What is assumed of the ground: a kernel (see `KERNELS`) around a constant mean.

    Parameters
    ----------
    kernel_name : str
    lengthscale : float [m]
    deviation, mean : float
        In the unit of the measurements.
    """

    kernel_name: str
    lengthscale: float
    deviation: float
    mean: float

    @property
    def kernel(self) -> Kernel:
        """The covariance."""
        return kernel_named(self.kernel_name, self.lengthscale, self.deviation)


@dataclass(frozen=True, kw_only=True)
class Score:
    """How well a prior predicts measurements that it was not fitted to.

    Parameters
    ----------
    log_density : float
        Mean logarithm of the predictive density; higher is better.
    rmse : float
        Of the predicted mean.
    normalised_rms : float
        Of the error divided by its predicted deviation; 1 is honest, above is over-confident [-].
    """

    log_density: float
    rmse: float
    normalised_rms: float


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Where to look: closed ranges of lengthscale [m] and of the ground's deviation."""

    lengthscale: tuple[float, float] = (0.1, 5.0)
    deviation: tuple[float, float] = (0.05, 5.0)


def split(count: int, share: float, seed: int, block: int = 10
          ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return masks (n,) of the measurements to fit to and of those to hold out.

    Whole blocks of consecutive measurements are held out. A single one between its neighbours
    of the same walk would be predicted from almost the same spot, by any hyperparameters.
    """
    blocks = np.arange(count) // block
    number = int(blocks[-1]) + 1 if count else 0
    chosen = np.random.default_rng(seed).permutation(number)[:max(1, round(share * number))]
    held_out = np.isin(blocks, chosen)
    return ~held_out, held_out


def fit(measurements: Measurements, start: Prior, bounds: Bounds, restarts: int = 4,
        most: int = 800, seed: int = 0) -> Prior:
    """Return the prior of the highest marginal likelihood; the mean stays as it is.

    Parameters
    ----------
    most : int
        Largest number of measurements to use; more are thinned out evenly (the cost is cubic).

    Raises
    ------
    ShapeError
        With fewer than `FEWEST` measurements.
    """
    count = measurements.values.size
    if count < FEWEST:
        raise ShapeError(f'{count} samples, expected at least {FEWEST} to fit to')
    if count > most:
        measurements = measurements.where(np.linspace(0, count - 1, most).astype(np.int64))
    regressor = _regressor(start, measurements.deviations, bounds, restarts, seed)
    with warnings.catch_warnings():
        # An optimum on a bound is worth a word to the user, who is told by `on_bound`.
        warnings.simplefilter('ignore')
        regressor.fit(measurements.points, measurements.values - start.mean)
    amplitude, shape = regressor.kernel_.k1, regressor.kernel_.k2
    return replace(start, lengthscale=float(shape.length_scale),
                   deviation=math.sqrt(float(amplitude.constant_value)))


def score(prior: Prior, known: Measurements, held_out: Measurements) -> Score:
    """Return how well a prior predicts held-out measurements from those that are known."""
    regressor = _regressor(prior, known.deviations, None, 0, 0)
    regressor.fit(known.points, known.values - prior.mean)
    mean, std = regressor.predict(held_out.points, return_std=True)
    error = held_out.values - prior.mean - mean
    variance = std**2 + held_out.deviations**2
    density = -0.5 * (error**2 / variance + np.log(2.0 * math.pi * variance))
    return Score(log_density=float(density.mean()), rmse=float(np.sqrt(np.mean(error**2))),
                 normalised_rms=float(np.sqrt(np.mean(error**2 / variance))))


def on_bound(prior: Prior, bounds: Bounds) -> list[str]:
    """Return the names of the hyperparameters that ended at an end of their range."""
    return [name for name in ('lengthscale', 'deviation')
            if any(math.isclose(getattr(prior, name), end, rel_tol=1e-3)
                   for end in getattr(bounds, name))]


def _regressor(prior: Prior, deviations: FloatArray, bounds: Bounds | None, restarts: int,
               seed: int) -> Any:
    """Return scikit-learn's regressor; without bounds it keeps the hyperparameters."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Matern

    length_bounds: Any = 'fixed' if bounds is None else bounds.lengthscale
    variance_bounds: Any = 'fixed' if bounds is None else tuple(
        end**2 for end in bounds.deviation)
    variance = ConstantKernel(prior.deviation**2, variance_bounds)
    smoothness = _SMOOTHNESS.get(prior.kernel_name)
    shape = (RBF(prior.lengthscale, length_bounds) if smoothness is None else
             Matern(prior.lengthscale, length_bounds, nu=smoothness))
    return GaussianProcessRegressor(
        variance * shape, alpha=deviations**2, n_restarts_optimizer=restarts,
        optimizer=None if bounds is None else 'fmin_l_bfgs_b', random_state=seed)
