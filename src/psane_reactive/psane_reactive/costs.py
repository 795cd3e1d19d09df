# SPDX-License-Identifier: Apache-2.0
"""What one tick and one map cost on the clock on the wall."""

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.guide import Counts, Guide
from psane_reactive.sample_regions import random_points


def build_times(regions: Sequence[shapely.Polygon],
                settings: ReactiveConfiguration) -> FloatArray:
    """Return the time from each new region to its finished map [s]."""
    times = []
    for region in regions:
        position, goal = random_points(np.random.default_rng(0), region, 2)
        begin = time.perf_counter()
        guide = Guide(region, settings, Counts())
        guide.goal_inside(goal, position)
        guide.build()
        times.append(time.perf_counter() - begin)
    return np.array(times)


def tick_times(regions: Sequence[shapely.Polygon], settings: ReactiveConfiguration,
               ticks: int) -> FloatArray:
    """Return the times of single commands on the way to far goals [s].

    Notes
    -----
    Straight driving at a visible goal is switched off, so that every tick asks the map; each is
    measured at a random place, after the first one there has found the goal.
    """
    random = np.random.default_rng(1)
    settings = replace(settings, straight_reach=0.0)
    times = []
    for region in regions:
        controller = ReactiveController(settings)
        controller.set_region(region, 0.0)
        *places, goal = random_points(random, region, ticks + 1)
        controller.set_subgoal(goal, False, True, 0.0)
        for number, place in enumerate((places[0], *places)):
            pose = (float(place[0]), float(place[1]), random.uniform(-3.0, 3.0))
            controller.set_odometry(pose, (0.0, 0.0), 0.0)
            begin = time.perf_counter()
            controller.command(0.0)
            if number > 0:
                times.append(time.perf_counter() - begin)
    return np.array(times)
