# SPDX-License-Identifier: Apache-2.0
"""Measure the steering: cost, reach, exits and length of the way, for both maps."""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from psane_reactive.checks import measure_adversary, measure_properties
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.costs import build_times, tick_times
from psane_reactive.ledger import Ledger
from psane_reactive.recorded import read_recording
from psane_reactive.sample_regions import polygon_world, random_points, random_snake
from psane_reactive.trials import Tally, Trial, obstacle_trials, recorded_trials, run_trials

MAPS = {'default': ReactiveConfiguration().steering_map, 'purging': 'purging'}
"""What the figures' names say, and the map that is meant."""

DEFAULT_LEDGER = Path('out') / 'steering.jsonl'
"""Where the full measurement keeps its results."""

_TICKS = 20
_WORLDS_OF_20 = 10
# The time steps of the drives, the finer one among obstacles [s].
_STEP, _FINE_STEP = 0.05, 0.02

Show = Callable[[str, str], None]


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


def measure_laws(points: int = 5000, subgoals: int = 400, ledger: Ledger | None = None,
                 ) -> dict[str, float]:
    """Return shares of random points at which each property of a map holds, and of exits."""
    ledger = Ledger() if ledger is None else ledger
    parts = {f'{points} points': lambda: measure_properties(points)}
    for steering in MAPS.values():
        parts[f'{subgoals} subgoals, {steering}'] = partial(measure_adversary, subgoals,
                                                            steering=steering)
    figures: dict[str, float] = {}
    for name, look in parts.items():
        row = ledger.row('laws', name)
        if row is None:
            print(f'laws: {name} ...', file=sys.stderr, flush=True)
            ledger.add('laws', name, {'figures': look()})
        figures.update((row or ledger.row('laws', name) or {})['figures'])
    return figures


def measure_drives(every: int = 6, worlds: int = 24, snakes: int = 8,
                   ledger: Ledger | None = None, show: Show | None = None) -> dict[str, float]:
    """Drive both maps and return reach, exits, exceptions and lengths.

    Parameters
    ----------
    every : int
        Each so many-th recorded region is driven in, twice.
    worlds : int
        Worlds of obstacles, driven by a unicycle and by a point robot.
    snakes : int
        Random thin regions with branches and holes.
    ledger : Ledger or None
        Holds what was driven already, and takes what is driven now.
    show : callable or None
        Is told part and trial after each drive.
    """
    recorded = read_recording()[::every]
    figures: dict[str, float] = {}
    for name, steering in MAPS.items():
        settings = ReactiveConfiguration(steering_map=steering)
        point = replace(settings, holonomic=True)
        parts: dict[str, tuple[Iterable[Trial], ReactiveConfiguration, float]] = {
            'recorded': (recorded_trials(recorded), settings, _STEP),
            'snakes': (_snake_trials(snakes), settings, _STEP),
            'holes': (obstacle_trials(worlds // 4, seed=1, most_holes=14), settings, _STEP),
            'obstacles': (obstacle_trials(worlds), settings, _FINE_STEP),
            'obstacles_point': (obstacle_trials(worlds), point, _FINE_STEP)}
        for part, (trials, chosen, step) in parts.items():
            label = f'{name}_{part}'
            tally = run_trials(trials, chosen, step, ledger, label,
                               None if show is None else partial(show, label))
            figures.update(tally.figures(label))
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


def measure_full(path: Path | None = DEFAULT_LEDGER) -> dict[str, float]:
    """Return all figures, of every recorded region, 1000 worlds and 100000 points.

    Parameters
    ----------
    path : Path or None
        Where results are kept as they come; a run that was broken off goes on from there.
    """
    ledger = Ledger(path)
    if len(ledger):
        print(f'goes on after {len(ledger)} results in {path}', file=sys.stderr)
    return {**measure_cost(), **measure_laws(100_000, 10_000, ledger),
            **measure_drives(every=1, worlds=1000, snakes=168, ledger=ledger, show=_progress())}


def _progress() -> Show:
    """Return what shows a line, rewritten on a terminal, every hundred drives elsewhere."""
    is_terminal = sys.stderr.isatty()
    counts: Counter[str] = Counter()

    def show(part: str, trial: str) -> None:
        counts[part] += 1
        if is_terminal:
            print(f'\r{part}: {counts[part]:4d} drives, {trial:60.60s}', end='', file=sys.stderr)
        elif counts[part] % 100 == 0:
            print(f'{part}: {counts[part]} drives', file=sys.stderr, flush=True)
    return show


def main() -> None:
    """Print the figures, as text or as one JSON object."""
    parser = argparse.ArgumentParser(description='measure the steering')
    parser.add_argument('--json', action='store_true', help='one JSON object on standard output')
    parser.add_argument('--full', action='store_true',
                        help='every recorded region, 1000 worlds, 100000 points: an hour or more')
    parser.add_argument('--ledger', type=Path, default=DEFAULT_LEDGER, metavar='FILE',
                        help='where results of --full are kept as they come, to resume from '
                        f'(default {DEFAULT_LEDGER})')
    parser.add_argument('--cost', action='store_true', help='times of ticks and builds alone')
    arguments = parser.parse_args()
    if arguments.cost:
        figures = measure_cost()
    else:
        figures = measure_full(arguments.ledger) if arguments.full else measure()
    if arguments.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f'{name:36s} {value:.4g}')


if __name__ == '__main__':
    main()
