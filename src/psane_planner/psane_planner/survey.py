# SPDX-License-Identifier: Apache-2.0
"""Find the frontier of a scene and score it the way a strategy asks for."""

import math
from typing import NamedTuple

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import Integers, Mask, count_in_discs
from psane_planner.frontier import expansion_counts, frontier_cells
from psane_planner.geodesic import distance_along, distance_within_reach
from psane_planner.memory import FrontierMemory
from psane_planner.prospects import WHOLE, Prospects
from psane_planner.region import Region
from psane_planner.scene import Scene
from psane_planner.scores import FrontierScores, score_frontier
from psane_planner.strategies import Traits
from psane_planner.window import Window, window_around

_BESIDE = 2
"""Squared radius that holds the eight neighbours of a cell [cells^2]."""


class Ground(NamedTuple):
    """The frontier, apart from the robot's way to it.

    Parameters
    ----------
    cells : (n, 2) int
    points : (n, 2) float, map frame [m]
    growth : (n,) float [-], count
    beside : (n,) float [-], count, or None
        What could be won right beside the cells, however steeply slip may rise.
    to_goal : (n,) float [m], or None
    """

    cells: Integers
    points: FloatArray
    growth: FloatArray
    beside: FloatArray | None
    to_goal: FloatArray | None


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
    """Scores the frontier of a scene; keeps what was worked out while it stays right."""

    def __init__(self, configuration: PlannerConfiguration, grid: Grid, traits: Traits) -> None:
        """Survey `grid` the way the `traits` of a strategy ask for."""
        self._configuration = configuration
        self._grid = grid
        self._traits = traits
        self._known: tuple[Scene, Ground] | None = None
        self._part: tuple[Region, Window | None] | None = None
        self._prospects = Prospects(grid, configuration.confidence_scale,
                                    configuration.slip_threshold)

    def survey(self, scene: Scene, region: Region, memory: FrontierMemory) -> Survey:
        """Return the frontier of the scene with its scores."""
        config = self._configuration
        cells, points, growth, beside, to_goal = self._ground(scene)
        to_robot = self._way_to_robot(scene, region, cells, points)
        awake = np.isfinite(to_robot)
        if self._traits.rests_frontiers:
            awake &= ~memory.is_resting(points, scene.now)
        if beside is not None and scene.goal is not None:
            growth = np.maximum(growth, beside)
            eligible = without_crumbs(awake & (growth > 0), growth, config.least_growth)
        else:
            eligible = awake & (growth > 0) if self._traits.needs_growth else awake
        if beside is not None and not eligible.any():
            # Nothing is within the reach of a cone: what is left is to look one cell further.
            growth, eligible = beside, awake & (beside > 0)
        way, is_cut_off = _with_goal(scene, points, to_robot, to_goal, eligible)
        decay = (config.geodesic_goal_decay if self._traits.is_geodesic else config.goal_decay)
        scores = score_frontier(cells, points, growth, way, eligible & np.isfinite(way),
                                config.expansion_rate, decay)
        return Survey(scores, is_cut_off)

    def _ground(self, scene: Scene) -> Ground:
        """Return what does not depend on where the robot is, as long as the ground is the same."""
        if self._known is None or not _is_same_ground(self._known[0], scene):
            cells = frontier_cells(scene.component, scene.certified, scene.admissible)
            points = self._grid.point_of(cells)
            self._known = (scene, Ground(cells, points, *self._growth(scene, cells),
                                         self._way_to_goal(scene, cells, points)))
        return self._known[1]

    def _growth(self, scene: Scene, cells: Integers) -> tuple[FloatArray, FloatArray | None]:
        """Return g_t of frontier cells (n, 2), (n,) [-], and the same of the cells beside them.

        If geodesic, a cell counts as much as it is likely safe. On the way to a goal those right
        beside a frontier cell always count: close below the threshold the cone of
        `lipschitz_constant` ends before the next cell, although a passage may lead on there.
        Exploring, there is other ground to win, and the robot comes to the soft ground beside
        such passages only when nothing else is left.
        """
        open_ground = scene.admissible & ~scene.certified
        if not self._traits.is_geodesic:
            return expansion_counts(cells, scene.bounds.lower, open_ground, self._configuration,
                                    self._grid.resolution).astype(np.float64), None
        weights = self._prospects.weights(scene.bounds, open_ground)
        counts = expansion_counts(cells, scene.bounds.lower, weights, self._configuration,
                                  self._grid.resolution)
        beside = count_in_discs(weights, cells, np.full(len(cells), _BESIDE))
        return counts / WHOLE, beside / WHOLE

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
        if self._part is None or self._part[0] is not region:
            margin = math.ceil(reach / self._grid.resolution) + 1
            self._part = (region, window_around(region.cells, margin))
        where = self._part[1]
        if where is None:
            return np.full(len(cells), np.inf)
        part = where.of(self._grid)
        field = distance_along(region.cells[where], part, position)
        inside = cells - (where.rows.start, where.columns.start)
        way = np.full(len(cells), np.inf)
        near = ((inside >= 0) & (inside < part.shape)).all(axis=1)
        way[near] = distance_within_reach(field, inside[near], part, reach)
        return way

    def _way_to_goal(self, scene: Scene, cells: Integers, points: FloatArray
                     ) -> FloatArray | None:
        """Return the way on from frontier cells (n, 2) to the goal, (n,) [m]; None without one."""
        if scene.goal is None:
            return None
        if not self._traits.is_geodesic:
            return _straight(points, scene.goal)
        return self._prospects.way_to(scene.goal, scene.bounds, scene.admissible, cells)


def without_crumbs(eligible: Mask, growth: FloatArray, least: float) -> Mask:
    """Return the eligible cells (n,) where `least` cells or more are to be won; all if none is.

    However near they are, a few cells more of ground that is felt already wait: a robot that picks
    them up one by one gets to the frontier that leads on when its time is over.
    """
    promising = eligible & (growth >= least)
    return promising if promising.any() else eligible


def _is_same_ground(one: Scene, other: Scene) -> bool:
    """Tell whether frontier, growth and way to the goal are the same in two scenes."""
    same_goal = (one.goal is None) == (other.goal is None) and (
        one.goal is None or other.goal is None or np.array_equal(one.goal, other.goal))
    return (same_goal and one.bounds.lower is other.bounds.lower
            and one.certified is other.certified and one.admissible is other.admissible
            and (one.component is other.component
                 or np.array_equal(one.component, other.component)))


def _with_goal(scene: Scene, points: FloatArray, to_robot: FloatArray,
               to_goal: FloatArray | None, eligible: Mask) -> tuple[FloatArray, bool]:
    """Add the way on to the goal; tell whether none is left for any eligible cell."""
    if scene.goal is None or to_goal is None:
        return to_robot, False
    if eligible.any() and not np.isfinite(to_goal[eligible]).any():
        return to_robot + _straight(points, scene.goal), True
    return to_robot + to_goal, False


def _straight(points: FloatArray, target: FloatArray) -> FloatArray:
    away: FloatArray = np.hypot(points[:, 0] - target[0], points[:, 1] - target[1])
    return away
