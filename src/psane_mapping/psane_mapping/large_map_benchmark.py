# SPDX-License-Identifier: Apache-2.0
"""Measure what a contact costs on a large map after a long walk, against a small map.

It is run as a process of its own, so that the memory is that of the maps and of nothing else:
``python -m psane_mapping.large_map_benchmark`` prints one JSON object.
"""

import argparse
import json
import re
import time
from pathlib import Path

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.gaussian_process import GridPosterior
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.kernels import RadialBasis

SMALL_SIZE, LARGE_SIZE = 10.0, 100.0
SMALL_CONTACTS, LARGE_CONTACTS = 1000, 20000
_STRIDE, _TURN, _FOOT_SPREAD = 0.025, 0.06, 0.2
_NOISE = (0.03, 0.1)
_CHECKED_SIDE, _CHECKED_REACH, _CHECKS = 2.0, 6.0, 4


def walk(count: int, size: float, rng: np.random.Generator) -> FloatArray:
    """Return where feet were set (count, 2) [m] on a winding walk that the border turns back."""
    heading = np.cumsum(rng.normal(0.0, _TURN, count))
    path = np.cumsum(_STRIDE * np.column_stack((np.cos(heading), np.sin(heading))), axis=0)
    folded = size - np.abs((path + size / 2.0) % (2.0 * size) - size)
    return np.clip(folded + rng.normal(0.0, _FOOT_SPREAD, (count, 2)), 0.0, size)


def field(points: FloatArray) -> FloatArray:
    """Return the slip of smooth ground at points (n, 2) [m]."""
    return np.asarray(0.5 + 0.4 * np.sin(points[:, 0]) * np.cos(points[:, 1]))


class _Walk:
    """Both maps over one workspace, fed by one walk."""

    def __init__(self, size: float, count: int, seed: int) -> None:
        config = MappingConfiguration()
        rng = np.random.default_rng(seed)
        self.points = walk(count, size, rng)
        self.noise = rng.uniform(*_NOISE, count)
        self.values = field(self.points) + rng.normal(0.0, self.noise)
        grid = Grid.over_workspace(0.0, 0.0, size, size, config.resolution)
        self.maps = [
            GridPosterior(grid, RadialBasis(lengthscale=config.lengthscale, deviation=deviation),
                          tolerance=config.tolerance)
            for deviation in (config.slip_prior_deviation, config.log_strength_prior_deviation)]

    def feed(self) -> FloatArray:
        """Take in all contacts; return the processor time of each [s]."""
        for posterior in self.maps:
            posterior.condition(self.points[0], 0.5, 0.1)
            posterior.reset()
        times = np.zeros(len(self.points))
        for number, point in enumerate(self.points):
            begin = time.process_time()
            for posterior in self.maps:
                posterior.condition(point, float(self.values[number]),
                                    float(self.noise[number]))
            times[number] = time.process_time() - begin
        return times

    def errors(self, seed: int) -> tuple[float, float, float]:
        """Return the largest differences from the dense process where it can be computed.

        Around a few places of the walk it is solved with all contacts within ten
        lengthscales, and compared on the cells of a square.

        Returns
        -------
        Of the mean, of the mean in deviations, of the deviation.
        """
        worst = np.zeros(3)
        chosen = np.random.default_rng(seed).choice(len(self.points), _CHECKS, replace=False)
        for centre in self.points[chosen]:
            worst = np.maximum(worst, self._errors_around(centre))
        return float(worst[0]), float(worst[1]), float(worst[2])

    def _errors_around(self, centre: FloatArray) -> FloatArray:
        posterior = self.maps[0]
        cells = posterior.grid.points
        inside = np.abs(cells - centre).max(axis=1) <= _CHECKED_SIDE / 2.0
        near = np.abs(self.points - centre).max(axis=1) <= _CHECKED_SIDE / 2.0 + _CHECKED_REACH
        near &= np.cumsum(near) <= 6000
        kernel = posterior.kernel
        points, cells = self.points[near], cells[inside]
        gram = _covariance(kernel.lengthscale, kernel.deviation, points, points)
        gram[np.diag_indices_from(gram)] += self.noise[near] ** 2
        cross = _covariance(kernel.lengthscale, kernel.deviation, points, cells)
        factor = cho_factor(gram, lower=True, overwrite_a=True)
        mean = cross.T @ cho_solve(factor, self.values[near])
        removed = (cross * cho_solve(factor, cross)).sum(axis=0)
        std = np.sqrt(np.maximum(kernel.deviation**2 - removed, 0.0))
        error = np.abs(posterior.mean.ravel()[inside] - mean)
        return np.array([error.max(), (error / std).max(),
                         np.abs(posterior.std.ravel()[inside] - std).max()])


def _covariance(lengthscale: float, deviation: float, one: FloatArray,
                other: FloatArray) -> FloatArray:
    square = ((one[:, None, 0] - other[None, :, 0]) ** 2
              + (one[:, None, 1] - other[None, :, 1]) ** 2)
    return np.asarray(deviation**2 * np.exp(-0.5 * square / lengthscale**2))


def measure(seed: int = 0) -> dict[str, float]:
    """Return the figures.

    Returns
    -------
    dict of float
        `small_map_update_ms`, `large_map_update_ms`: mean processor time for a contact in both
        maps, 101 x 101 cells and 1000 contacts, and 1001 x 1001 and 20 000 [ms];
        `large_map_cost_ratio`: their ratio [-]; `large_map_longest_ms`: the longest update, in
        which windows were brought back [ms]; `large_map_rss_mb`: largest memory of the
        process until then, all four maps read once [MB]; `large_map_mean_error`,
        `large_map_mean_error_in_std`, `large_map_std_error`: differences from the dense process.
    """
    small = _Walk(SMALL_SIZE, SMALL_CONTACTS, seed).feed()
    long = _Walk(LARGE_SIZE, LARGE_CONTACTS, seed)
    large = long.feed()
    for posterior in long.maps:
        _ = posterior.mean, posterior.std
    memory = _largest_memory()
    mean, in_std, std = long.errors(seed)
    return {
        'small_map_update_ms': 1e3 * float(small.mean()),
        'large_map_update_ms': 1e3 * float(large.mean()),
        'large_map_cost_ratio': float(large.mean() / small.mean()),
        'large_map_longest_ms': 1e3 * float(large.max()),
        'large_map_rss_mb': memory,
        'large_map_mean_error': mean, 'large_map_mean_error_in_std': in_std,
        'large_map_std_error': std,
    }


def _largest_memory() -> float:
    """Return the largest memory that this process had [MB].

    Not `getrusage`: there Linux hands on the memory of the process that started this one.
    """
    status = Path('/proc/self/status').read_text(encoding='ascii')
    found = re.search(r'^VmHWM:\s+(\d+) kB', status, re.MULTILINE)
    return int(found.group(1)) / 1024.0 if found else float('nan')


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seed', type=int, default=0)
    print(json.dumps(measure(parser.parse_args().seed)))


if __name__ == '__main__':
    main()
