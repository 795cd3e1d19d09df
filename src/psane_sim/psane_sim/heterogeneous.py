# SPDX-License-Identifier: Apache-2.0
"""Make the terrain `env2`: winding firm corridors, a loop and dead ends, in soft ground.

Run ``python -m psane_sim.heterogeneous`` to write the shipped file anew.
"""

from pathlib import Path

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_sim.corridors import corridor_slip, smooth_line

START = (1.3, 8.5)
GOAL = (8.5, 1.6)
SEED = 2
WIDTH = 1.2

MAIN = ((1.3, 8.5), (2.6, 8.7), (3.5, 7.9), (3.0, 6.7), (1.9, 5.9), (1.6, 4.6), (2.6, 3.7),
        (4.0, 4.1), (5.0, 5.2), (6.3, 5.6), (7.5, 4.9), (7.4, 3.6), (6.5, 2.7), (7.0, 1.7),
        (8.5, 1.6))
"""The way from start to goal, corner by corner [m]."""

BRANCHES = (
    ((3.5, 7.9), (4.9, 8.5), (6.2, 8.0), (7.4, 8.4)),
    ((2.6, 3.7), (2.3, 2.5), (3.1, 1.5), (4.2, 1.5)),
    ((7.5, 4.9), (8.3, 5.5), (8.6, 6.4)),
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
    path = Path(__file__).parent / 'data' / 'env2.npy'
    np.save(path, make_slip().astype(np.float32))
    print(path)


if __name__ == '__main__':
    main()
