# SPDX-License-Identifier: Apache-2.0
"""A slip field, a dense Gaussian process and a robot without dynamics, to close the loop on."""

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import solve_triangular
from shapely.geometry import LineString

from psane_mapping.grid import FloatArray, Grid
from psane_planner.geodesic import distance_along
from psane_planner.placement import Placement
from psane_planner.planner import SafePlanner
from psane_planner.region import RegionBuilder
from psane_planner.status import Plan, PlannerState

GRID = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1)
# Where the feet touch, ahead of the centre and to its left [m].
FEET = ((0.25, 0.19), (0.0, -0.19), (-0.25, 0.19), (0.25, -0.19), (0.0, 0.19), (-0.25, -0.19))


class SlipField:
    """Sum of Gaussians in a 10 m square, raised to 1 toward the edge with slope 2 /m."""

    def __init__(self, centres: FloatArray, deviations: FloatArray,
                 amplitudes: FloatArray) -> None:
        self._centres, self._deviations, self._amplitudes = centres, deviations, amplitudes

    def __call__(self, points: FloatArray) -> FloatArray:
        points = np.atleast_2d(points)
        scaled = (points[:, None, :] - self._centres) / self._deviations
        slip = (self._amplitudes * np.exp(-0.5 * (scaled**2).sum(axis=2))).sum(axis=1)
        edge = np.minimum(points, 10.0 - points).min(axis=1)
        return np.clip(np.maximum(slip, 1.0 - 2.0 * edge), 0.0, 1.0)

    @classmethod
    def smooth(cls) -> 'SlipField':
        """Return the published smooth environment (env1)."""
        steps = (0.125, 0.375, 0.625, 0.875)
        centres = np.array([(x, y) for x in steps for y in steps])
        soft = {(.125, .125), (.125, .875), (.375, .375), (.375, .625), (.625, .375),
                (.625, .875), (.875, .125), (.875, .875)}
        amplitudes = np.array([0.99 if (x, y) in soft else 0.01 for x, y in centres])
        return cls(10.0 * centres, 10.0 * np.array((0.086, 0.085)), amplitudes)

    @classmethod
    def random(cls, seed: int) -> 'SlipField':
        """Return eight soft spots anywhere."""
        draw = np.random.default_rng(seed)
        return cls(draw.uniform(0.5, 9.5, (8, 2)), draw.uniform(0.5, 0.9, (8, 1)),
                   draw.uniform(0.7, 0.95, 8))


class DensePosterior:
    """Exact Gaussian process on the grid; each sample adds one row to the Cholesky factor."""

    def __init__(self, lengthscale: float = 0.6, deviation: float = 0.5,
                 capacity: int = 2000) -> None:
        self._lengthscale, self._variance = lengthscale, deviation**2
        self._cells = GRID.points
        self._points = np.empty((capacity, 2))
        self._factor = np.zeros((capacity, capacity))
        self._rows = np.empty((capacity, self._cells.shape[0]))
        self._weights = np.empty(capacity)
        self._count = 0
        self._mean = np.zeros(self._cells.shape[0])
        self._left = np.full(self._cells.shape[0], self._variance)

    def _kernel(self, point: FloatArray, points: FloatArray) -> FloatArray:
        squared = ((points - point) ** 2).sum(axis=1)
        return self._variance * np.exp(-0.5 * squared / self._lengthscale**2)

    def condition(self, point: FloatArray, value: float, noise: float) -> None:
        """Take in one sample: a forward substitution and one new row on the cells."""
        n = self._count
        line = solve_triangular(self._factor[:n, :n], self._kernel(point, self._points[:n]),
                                lower=True) if n else np.empty(0)
        pivot = math.sqrt(self._variance - line @ line + noise**2)
        self._factor[n, :n], self._factor[n, n] = line, pivot
        self._points[n] = point
        self._weights[n] = (value - line @ self._weights[:n]) / pivot
        row = (self._kernel(point, self._cells) - line @ self._rows[:n]) / pivot
        self._rows[n] = row
        self._mean += row * self._weights[n]
        self._left -= row**2
        self._count += 1

    @property
    def mean(self) -> FloatArray:
        return self._mean.reshape(GRID.shape).copy()

    @property
    def std(self) -> FloatArray:
        return np.sqrt(np.maximum(self._left, 0.0)).reshape(GRID.shape)


