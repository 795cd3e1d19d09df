# SPDX-License-Identifier: Apache-2.0
"""Find the frontier of a scene and score it the way a strategy asks for."""

import math
from typing import NamedTuple

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import Integers, Mask
from psane_planner.frontier import expansion_counts, frontier_cells
from psane_planner.geodesic import distance_along, distance_within_reach
from psane_planner.memory import FrontierMemory
from psane_planner.region import Region
from psane_planner.scene import Scene
from psane_planner.scores import FrontierScores, score_frontier
from psane_planner.strategies import Traits
from psane_planner.window import window_around


class Survey(NamedTuple):
    """The scored frontier.

    Parameters
    ----------
    scores : FrontierScores
    is_goal_cut_off : bool
        No way to the goal is left through ground that may be safe; distances to it are straight.
    """

    scores: FrontierScores
    is_goal_cut_off: bool


class FrontierSurveyor:
    """Scores the frontier of a scene; keeps the goal's distance field while it stays right."""

    def __init__(self, configuration: PlannerConfiguration, grid: Grid, traits: Traits) -> None:
        """Survey `grid` the way the `traits` of a strategy ask for."""
        self._configuration = configuration
        self._grid = grid
        self._traits = traits
        self._goal_field: tuple[Mask, FloatArray, FloatArray] | None = None

    def survey(self, scene: Scene, region: Region, memory: FrontierMemory) -> Survey:
        """Return the frontier of the scene with its scores."""
        config = self._configuration
        possible = scene.admissible & ~(scene.bounds.lower > config.slip_threshold)
        targets = (possible if self._traits.is_geodesic else scene.admissible) & ~scene.certified
        cells = frontier_cells(scene.component, scene.certified, scene.admissible)
        points = self._grid.point_of(cells)
        growth = expansion_counts(cells, scene.bounds.lower, targets, config,
                                  self._grid.resolution)
        to_robot = self._way_to_robot(scene, region, cells, points)
        eligible = np.isfinite(to_robot)
        if self._traits.needs_growth:
            eligible &= growth > 0
        if self._traits.rests_frontiers:
            eligible &= ~memory.is_resting(points, scene.now)
        way, is_cut_off = self._with_goal(scene, possible, cells, points, to_robot, eligible)
        decay = (config.geodesic_goal_decay if self._traits.is_geodesic else config.goal_decay)
        scores = score_frontier(cells, points, growth, way, eligible & np.isfinite(way),
                                config.expansion_rate, decay)
        return Survey(scores, is_cut_off)

    def _way_to_robot(self, scene: Scene, region: Region, cells: Integers,
                      points: FloatArray) -> FloatArray:
        """Return the way from the robot to frontier cells (n, 2), turning included, (n,) [m]."""
        if not self._traits.is_geodesic:
            return _straight(points, scene.position)
        way = self._way_along(region, scene.position, cells)
        aside = points - scene.position
        turn = np.arctan2(aside[:, 1], aside[:, 0]) - scene.heading
        turn = np.abs((turn + np.pi) % (2.0 * np.pi) - np.pi)
        return np.asarray(way + self._configuration.turning_length * turn)

    def _way_along(self, region: Region, position: FloatArray, cells: Integers) -> FloatArray:
        """Return the way inside the region, and on to cells beside it, (n,) [m]."""
        reach = self._configuration.sensing_reach
        where = window_around(region.cells, math.ceil(reach / self._grid.resolution) + 1)
        if where is None:
            return np.full(len(cells), np.inf)
        part = where.of(self._grid)
        field = distance_along(region.cells[where], part, position)
        inside = cells - (where.rows.start, where.columns.start)
        way = np.full(len(cells), np.inf)
        near = ((inside >= 0) & (inside < part.shape)).all(axis=1)
        way[near] = distance_within_reach(field, inside[near], part, reach)
        return way

    def _with_goal(self, scene: Scene, possible: Mask, cells: Integers, points: FloatArray,
                   to_robot: FloatArray, eligible: Mask) -> tuple[FloatArray, bool]:
        """Add the way on to the goal; tell whether none is left for any eligible cell."""
        if scene.goal is None:
            return to_robot, False
        if not self._traits.is_geodesic:
            return to_robot + _straight(points, scene.goal), False
        to_goal = self._field_of_goal(scene.goal, possible)[cells[:, 0], cells[:, 1]]
        if eligible.any() and not np.isfinite(to_goal[eligible]).any():
            return to_robot + _straight(points, scene.goal), True
        return to_robot + to_goal, False

    def _field_of_goal(self, goal: FloatArray, possible: Mask) -> FloatArray:
        last = self._goal_field
        if last is not None and np.array_equal(last[0], possible) \
                and np.array_equal(last[1], goal):
            return last[2]
        field = distance_along(possible, self._grid, goal)
        self._goal_field = (possible, goal, field)
        return field


def _straight(points: FloatArray, target: FloatArray) -> FloatArray:
    away: FloatArray = np.hypot(points[:, 0] - target[0], points[:, 1] - target[1])
    return away
