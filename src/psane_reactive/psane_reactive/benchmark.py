# SPDX-License-Identifier: Apache-2.0
"""Measure the steering on random regions: cost, reach, exits and length of the way."""

import argparse
import json
import time

import numpy as np
import shapely

from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.guide import Counts, Guide
from psane_reactive.kinematic_robot import Drive, drive_to
from psane_reactive.sample_regions import random_points, random_snake, star_world
from psane_reactive.shortest_path import ShortestPath


def measure(snakes: int = 40, stars: int = 8, pairs: int = 3, seed: int = 0,
            configuration: ReactiveConfiguration | None = None) -> dict[str, float]:
    """Drive through random regions and return what was seen.

    Parameters
    ----------
    snakes, stars : int
        Number of certified-like regions and of worlds with star-shaped holes.
    pairs : int
        Drives in each region, from one random point to another.

    Returns
    -------
    Medians and shares by name; times in milliseconds.
    """
    settings = configuration or ReactiveConfiguration()
    random = np.random.default_rng(seed)
    regions = [random_snake(random, int(random.integers(10, 300)), random.uniform(0.1, 0.35))
               for _ in range(snakes)]
    regions += [star_world(random, int(random.integers(3, 11))) for _ in range(stars)]
    ReactiveController(settings).warm_up()
    counts = Counts()
    builds = [_build_time(region, settings) for region in regions]
    drives: list[Drive] = []
    ratios: list[float] = []
    for region in regions:
        oracle = ShortestPath(region.simplify(0.004))
        points = random_points(random, region, 2 * pairs)
        for start, goal in zip(points[::2], points[1::2], strict=True):
            controller = ReactiveController(settings)
            controller.counts = counts
            drive = drive_to(controller, region, start, random.uniform(-np.pi, np.pi), goal)
            drives.append(drive)
            shortest = oracle.length(start, goal)
            if drive.has_arrived and 1.0 < shortest < np.inf:
                ratios.append((drive.length + settings.arrival_tolerance) / shortest)
    return _summary(drives, ratios, builds, counts)


def _build_time(region: shapely.Polygon, settings: ReactiveConfiguration) -> float:
    """Return the wall-clock time from a new region to the first target [s]."""
    points = random_points(np.random.default_rng(0), region, 2)
    begin = time.perf_counter()
    guide = Guide(region, settings, Counts())
    guide.goal_inside(points[1], points[0])
    guide.build()
    return time.perf_counter() - begin


def _summary(drives: list[Drive], ratios: list[float], builds: list[float],
             counts: Counts) -> dict[str, float]:
    """Put the figures of all drives together."""
    ticks = np.concatenate([drive.tick_times[1:] for drive in drives])
    guided = counts.by_map + counts.by_field
    return {
        'tick_ms_default': float(np.median(ticks)) * 1e3,
        'tick_ms_default_p99': float(np.quantile(ticks, 0.99)) * 1e3,
        'build_ms_default': float(np.median(builds)) * 1e3,
        'build_ms_default_max': float(np.max(builds)) * 1e3,
        'drives': float(len(drives)),
        'reach_share': float(np.mean([drive.has_arrived for drive in drives])),
        'exits': float(sum(drive.deepest_outside > 0.0 for drive in drives)),
        'length_ratio_median': float(np.median(ratios)),
        'length_ratio_p95': float(np.quantile(ratios, 0.95)),
        'field_share': counts.by_field / max(guided, 1),
        'maps_failed': float(counts.maps_failed),
    }


def main() -> None:
    """Print the figures, as text or as one JSON object."""
    parser = argparse.ArgumentParser(description='measure the steering on random regions')
    parser.add_argument('--json', action='store_true', help='one JSON object on standard output')
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--snakes', type=int, default=40, help='certified-like regions')
    parser.add_argument('--stars', type=int, default=8, help='worlds with star-shaped holes')
    arguments = parser.parse_args()
    figures = measure(arguments.snakes, arguments.stars, seed=arguments.seed)
    if arguments.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f'{name:24s} {value:.4g}')


if __name__ == '__main__':
    main()
