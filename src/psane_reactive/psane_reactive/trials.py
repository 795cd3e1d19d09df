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
from psane_reactive.guide import Counts
from psane_reactive.kinematic_robot import drive_to
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
    counts: Counts = field(default_factory=Counts)

    def figures(self, prefix: str) -> dict[str, float]:
        """Return shares and quantiles by name."""
        found = {f'{prefix}_drives': float(self.drives),
                 f'{prefix}_reach': self.reached / max(self.drives, 1),
                 f'{prefix}_exits': float(self.exits),
                 f'{prefix}_exceptions': float(self.exceptions),
                 f'{prefix}_field_share': self.counts.by_field
                 / max(self.counts.by_map + self.counts.by_field, 1)}
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
               show: Callable[[str], None] | None = None) -> Tally:
    """Drive all trials, each with a controller of its own."""
    tally = Tally()
    for trial in trials:
        controller = ReactiveController(settings)
        controller.counts = tally.counts
        controller.reconfigure(settings)
        tally.drives += 1
        try:
            drive = drive_to(controller, trial.region, trial.start, trial.yaw, trial.goal, step)
        except Exception as error:  # noqa: BLE001 - none may escape, so each is counted
            tally.exceptions += 1
            tally.failures.append(f'{trial.name}: {error!r}')
            continue
        tally.reached += drive.has_arrived
        tally.exits += drive.deepest_outside > 0.0
        if not drive.has_arrived or drive.deepest_outside > 0.0:
            tally.failures.append(f'{trial.name}: deepest {drive.deepest_outside:.4f} m outside, '
                                  f'{ {mode.value: n for mode, n in drive.modes.items()} }')
        else:
            shortest = ShortestPath(trial.region.simplify(_SIMPLIFICATION)).length(
                trial.start, trial.goal)
            if _SHORTEST < shortest < math.inf:
                tally.ratios.append((drive.length + settings.arrival_tolerance) / shortest)
        if show is not None:
            show(trial.name)
    return tally
