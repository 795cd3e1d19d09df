# SPDX-License-Identifier: Apache-2.0
"""Whether a task makes sense on its terrain, by the truth: said to people, never to the robot."""

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.grid import Grid
from psane_sim.runs.scoring import reachable_safe_cells
from psane_sim.terrains.terrain import Terrain


def nonsense_of(terrain: Terrain, start: tuple[float, float], goal: tuple[float, float] | None,
                threshold: float) -> list[str]:
    """Return what makes a task impossible, in words; an empty list where nothing does.

    Parameters
    ----------
    start, goal : (x, y), map frame [m]
        No goal where ground is to be explored.
    threshold : float
        Largest safe slip [-].
    """
    slip = float(terrain.true_slip(np.array(start)))
    if slip > threshold:
        return [f'the start is unsafe: its true slip is {slip:.2f}, above the threshold '
                f'{threshold:g}']
    if goal is None:
        return []
    config = MappingConfiguration()
    grid = Grid.over_workspace(config.min_x, config.min_y, config.max_x, config.max_y,
                               config.resolution)
    reachable = reachable_safe_cells(terrain, grid, np.array(start), threshold)
    row, column = grid.index_of(np.array(goal))
    if reachable[row, column]:
        return []
    slip = float(terrain.true_slip(np.array(goal)))
    return [f'the goal cannot be reached over safe ground (its true slip is {slip:.2f}); the run '
            'should end STALLED']
