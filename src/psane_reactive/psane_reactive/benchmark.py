# SPDX-License-Identifier: Apache-2.0
"""Measure the steering: cost, reach, exits and length of the way, for both maps."""

import argparse
import json
import sys
from dataclasses import replace

import numpy as np

from psane_reactive.checks import measure_adversary, measure_properties
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.costs import build_times, tick_times
from psane_reactive.recorded import read_recording
from psane_reactive.sample_regions import polygon_world, random_points, random_snake
from psane_reactive.trials import Tally, Trial, obstacle_trials, recorded_trials, run_trials

MAPS = {'default': ReactiveConfiguration().steering_map, 'purging': 'purging'}
"""What the figures' names say, and the map that is meant."""

_TICKS = 20
_WORLDS_OF_20 = 10
# The time step of the drives among obstacles [s].
_FINE_STEP = 0.02


def measure_cost(settings: ReactiveConfiguration | None = None) -> dict[str, float]:
    """Return times of ticks and builds [ms]: recorded regions, and purging with 20 polygons."""
    settings = settings or ReactiveConfiguration()
    purging = replace(settings, steering_map='purging')
    regions = [region.polygon for region in read_recording()]
    random = np.random.default_rng(20)
    worlds = [polygon_world(random, 20, 14) for _ in range(_WORLDS_OF_20)]
    for chosen in (settings, purging):
        ReactiveController(chosen).warm_up()
        build_times(worlds[:1], chosen)
    figures: dict[str, float] = {}
    for name, chosen, places in (('default', settings, regions), ('20', purging, worlds),
                                 ('purging', purging, regions)):
        ticks, builds = tick_times(places, chosen, _TICKS), build_times(places, chosen)
        figures[f'tick_ms_{name}'] = float(np.median(ticks)) * 1e3
        figures[f'tick_ms_{name}_p99'] = float(np.quantile(ticks, 0.99)) * 1e3
        figures[f'build_ms_{name}'] = float(np.median(builds)) * 1e3
        figures[f'build_ms_{name}_max'] = float(builds.max()) * 1e3
    return figures


def measure_laws(points: int = 5000, subgoals: int = 400) -> dict[str, float]:
    """Return shares of random points at which each property of a map holds, and of exits."""
    figures = measure_properties(points)
    for steering in MAPS.values():
        figures.update(measure_adversary(subgoals, steering=steering))
    return figures


def measure_drives(every: int = 6, worlds: int = 24, snakes: int = 8) -> dict[str, float]:
    """Drive both maps and return reach, exits, exceptions and lengths.

    Parameters
    ----------
    every : int
        Each so many-th recorded region is driven in, twice.
    worlds : int
        Worlds of obstacles, driven by a unicycle and by a point robot.
    snakes : int
        Random thin regions with branches and holes.
    """
    recorded = read_recording()[::every]
    figures: dict[str, float] = {}
    for name, steering in MAPS.items():
        settings = ReactiveConfiguration(steering_map=steering)
        point = replace(settings, holonomic=True)
        parts = {
            'recorded': run_trials(recorded_trials(recorded), settings),
            'snakes': run_trials(_snake_trials(snakes), settings),
            'holes': run_trials(obstacle_trials(worlds // 4, seed=1, most_holes=14), settings),
            'obstacles': run_trials(obstacle_trials(worlds), settings, _FINE_STEP),
            'obstacles_point': run_trials(obstacle_trials(worlds), point, _FINE_STEP)}
        for part, tally in parts.items():
            figures.update(tally.figures(f'{name}_{part}'))
            _complain(name, part, tally)
    return figures


def _snake_trials(count: int) -> list[Trial]:
    """Return a drive between two random points in each of many random regions."""
    random = np.random.default_rng(7)
    trials = []
    for number in range(count):
        region = random_snake(random, int(random.integers(10, 300)), random.uniform(0.1, 0.35))
        start, goal = random_points(random, region, 2)
        trials.append(Trial(f'snake {number}', region, start, random.uniform(-3.0, 3.0), goal))
    return trials


def _complain(name: str, part: str, tally: Tally) -> None:
    """Say on standard error which drives failed."""
    for failure in tally.failures:
        print(f'{name}, {part}: {failure}', file=sys.stderr)


def measure() -> dict[str, float]:
    """Return all figures, of some of the recorded regions and of some random worlds."""
    return {**measure_cost(), **measure_laws(), **measure_drives()}


def main() -> None:
    """Print the figures, as text or as one JSON object."""
    parser = argparse.ArgumentParser(description='measure the steering')
    parser.add_argument('--json', action='store_true', help='one JSON object on standard output')
    parser.add_argument('--full', action='store_true',
                        help='every recorded region, 1000 worlds, 100000 points: an hour or more')
    parser.add_argument('--cost', action='store_true', help='times of ticks and builds alone')
    arguments = parser.parse_args()
    if arguments.cost:
        figures = measure_cost()
    elif arguments.full:
        figures = {**measure_cost(), **measure_laws(100_000, 10_000),
                   **measure_drives(every=1, worlds=1000, snakes=168)}
    else:
        figures = measure()
    if arguments.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f'{name:36s} {value:.4g}')


if __name__ == '__main__':
    main()
