# SPDX-License-Identifier: Apache-2.0
"""Drives on which the steering is measured: recorded regions, random pairs, obstacles."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.kinematic_robot import drive_to
from psane_reactive.ledger import Ledger, Row
from psane_reactive.recorded import RecordedRegion
from psane_reactive.sample_regions import random_points, star_world
from psane_reactive.shortest_path import ShortestPath

# Shorter ways say little about the length of a way: the turn at its start weighs too much [m].
_SHORTEST = 1.0
# Simplification under which the exact shortest path is looked for [m].
_SIMPLIFICATION = 0.004


class Trial(NamedTuple):
    """One drive from a start to a goal, (2,) [m], in a region."""

    name: str
    region: shapely.Polygon
    start: FloatArray
    yaw: float
    goal: FloatArray


@dataclass
class Tally:
    """What became of many drives.

    Parameters
    ----------
    failures : list of str
        Names of trials that did not arrive, left the region, or raised.
    ratios : list of float
        Way driven over the shortest way in the region, of ways that are not very short [-].
    """

    drives: int = 0
    reached: int = 0
    exits: int = 0
    exceptions: int = 0
    failures: list[str] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)
    by_map: int = 0
    by_field: int = 0

    def add(self, name: str, row: Row) -> None:
        """Count one drive."""
        self.drives += 1
        if 'error' in row:
            self.exceptions += 1
            self.failures.append(f'{name}: {row["error"]}')
            return
        self.reached += row['reached']
        self.exits += row['outside'] > 0.0
        self.by_map += row['by_map']
        self.by_field += row['by_field']
        if not row['reached'] or row['outside'] > 0.0:
            self.failures.append(f'{name}: deepest {row["outside"]:.4f} m outside, {row["modes"]}')
        elif 'ratio' in row:
            self.ratios.append(row['ratio'])

    def figures(self, prefix: str) -> dict[str, float]:
        """Return shares and quantiles by name."""
        found = {f'{prefix}_drives': float(self.drives),
                 f'{prefix}_reach': self.reached / max(self.drives, 1),
                 f'{prefix}_exits': float(self.exits),
                 f'{prefix}_exceptions': float(self.exceptions),
                 f'{prefix}_field_share': self.by_field / max(self.by_map + self.by_field, 1)}
        if self.ratios:
            found[f'{prefix}_length_median'] = float(np.median(self.ratios))
            found[f'{prefix}_length_p95'] = float(np.quantile(self.ratios, 0.95))
        return found


def recorded_trials(regions: Iterable[RecordedRegion], seed: int = 0) -> Iterator[Trial]:
    """Yield two drives per region: to the subgoal of that moment, and between random points."""
    random = np.random.default_rng(seed)
    for number, region in enumerate(regions):
        yaw = random.uniform(-math.pi, math.pi)
        name = f'{number} {region.source} at {region.time:.0f} s'
        start, goal = random_points(random, region.polygon, 2)
        if region.polygon.covers(shapely.Point(region.position)):
            yield Trial(name, region.polygon, region.position, yaw, region.subgoal)
        yield Trial(f'{name}, random pair', region.polygon, start, yaw, goal)


def obstacle_trials(count: int, seed: int = 0, most_holes: int = 10) -> Iterator[Trial]:
    """Yield drives in worlds of 3 or more star-shaped obstacles, 10 m x 10 m."""
    for number in range(count):
        random = np.random.default_rng((seed, number))
        region = star_world(random, int(random.integers(3, most_holes + 1)))
        start, goal = random_points(random, region, 2)
        yield Trial(f'obstacle world {number}', region, start,
                    random.uniform(-math.pi, math.pi), goal)


def run_trials(trials: Iterable[Trial], settings: ReactiveConfiguration, step: float = 0.05,
               ledger: Ledger | None = None, part: str = '',
               show: Callable[[str], None] | None = None) -> Tally:
    """Drive all trials, each with a controller of its own, but for those in the ledger.

    Parameters
    ----------
    step : float
        Time between commands [s].
    part : str
        Name under which the ledger keeps the results.
    show : callable or None
        Is told the name of each trial that was made.
    """
    ledger = Ledger() if ledger is None else ledger
    tally = Tally()
    for trial in trials:
        row = ledger.row(part, trial.name)
        if row is None:
            row = _drive(trial, settings, step)
            ledger.add(part, trial.name, row)
        tally.add(trial.name, row)
        if show is not None:
            show(trial.name)
    return tally


def _drive(trial: Trial, settings: ReactiveConfiguration, step: float) -> Row:
    """Return what became of one drive; no exception escapes, so that each is counted."""
    controller = ReactiveController(settings)
    try:
        drive = drive_to(controller, trial.region, trial.start, trial.yaw, trial.goal, step)
    except Exception as error:  # noqa: BLE001 - counted and named
        return {'error': repr(error)}
    row: Row = {'reached': drive.has_arrived, 'outside': round(drive.deepest_outside, 5),
                'by_map': controller.counts.by_map, 'by_field': controller.counts.by_field,
                'modes': {mode.value: count for mode, count in drive.modes.items()}}
    if drive.has_arrived:
        shortest = ShortestPath(trial.region.simplify(_SIMPLIFICATION)).length(
            trial.start, trial.goal)
        if _SHORTEST < shortest < math.inf:
            row['ratio'] = (drive.length + settings.arrival_tolerance) / shortest
    return row
