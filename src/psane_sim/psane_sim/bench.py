# SPDX-License-Identifier: Apache-2.0
"""Figures of speed and accuracy, all measured in this run: `psane bench [PART] [--json]`."""

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from psane_mapping import benchmark as map_benchmark
from psane_planner import benchmark as plan_benchmark
from psane_reactive import benchmark as steer_benchmark
from psane_sim import simulator_benchmark
from psane_sim.measured_page import page_of
from psane_sim.runs.closed_loop import ClosedLoop, Settings
from psane_sim.runs.summary import Task
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.touch import report as touch_report

LOOP_SECONDS = 30.0
"""Simulated time of the closed loop that is measured [s]."""


def measure_loop() -> dict[str, float]:
    """Run the closed loop on env1, noise and all, and return its real-time factor [-]."""
    terrain = load_terrain('env1')
    task = Task(terrain='env1', start=terrain.start, goal=terrain.goal, strategy='psane_geodesic',
                threshold=0.5, seed=0, duration=LOOP_SECONDS)
    loop = ClosedLoop(task, terrain, terrain.start_pose, Settings())
    outcome, _ = loop.run()
    return {'rtf_in_process': outcome.time / outcome.wall}


def measure_sim() -> dict[str, float]:
    """Return the figures of the simulator alone and of the closed loop."""
    return {**simulator_benchmark.measure(), **measure_loop()}


def measure_touch() -> dict[str, float]:
    """Return how well strength is felt, on ground as modelled and on other ground."""
    effort = touch_report.Effort(seconds=6.0, draws=2)
    return touch_report.figures(touch_report.measure(effort))


def measure_map() -> dict[str, float]:
    """Return the figures of the map, those of the way through the graph with them."""
    # Only here, so that the other parts need no ROS.
    from psane_sim import ros_map_latency
    return {**map_benchmark.measure(full=True), **ros_map_latency.measure()}


def measure_steering() -> dict[str, float]:
    """Return every figure of the steering, those of the physics with them: an hour or more."""
    # Only here: the other parts need none of it.
    from psane_sim.runs import steering_figures
    return {**steer_benchmark.measure_full(), **steering_figures.measure()}


PARTS: dict[str, Callable[[], dict[str, float]]] = {
    'sim': measure_sim,
    'touch': measure_touch,
    'map': measure_map,
    'plan': plan_benchmark.measure,
    'steer': steer_benchmark.measure,
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure what was asked for, and print it as a table or as one JSON object."""
    parser = argparse.ArgumentParser(
        prog='psane bench', description='Measure speed and accuracy on this machine, now.')
    parser.add_argument('part', nargs='?', choices=[*PARTS, 'all'], default='all',
                        help='what to measure (default: all, a few minutes)')
    parser.add_argument('--json', action='store_true',
                        help='one JSON object of named numbers on standard output')
    parser.add_argument('--page', type=Path, metavar='FILE',
                        help='write a page (Markdown) of the figures and what they are')
    parser.add_argument('--full', action='store_true',
                        help='steer: every recorded region, 1000 worlds, 100000 points and 10 '
                        'runs on the physics, an hour or more; goes on where it was broken off '
                        f'({steer_benchmark.DEFAULT_LEDGER})')
    options = parser.parse_args(arguments)
    if options.full and options.part != 'steer':
        parser.error('--full is for the part steer')
    measured: dict[str, dict[str, float]] = {}
    for part in PARTS if options.part == 'all' else [options.part]:
        began = time.monotonic()
        print(f'measuring {part} ...', file=sys.stderr, flush=True)
        measured[part] = measure_steering() if options.full else PARTS[part]()
        print(f'measured {part} in {time.monotonic() - began:.0f} s', file=sys.stderr, flush=True)
        if not options.json:
            for name, value in measured[part].items():
                print(f'  {name:28s} {value:.6g}')
    if options.json:
        print(json.dumps({name: value for figures in measured.values()
                          for name, value in figures.items()}, indent=2))
    if options.page is not None:
        options.page.write_text(page_of(measured))
