# SPDX-License-Identifier: Apache-2.0
"""Make the terrain `env2`: winding firm corridors, a loop and dead ends, in soft ground.

Run ``python -m psane_sim.terrains.heterogeneous`` to write the shipped file anew.
"""

from pathlib import Path

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_sim.terrains.corridors import corridor_slip, smooth_line

START = (1.5, 7.6)
GOAL = (8.4, 2.2)
SEED = 2
WIDTH = 1.35

MAIN = ((1.5, 7.6), (2.8, 8.0), (3.9, 7.1), (4.1, 5.7), (5.1, 4.7), (6.5, 4.6), (7.3, 3.5),
        (8.4, 2.2))
"""The way from start to goal, corner by corner [m]."""

BRANCHES = (
    ((3.9, 7.1), (5.3, 7.9), (6.8, 7.5), (8.2, 8.1)),
    ((4.1, 5.7), (2.9, 4.9), (1.7, 4.0), (1.6, 2.6), (2.6, 1.6), (3.6, 1.7)),
    ((6.5, 4.6), (7.8, 5.2), (8.5, 6.3)),
)
"""Dead ends that a goal-seeker is drawn into [m]."""


def file_grid() -> Grid:
    """Return the grid of the shipped file."""
    return Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1)


def make_slip() -> FloatArray:
    """Return the slip of env2, (101, 101), before the border is raised."""
    lines = [smooth_line(points) for points in (MAIN, *BRANCHES)]
    slip = corridor_slip(file_grid(), lines, WIDTH, SEED, width_variation=0.06)
    return np.round(slip, 4)


def main() -> None:
    """Write the shipped file."""
    path = Path(__file__).parents[1] / 'data' / 'env2.npy'
    np.save(path, make_slip().astype(np.float32))
    print(path)


if __name__ == '__main__':
    main()
