# SPDX-License-Identifier: Apache-2.0
"""A terrain: slip over the workspace, and the strength of the ground that makes it."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray, Grid
from psane_mapping.slip import CalibratedSlipCurve
from psane_sim.soils.ground_surface import HeightField, height_at
from psane_sim.soils.strength_field import StrengthField, interpolate

WORKSPACE = (0.0, 0.0, 10.0, 10.0)
"""min x, min y, max x, max y of every terrain, map frame [m]."""

RESOLUTION = 0.05
"""Spacing at which slip and strength are stored; between the samples they are bilinear [m]."""

BORDER_SLOPE = 2.0
"""How fast slip falls from 1 at the workspace's edge [1/m]."""

STRENGTH_RANGE = (0.015, 3.0)
"""Strength of ground with slip 1, and of ground that hardly slips [-]."""

_LOG_LINEAR_FROM = 0.9


def terrain_grid() -> Grid:
    """Return the grid on which terrains are stored."""
    return Grid.over_workspace(*WORKSPACE, RESOLUTION)


def strength_of_slip(slip: FloatArray) -> FloatArray:
    """Return the strength that makes a slip.

    Parameters
    ----------
    slip : (...) float, 0..1 [-]

    Returns
    -------
    (...) float [-]
        The calibrated curve's inverse up to slip 0.9; above it log-linear down to strength
        0.015, so that ground with slip 1 really holds a robot.
    """
    slip = np.asarray(slip, dtype=np.float64)
    curve = CalibratedSlipCurve()
    low, high = STRENGTH_RANGE
    firm = np.clip(curve.inverse(np.clip(slip, curve.slip(high), _LOG_LINEAR_FROM)), low, high)
    knee = float(curve.inverse(np.array(_LOG_LINEAR_FROM)))
    share = np.clip((slip - _LOG_LINEAR_FROM) / (1.0 - _LOG_LINEAR_FROM), 0.0, 1.0)
    soft = knee * (low / knee) ** share
    return np.where(slip > _LOG_LINEAR_FROM, soft, firm)


def raise_border(slip: FloatArray, grid: Grid) -> FloatArray:
    """Return slip (rows, columns) raised to 1 at the workspace's edge, and clipped to 0..1."""
    border = 1.0 - BORDER_SLOPE * grid.distance_to_border()
    return np.clip(np.maximum(slip, border), 0.0, 1.0)


@dataclass(frozen=True)
class Terrain:
    """Slip and strength of the ground over the workspace.

    Parameters
    ----------
    name : str
    grid : Grid
    slip : (rows, columns) float
        True slip at the cell centres, 0..1 [-].
    strength_field : StrengthField
    start, goal : (x, y)
        Where a mission begins and ends unless it is told otherwise, map frame [m].
    height_field : HeightField, optional
        Heights of the ground; it is level at 0 if there are none.
    """

    name: str
    grid: Grid
    slip: FloatArray
    strength_field: StrengthField
    start: tuple[float, float] = (2.0, 5.0)
    goal: tuple[float, float] = (7.0, 1.5)
    extent: tuple[float, float, float, float] = field(default=WORKSPACE)
    height_field: HeightField | None = None

    @classmethod
    def from_slip(cls, name: str, slip: FloatArray, start: tuple[float, float],
                  goal: tuple[float, float]) -> 'Terrain':
        """Make a terrain from slip on `terrain_grid`; the border is raised here."""
        grid = terrain_grid()
        slip = raise_border(slip, grid)
        slip.setflags(write=False)
        strength = strength_of_slip(slip)
        return cls(name, grid, slip, StrengthField(grid, np.log(strength)), start, goal)

    @classmethod
    def uniform(cls, strength: float) -> 'Terrain':
        """Make ground of one strength, without a border and without an end."""
        grid = Grid.over_workspace(*WORKSPACE, 5.0)
        values = np.full(grid.shape, strength)
        slip = np.asarray(CalibratedSlipCurve().slip(values))
        return cls(f'uniform {strength:g}', grid, slip, StrengthField(grid, np.log(values)),
                   start=(5.0, 5.0), goal=(9.0, 5.0), extent=(-1e6, -1e6, 1e6, 1e6))

    def scaled(self, factor: float) -> 'Terrain':
        """Return the same ground, firmer by a factor [-]; its slip is not changed."""
        field = self.strength_field
        return replace(self, strength_field=StrengthField(
            field.grid, field.log_strength + math.log(factor)))

    @property
    def start_pose(self) -> tuple[float, float, float]:
        """Start, facing the goal: x [m], y [m], yaw [rad]."""
        (x, y), (goal_x, goal_y) = self.start, self.goal
        return x, y, math.atan2(goal_y - y, goal_x - x)

    @property
    def grid_extent(self) -> tuple[float, float, float, float]:
        """Min x, min y, max x, max y of the outermost samples, map frame [m]."""
        x, y = self.grid.x, self.grid.y
        return float(x[0]), float(y[0]), float(x[-1]), float(y[-1])

    @property
    def extent_text(self) -> str:
        """The workspace in words."""
        return '[{:g}, {:g}] x [{:g}, {:g}] m'.format(*(self.extent[i] for i in (0, 2, 1, 3)))

    def contains(self, point: tuple[float, float]) -> bool:
        """Tell whether a point lies in the workspace (its edge included)."""
        min_x, min_y, max_x, max_y = self.extent
        return min_x <= point[0] <= max_x and min_y <= point[1] <= max_y

    def true_slip(self, points: FloatArray) -> FloatArray:
        """Return the slip at points (..., 2), map frame [m]; 1 outside the workspace."""
        points = np.asarray(points, dtype=np.float64)
        slip = interpolate(self.grid, self.slip, points)
        _fill_outside(np.ascontiguousarray(points).reshape(-1, 2), self.extent, slip.reshape(-1))
        return slip

    def height_at(self, x: float, y: float) -> float:
        """Return the height of the undisturbed ground [m]."""
        return 0.0 if self.height_field is None else height_at(self.height_field.relief, x, y)

    def strength(self, points: FloatArray) -> FloatArray:
        """Return the strength at points (..., 2), map frame [m]."""
        return self.strength_field.strength(points)


@njit(cache=True)
def _fill_outside(points: FloatArray, extent: tuple[float, float, float, float],
                  slip: FloatArray) -> None:
    """Set the slip (n,) of the points (n, 2) outside an extent to 1; a NaN lies outside."""
    min_x, min_y, max_x, max_y = extent
    for i in range(points.shape[0]):
        x, y = points[i]
        if not (min_x <= x <= max_x and min_y <= y <= max_y):
            slip[i] = 1.0
