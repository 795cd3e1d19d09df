# SPDX-License-Identifier: Apache-2.0
"""Measure the map against a dense Gaussian process.

Run it with ``python -m psane_mapping.benchmark [--json] [--full]``.
The dense process is scikit-learn's, fitted and predicted anew for a contact, with the same
hyperparameters and noise, in the same run.
"""

import argparse
import json
import os
import subprocess
import sys
import time

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.gaussian_process import GridPosterior
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.kernels import RadialBasis
from psane_mapping.peer_processes import installed

_TIMED_UPDATES = 200
_FIELD_NOISE = (0.03, 0.1)


def measure(full: bool = False, seed: int = 0) -> dict[str, float]:
    """Return the benchmark's figures.

    Parameters
    ----------
    full : bool
        True to measure with 2000 contacts and on a large map as well (two minutes longer); the
        errors are then those at 2000 contacts instead of 500.
    seed : int
        Of the places and values of the contacts.

    Returns
    -------
    dict of float
        `update_ms_n*`: one contact in, mean and std of all cells out, the median of 200 [ms];
        `sklearn_ms_n*`: the same by scikit-learn [ms]; `speedup_sklearn_n*`: their ratio [-];
        `max_mean_error`, `max_std_error`: largest differences over all cells with the default
        tolerance; `max_exact_error`: the larger of both with tolerance 0; `large_map_*`: see
        `large_map_benchmark.measure`. The same for GPy and GPyTorch where they are installed.
    """
    figures: dict[str, float] = {}
    for count in (500, 2000) if full else (500,):
        figures |= _against_dense(count, seed)
    return figures | _on_a_large_map(seed) if full else figures


def _on_a_large_map(seed: int) -> dict[str, float]:
    """Return the figures of a process of its own, which no other library's memory adds to."""
    done = subprocess.run(
        [sys.executable, '-m', 'psane_mapping.large_map_benchmark', '--seed', str(seed)],
        check=True, capture_output=True, text=True,
        env={**os.environ, 'OMP_NUM_THREADS': '1', 'OPENBLAS_NUM_THREADS': '1'})
    figures: dict[str, float] = json.loads(done.stdout)
    return figures


def _against_dense(count: int, seed: int) -> dict[str, float]:
    config = MappingConfiguration()
    grid = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, config.resolution)
    kernel = RadialBasis(lengthscale=config.lengthscale, deviation=config.slip_prior_deviation)
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 10.0, (count, 2))
    noise = rng.uniform(*_FIELD_NOISE, count)
    values = 0.5 + 0.4 * np.sin(points[:, 0]) * np.cos(points[:, 1]) + rng.normal(0.0, noise)

    local = GridPosterior(grid, kernel, tolerance=config.tolerance)
    update_ms = _fill(local, points, values, noise)
    exact = GridPosterior(grid, kernel, tolerance=0.0)
    _fill(exact, points, values, noise)
    mean, std, dense_ms = _dense(grid, kernel, points, values, noise)
    return {
        **_against_peers(count, update_ms, grid, kernel, points, values, noise, mean),
        f'update_ms_n{count}': update_ms,
        f'sklearn_ms_n{count}': dense_ms,
        f'speedup_sklearn_n{count}': dense_ms / update_ms,
        'max_mean_error': float(np.abs(local.mean - mean).max()),
        'max_std_error': float(np.abs(local.std - std).max()),
        'max_exact_error': float(max(np.abs(exact.mean - mean).max(),
                                     np.abs(exact.std - std).max())),
    }


def _against_peers(count: int, update_ms: float, grid: Grid, kernel: RadialBasis,
                   points: FloatArray, values: FloatArray, noise: FloatArray,
                   expected: FloatArray) -> dict[str, float]:
    """Return time, ratio and largest difference of the mean for each other library there is."""
    figures = {}
    for name, process in installed().items():
        times = []
        for _ in range(2):
            begin = time.perf_counter()
            mean, _ = process(kernel, points, values, noise, grid.points)
            times.append(1e3 * (time.perf_counter() - begin))
        figures[f'{name}_ms_n{count}'] = min(times)
        figures[f'speedup_{name}_n{count}'] = min(times) / update_ms
        figures[f'{name}_difference_n{count}'] = float(np.abs(mean - expected.ravel()).max())
    return figures


def _fill(posterior: GridPosterior, points: FloatArray, values: FloatArray,
          noise: FloatArray) -> float:
    """Take in all contacts; return the median time of the last ones [ms]."""
    times = []
    for point, value, deviation in zip(points, values, noise, strict=True):
        begin = time.perf_counter()
        posterior.condition(point, float(value), float(deviation))
        _ = posterior.mean, posterior.std
        times.append(time.perf_counter() - begin)
    return 1e3 * float(np.median(times[-_TIMED_UPDATES:]))


def _dense(grid: Grid, kernel: RadialBasis, points: FloatArray, values: FloatArray,
           noise: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return scikit-learn's mean and std (rows, columns), and its best time of two [ms]."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel

    times = []
    for _ in range(2):
        begin = time.perf_counter()
        regressor = GaussianProcessRegressor(
            ConstantKernel(kernel.deviation**2) * RBF(kernel.lengthscale), alpha=noise**2,
            optimizer=None)
        mean, std = regressor.fit(points, values).predict(grid.points, return_std=True)
        times.append(time.perf_counter() - begin)
    return mean.reshape(grid.shape), std.reshape(grid.shape), 1e3 * min(times)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--json', action='store_true', help='print one JSON object')
    parser.add_argument('--full', action='store_true',
                        help='measure with 2000 contacts and on a large map too')
    parser.add_argument('--seed', type=int, default=0)
    options = parser.parse_args()
    figures = measure(full=options.full, seed=options.seed)
    if options.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f'{name:28s} {value:.4g}')


if __name__ == '__main__':
    main()
