# SPDX-License-Identifier: Apache-2.0
"""How fast a robot that knows the ground would be: the yardstick for those that must feel it."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from psane_planner.geodesic import distance_along, travel_time
from psane_sim.runs.kinematic import FIRM_SLIP
from psane_sim.terrains.terrain import Terrain


def truly_free(terrain: Terrain, threshold: float, clearance: float, border_width: float
               ) -> NDArray[np.bool_]:
    """Return where the centre may be, (rows, columns) bool on the terrain's own grid.

    Parameters
    ----------
    threshold : float
        Largest safe slip [-].
    clearance : float
        Least distance to unsafe ground [m].
    border_width : float
        Strip along the workspace's edge that is not to be used [m].
    """
    grid = terrain.grid
    usable = (terrain.slip <= threshold) & (grid.distance_to_border() > border_width + 1e-6)
    distance = ndimage.distance_transform_edt(np.pad(usable, 1))[1:-1, 1:-1]
    # From the centre of a cell to the edge of the nearest cell that is not usable.
    return np.asarray((distance - 0.5) * grid.resolution >= clearance)


def least_time(terrain: Terrain, start: tuple[float, float], goal: tuple[float, float], *,
               threshold: float, clearance: float, border_width: float, goal_tolerance: float,
               speed: float) -> float:
    """Return the least time from start to goal over truly safe ground [s]; infinite without a way.

    The robot loses speed to slip and none to turning.
    """
    free = truly_free(terrain, threshold, clearance, border_width)
    pace = speed * (1.0 - terrain.slip) / (1.0 - FIRM_SLIP)
    slowness = np.where(free, 1.0 / np.maximum(pace, 1e-6), np.inf)
    times = travel_time(slowness, terrain.grid, np.array(start))
    return float(times[_around(terrain, goal, goal_tolerance)].min())


def least_length(terrain: Terrain, start: tuple[float, float], goal: tuple[float, float], *,
                 threshold: float, clearance: float, border_width: float,
                 goal_tolerance: float) -> float:
    """Return the shortest truly safe way from start to goal [m]; infinite without a way."""
    free = truly_free(terrain, threshold, clearance, border_width)
    row, column = terrain.grid.index_of(np.array(start))
    if not free[row, column]:
        return float('inf')
    field = distance_along(free, terrain.grid, np.array(start))
    return float(field[_around(terrain, goal, goal_tolerance)].min())


def _around(terrain: Terrain, goal: tuple[float, float], tolerance: float
            ) -> NDArray[np.bool_]:
    """Return the cells (rows, columns) bool at which the goal counts as reached."""
    away = np.hypot(*(terrain.grid.points - goal).T).reshape(terrain.grid.shape)
    return np.asarray(away <= tolerance)
