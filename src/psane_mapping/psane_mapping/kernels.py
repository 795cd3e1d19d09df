# SPDX-License-Identifier: Apache-2.0
"""Covariance of the ground at two points, as a function of their distance alone."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from psane_mapping.errors import ParameterError
from psane_mapping.grid import FloatArray


class Kernel(Protocol):
    """A stationary, isotropic covariance."""

    @property
    def lengthscale(self) -> float:
        """Distance over which the ground changes [m]."""

    @property
    def deviation(self) -> float:
        """Prior standard deviation, in the unit of the mapped quantity."""

    def correlation(self, distance: FloatArray) -> FloatArray:
        """Return the correlation [-] at distances [m], any shape."""


@dataclass(frozen=True, kw_only=True)
class RadialBasis:
    """Squared exponential, ``exp(-d^2 / (2 l^2))``: very smooth ground (the paper's choice)."""

    lengthscale: float
    deviation: float

    def correlation(self, distance: FloatArray) -> FloatArray:
        """Return the correlation [-] at distances [m]."""
        return np.exp(-0.5 * (distance / self.lengthscale) ** 2)


@dataclass(frozen=True, kw_only=True)
class Matern32:
    """Matern with smoothness 3/2: ground with a slope everywhere, but kinks in it."""

    lengthscale: float
    deviation: float

    def correlation(self, distance: FloatArray) -> FloatArray:
        """Return the correlation [-] at distances [m]."""
        scaled = math.sqrt(3.0) * distance / self.lengthscale
        return np.asarray((1.0 + scaled) * np.exp(-scaled))


@dataclass(frozen=True, kw_only=True)
class Matern52:
    """Matern with smoothness 5/2: between `Matern32` and `RadialBasis`."""

    lengthscale: float
    deviation: float

    def correlation(self, distance: FloatArray) -> FloatArray:
        """Return the correlation [-] at distances [m]."""
        scaled = math.sqrt(5.0) * distance / self.lengthscale
        return np.asarray((1.0 + scaled + scaled**2 / 3.0) * np.exp(-scaled))


KERNELS: dict[str, type[RadialBasis] | type[Matern32] | type[Matern52]] = {
    'rbf': RadialBasis, 'matern32': Matern32, 'matern52': Matern52}


def kernel_named(name: str, lengthscale: float, deviation: float) -> Kernel:
    """Return the kernel of a name in `KERNELS`.

    Raises
    ------
    ParameterError
        For another name, or a lengthscale [m] or deviation that is not above 0.
    """
    if name not in KERNELS:
        raise ParameterError('kernel', name, f'one of {sorted(KERNELS)}')
    for label, value, unit in (('lengthscale', lengthscale, 'm'), ('deviation', deviation, '-')):
        if not (math.isfinite(value) and value > 0.0):
            raise ParameterError(label, value, 'a finite value above 0', unit)
    return KERNELS[name](lengthscale=lengthscale, deviation=deviation)


def reach_of(kernel: Kernel, tolerance: float) -> float:
    """Return the distance [m] at which the squared correlation has fallen to the tolerance.

    The squared correlation is the share of a cell's variance that one exact measurement at that
    distance would take away. For `RadialBasis` the reach is ``l sqrt(ln(1 / tolerance))``.
    """
    if tolerance <= 0.0:
        return math.inf
    near, far = 0.0, kernel.lengthscale
    while _correlation(kernel, far) ** 2 > tolerance:
        far *= 2.0
    for _ in range(60):
        middle = 0.5 * (near + far)
        above = _correlation(kernel, middle) ** 2 > tolerance
        near, far = (middle, far) if above else (near, middle)
    return far


def _correlation(kernel: Kernel, distance: float) -> float:
    return float(kernel.correlation(np.array(distance)))