@dataclass
class Outcome:
    """What happened in one run."""

    plan: Plan
    time: float
    length: float
    worst_slip: float
    false_cells: int
    states: list[PlannerState] = field(default_factory=list)
    path: list[FloatArray] = field(default_factory=list)


def _step(position: FloatArray, ahead: FloatArray, step: float) -> FloatArray:
    gap = ahead - position
    return position + gap * min(1.0, step / max(float(np.hypot(*gap)), 1e-9))


def _toward(plan: Plan, cells: np.ndarray, position: FloatArray, step: float) -> FloatArray:
    """Return where the robot is after one step along the shortest way inside the region."""
    region, subgoal = plan.region, plan.subgoal
    assert region is not None and subgoal is not None
    around = region.buffer(0.03)
    if around.covers(LineString((position, subgoal))):
        return _step(position, subgoal, step)
    way = distance_along(cells, GRID, subgoal)
    row, column = GRID.index_of(position)
    window = [(way[r, c], r, c) for r in range(row - 3, row + 4)
              for c in range(column - 3, column + 4) if math.isfinite(way[r, c])]
    for _, r, c in sorted(window):
        ahead, _ = Placement(0.0).place(region, GRID.point_of(np.array((r, c))))
        if np.hypot(*(ahead - position)) > 1e-3 \
                and around.covers(LineString((position, ahead))):
            return _step(position, ahead, step)
    return _step(position, Placement(0.01).place(region, position)[0], step)


def run(planner: SafePlanner, slip: SlipField, start: tuple[float, float],
        goal: tuple[float, float] | None, seed: int, duration: float = 200.0) -> Outcome:
    """Close the loop: one contact and one plan every 0.2 s, 0.3 m/s, turning at once."""
    draw = np.random.default_rng(seed)
    posterior = DensePosterior()
    position, yaw, now, tick = np.array(start), 0.0, 0.0, 0
    target = None if goal is None else np.array(goal)
    config = planner.configuration
    builder = RegionBuilder(GRID, config.clearance, config.contour_tolerance)
    truth = slip(GRID.points).reshape(GRID.shape)
    outcome = Outcome(plan=planner.update(None, None, None, target, 0.0), time=0.0, length=0.0,
                      worst_slip=0.0, false_cells=0)
    while now < duration:
        ahead, aside = FEET[tick % len(FEET)]
        turn = np.array(((math.cos(yaw), -math.sin(yaw)), (math.sin(yaw), math.cos(yaw))))
        foot = np.clip(position + turn @ np.array((ahead, aside)), 0.0, 10.0)
        posterior.condition(foot, float(slip(foot)[0]) + draw.normal(0.0, 0.02), 0.04)
        plan = planner.update(posterior.mean, posterior.std,
                              np.array((*position, yaw)), target, now)
        outcome.plan, outcome.time = plan, now
        outcome.states.append(plan.state)
        outcome.path.append(position)
        false = plan.certified & (truth > planner.configuration.slip_threshold)
        outcome.false_cells = max(outcome.false_cells, int(false.sum()))
        outcome.worst_slip = max(outcome.worst_slip, float(slip(position)[0]))
        if plan.state in (PlannerState.REACHED, PlannerState.EXPLORED):
            break
        moved = position
        if plan.region is not None and plan.subgoal is not None and not plan.march:
            found = builder.build(plan.certified, plan.component, position, math.inf)
            cells = np.ones(GRID.shape, bool) if found is None else found.cells
            moved = _toward(plan, cells, position, 0.06)
        if plan.focus is not None and plan.march:
            yaw = math.atan2(*(plan.focus - position)[::-1])
        elif np.hypot(*(moved - position)) > 1e-6:
            yaw = math.atan2(*(moved - position)[::-1])
        outcome.length += float(np.hypot(*(moved - position)))
        position, now, tick = moved, now + 0.2, tick + 1
    return outcome
