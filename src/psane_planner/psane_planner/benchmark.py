# SPDX-License-Identifier: Apache-2.0
"""Time the planning cycle and the cone transform on maps made for it."""

import argparse
import json
import math
import time
from collections.abc import Callable

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.compiled import compiled
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import Mask
from psane_planner.planner import SafePlanner
from psane_planner.safe_set import propagate
from psane_planner.status import PlannerState

_GRID = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1)
_CYCLES = 40


@compiled
def propagate_by_pairs(previous: Mask, upper: FloatArray, threshold: float, slope: float,
                       resolution: float) -> Mask:
    """Return what `safe_set.propagate` returns, by testing every pair of cells."""
    rows, columns = upper.shape
    certified = np.zeros((rows, columns), np.bool_)
    for r in range(rows):
        for c in range(columns):
            if not previous[r, c] or not upper[r, c] <= threshold:
                continue
            for i in range(rows):
                for j in range(columns):
                    away = resolution * math.sqrt((i - r) ** 2 + (j - c) ** 2)
                    if upper[r, c] + slope * away <= threshold:
                        certified[i, j] = True
    return certified


def wavy_map(share: float, phase: float) -> tuple[FloatArray, FloatArray]:
    """Return mean and std, (rows, columns) each, with about `share` of the cells certified.

    Parameters
    ----------
    share : float [-]
    phase : float [rad]
        Moves the waves, so that no two maps are the same.
    """
    x, y = np.meshgrid(_GRID.x, _GRID.y)
    waves = np.sin(1.9 * x + phase) * np.sin(1.7 * y) + 0.4 * np.sin(0.9 * x - 1.3 * y)
    std = 0.03 + 0.2 * np.clip(np.hypot(x - 5.0, y - 5.0) - 4.5, 0.0, 1.0)
    bumps = 0.3 * waves
    return bumps + 0.5 - np.quantile(bumps + 2.0 * std, share), std


def _median_ms(call: Callable[[int], object], count: int) -> float:
    times = []
    for k in range(count):
        start = time.perf_counter()
        call(k)
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


def _uncertain_point(mean: FloatArray, std: FloatArray) -> FloatArray:
    """Return the likeliest point of those that are not certified: a goal to be sought."""
    is_open = (mean + 2.0 * std > 0.55) & (_GRID.distance_to_border() > 0.5)
    point: FloatArray = _GRID.points[np.argmin(np.where(is_open, mean - 2.0 * std, np.inf))]
    return point


def _plan_cycle() -> dict[str, float]:
    """Time whole cycles in which the map, the pose and so every cell's interval are new."""
    planner = SafePlanner(PlannerConfiguration(), _GRID)
    maps = [wavy_map(0.72, 0.004 * k) for k in range(_CYCLES + 5)]
    start = _GRID.points[np.argmin(maps[0][0] + maps[0][1])]
    goal = _uncertain_point(*maps[-1])
    shares, seeking = [], []

    def cycle(k: int) -> None:
        pose = np.array((start[0] + 0.01 * (k % 5), start[1], 0.0))
        plan = planner.update(*maps[k], pose, goal, 0.2 * k)
        shares.append(float(plan.component.mean()))
        seeking.append(plan.state is PlannerState.SEEKING and plan.frontier_count > 0)

    _median_ms(cycle, 5)
    planner.reset()
    milliseconds = _median_ms(lambda k: cycle(k + 5), _CYCLES)
    return {'plan_cycle_ms_101': milliseconds,
            'plan_cycle_certified_share': float(np.median(shares)),
            'plan_cycle_seeking_share': float(np.mean(seeking))}


def _local_change() -> dict[str, float]:
    """Time cycles on a large map that only changes under the robot: 20 m across of 100 m felt."""
    grid = Grid.over_workspace(0.0, 0.0, 100.0, 100.0, 0.1)
    planner = SafePlanner(PlannerConfiguration(), grid)
    x, y = np.meshgrid(grid.x, grid.y)
    away = np.hypot(x - 50.0, y - 50.0)
    std = np.clip(0.03 + 0.5 * (away - 10.0), 0.03, 0.5)
    waves = 0.3 * (np.sin(1.9 * x) * np.sin(1.7 * y) + 0.4 * np.sin(0.9 * x - 1.3 * y))
    mean = np.where(away < 11.0, waves + 0.25, 0.0)
    start = int(np.argmin(np.where(away < 5.0, mean, np.inf)))
    row, column = divmod(start, grid.columns)
    pose, goal = np.append(grid.points[start], 0.0), np.array((80.0, 80.0))
    cells: list[int] = []

    def cycle(k: int) -> None:
        mean[row - 15:row + 15, column - 15:column + 15] -= 1e-4
        std[row - 15:row + 15, column - 15:column + 15] *= 0.999
        cells.append(planner.update(mean, std, pose, goal, 0.2 * k).certified_cells)

    _median_ms(cycle, 3)
    milliseconds = _median_ms(cycle, 20)
    return {'plan_local_ms_1001': milliseconds, 'plan_local_certified_cells': float(cells[-1])}


def _cone() -> dict[str, float]:
    """Time the cone transform beside pair loops compiled by the same compiler."""
    configuration = PlannerConfiguration()
    mean, std = wavy_map(0.72, 0.0)
    upper = mean + 2.0 * std
    previous = upper <= configuration.slip_threshold
    details = (configuration.slip_threshold, configuration.lipschitz_constant, _GRID.resolution)

    def fast(_: int) -> Mask:
        return propagate(previous, upper, configuration, _GRID.resolution)

    def slow(_: int) -> Mask:
        return propagate_by_pairs(previous, upper, *details)

    is_equal = bool(np.array_equal(fast(0), slow(0)))
    fast_ms, slow_ms = _median_ms(fast, 50), _median_ms(slow, 5)
    return {'cone_ms': fast_ms, 'cone_pairs_ms': slow_ms, 'cone_speedup': slow_ms / fast_ms,
            'cone_is_equal': float(is_equal)}


def measure() -> dict[str, float]:
    """Return the figures of this run: milliseconds are medians, shares are in 0..1."""
    return {**_plan_cycle(), **_local_change(), **_cone()}


def main() -> None:
    """Print the figures, with `--json` as one object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--json', action='store_true', help='print one JSON object')
    as_json = parser.parse_args().json
    figures = measure()
    if as_json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f'{name:28s} {value:10.3f}')


if __name__ == '__main__':
    main()
