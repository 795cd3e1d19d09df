# SPDX-License-Identifier: Apache-2.0
"""The dense Gaussian processes of other libraries, where they are installed, as yardsticks.

Each is made anew from all measurements, with the hyperparameters and the noise of each measurement
given, and asked for mean and standard deviation at every cell: what a map costs that is not
updated in place.
"""

from collections.abc import Callable
from importlib.util import find_spec

import numpy as np

from psane_mapping.grid import FloatArray
from psane_mapping.kernels import RadialBasis

Prediction = tuple[FloatArray, FloatArray]
Process = Callable[[RadialBasis, FloatArray, FloatArray, FloatArray, FloatArray], Prediction]

_CHUNK = 2000
"""Cells that GPyTorch is asked for at once; it holds their covariance in memory."""


def gpy(kernel: RadialBasis, points: FloatArray, values: FloatArray, noise: FloatArray,
        queries: FloatArray) -> Prediction:
    """Return GPy's mean and standard deviation at `queries` (m, 2)."""
    import GPy
    covariance = GPy.kern.RBF(2, variance=kernel.deviation**2, lengthscale=kernel.lengthscale)
    model = GPy.models.GPHeteroscedasticRegression(points, values[:, None], covariance)
    model.het_Gauss.variance = noise[:, None] ** 2
    mean, variance = model._raw_predict(queries)
    return mean[:, 0], np.sqrt(np.maximum(variance[:, 0], 0.0))


def gpytorch(kernel: RadialBasis, points: FloatArray, values: FloatArray, noise: FloatArray,
             queries: FloatArray) -> Prediction:
    """Return GPyTorch's mean and standard deviation at `queries` (m, 2), in double precision."""
    import gpytorch as library
    import torch

    class Model(library.models.ExactGP):  # type: ignore[misc, name-defined]
        def __init__(self) -> None:
            likelihood = library.likelihoods.FixedNoiseGaussianLikelihood(
                noise=torch.tensor(noise**2))
            super().__init__(torch.tensor(points), torch.tensor(values), likelihood)
            self.mean = library.means.ZeroMean()
            self.kernel = library.kernels.ScaleKernel(library.kernels.RBFKernel()).double()
            self.kernel.outputscale = kernel.deviation**2
            self.kernel.base_kernel.lengthscale = kernel.lengthscale

        def forward(self, x: torch.Tensor) -> object:
            return library.distributions.MultivariateNormal(self.mean(x), self.kernel(x))

    model = Model().eval()
    parts = []
    # Exact algebra, as the others do it, instead of conjugate gradients.
    with torch.no_grad(), library.settings.fast_computations(False, False, False):
        for first in range(0, len(queries), _CHUNK):
            found = model(torch.tensor(queries[first:first + _CHUNK]))
            parts.append((found.mean.numpy(), found.variance.numpy()))
    mean, variance = (np.concatenate(column) for column in zip(*parts, strict=True))
    return mean, np.sqrt(np.maximum(variance, 0.0))


def installed() -> dict[str, Process]:
    """Return the processes of the libraries that are installed, by name."""
    known: dict[str, tuple[str, Process]] = {'gpy': ('GPy', gpy),
                                             'gpytorch': ('gpytorch', gpytorch)}
    return {name: process for name, (module, process) in known.items()
            if find_spec(module) is not None}
