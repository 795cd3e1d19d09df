# SPDX-License-Identifier: Apache-2.0
"""Slip of winding firm corridors through soft ground, with sharp sides."""

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from psane_mapping.grid import FloatArray, Grid

SIDE_GRADIENT = 1.6
"""How fast slip rises across the side of a corridor [1/m]."""


def smooth_line(points: Sequence[tuple[float, float]], spacing: float = 0.02) -> FloatArray:
    """Return a smooth curve through points, (n, 2), as closely spaced points [m]."""
    nodes = np.asarray(points, dtype=np.float64)
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))))
    spline = CubicSpline(along, nodes)
    return np.asarray(spline(np.arange(0.0, along[-1] + spacing, spacing)))


def corridor_slip(grid: Grid, lines: Sequence[FloatArray], width: float, seed: int, *,
                  width_variation: float = 0.1, firm: float = 0.1, soft: float = 0.97
                  ) -> FloatArray:
    """Return slip (rows, columns) that is low along lines and high elsewhere.

    Parameters
    ----------
    grid : Grid
    lines : sequence of (n, 2) float, map frame [m]
        Centre lines.
    width : float
        Mean width of the ground below slip 0.5 [m].
    seed : int
        Of the corridors' uneven sides and floor.
    width_variation : float
        Standard deviation of half the width [m].
    firm, soft : float
        Slip in the middle of a corridor, and far from one [-].
    """
    generator = np.random.default_rng(seed)
    distance, _ = cKDTree(np.vstack(lines)).query(grid.points)
    distance = distance.reshape(grid.shape)
    uneven = _smooth_noise(generator, grid, 0.7) * width_variation
    floor = firm + 0.04 * _smooth_noise(generator, grid, 0.5)
    side = 0.5 + SIDE_GRADIENT * (distance + uneven - width / 2.0)
    return np.clip(np.maximum(side, floor), 0.02, soft)


def _smooth_noise(generator: np.random.Generator, grid: Grid, length: float) -> FloatArray:
    """Return noise of standard deviation 1, smooth over `length` [m], cut at 2.5."""
    noise = gaussian_filter(generator.standard_normal(grid.shape), length / grid.resolution,
                            mode='reflect')
    return np.asarray(np.clip(noise / noise.std(), -2.5, 2.5))
