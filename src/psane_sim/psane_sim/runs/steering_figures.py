# SPDX-License-Identifier: Apache-2.0
"""How the steering does on the physics: `python -m psane_sim.runs.steering_figures`."""

import argparse
import json
import sys
from dataclasses import dataclass, field

import numpy as np

from psane_mapping.grid import FloatArray
from psane_reactive.command import Mode
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.watched import Tick, WatchedController, turns_at_updates
from psane_sim.runs.closed_loop import ClosedLoop, Settings
from psane_sim.runs.summary import Ending, Task
from psane_sim.terrains.catalogue import load_terrain

LARGEST_TURN = 0.35
"""Turn of the direction of travel at a new region that counts as a small one [rad]."""


@dataclass
class Findings:
    """What was seen in runs on the physics; the centre is the true one.

    Parameters
    ----------
    ticks : list of Tick
        Of all runs.
    outside : list of float
        Distance of the centre outside the region of the moment, negative inside [m].
    left : list of float
        The same at each moment at which the robot went out of a region that did not change,
        and while it was still out of that one [m].
    revoked : int
        Number of times that ground under the centre was taken out of the region.
    began_outside : int
        Ticks outside before the centre was inside for the first time.
    times : list of float
        Simulated time of each run [s].
    reached : int
    """

    ticks: list[Tick] = field(default_factory=list)
    outside: list[float] = field(default_factory=list)
    left: list[float] = field(default_factory=list)
    revoked: int = 0
    began_outside: int = 0
    times: list[float] = field(default_factory=list)
    reached: int = 0
    turns: list[float] = field(default_factory=list)
    turns_same_subgoal: list[float] = field(default_factory=list)

    def add_way(self, ticks: list[Tick], centres: FloatArray) -> None:
        """Follow one run: the true centre (n, 2) [m] at each of n ticks."""
        was_inside = has_been_inside = has_left = False
        before: Tick | None = None
        for tick, centre in zip(ticks, centres, strict=True):
            if tick.border is None:
                before, was_inside = None, False
                continue
            outside = tick.border.outside_distance(centre)
            is_same = before is not None and before.region_number == tick.region_number
            is_out = outside > 0.0
            if is_out and not has_been_inside:
                self.began_outside += 1
            elif is_out:
                self.outside.append(outside)
                self.revoked += was_inside and not is_same
                has_left = is_same and (was_inside or has_left)
                if has_left:
                    self.left.append(outside)
            else:
                self.outside.append(outside)
                has_been_inside, has_left = True, False
            before, was_inside = tick, not is_out
        self.ticks += ticks
        self.turns += turns_at_updates(ticks, False)
        self.turns_same_subgoal += turns_at_updates(ticks, True)

    def figures(self, prefix: str) -> dict[str, float]:
        """Return the figures by name."""
        asked = [tick for tick in self.ticks if tick.found_by]
        count = max(len(self.ticks), 1)
        return {
            f'{prefix}_runs': float(len(self.times)),
            f'{prefix}_reached': self.reached / max(len(self.times), 1),
            f'{prefix}_time_mean_s': float(np.mean(self.times)),
            f'{prefix}_left_region_m': max(self.left, default=0.0),
            f'{prefix}_left_share': len(self.left) / count,
            f'{prefix}_revoked': float(self.revoked),
            f'{prefix}_outside_m': max(0.0, *self.outside),
            f'{prefix}_outside_share': float((np.array(self.outside) > 0.0).mean()),
            f'{prefix}_began_outside_share': self.began_outside / count,
            f'{prefix}_field_share': sum(tick.found_by == 'field' for tick in asked) / count,
            f'{prefix}_turning_share': sum(tick.command.mode is Mode.TURN
                                           for tick in self.ticks) / count,
            f'{prefix}_updates': float(len(self.turns)),
            f'{prefix}_small_turns_share': _share_small(self.turns),
            f'{prefix}_small_turns_same_subgoal_share': _share_small(self.turns_same_subgoal)}


def _share_small(turns: list[float]) -> float:
    return float((np.array(turns) <= LARGEST_TURN).mean()) if turns else 1.0


def measure(terrain: str = 'env1', seeds: int = 10, duration: float = 300.0,
            settings: ReactiveConfiguration | None = None) -> dict[str, float]:
    """Run the closed loop with each seed and return what its steering did."""
    settings = settings or ReactiveConfiguration()
    ground = load_terrain(terrain)
    findings = Findings()
    for seed in range(seeds):
        task = Task(terrain=terrain, start=ground.start, goal=ground.goal,
                    strategy='psane_geodesic', threshold=0.5, seed=seed, duration=duration)
        controller = WatchedController(settings)
        loop = ClosedLoop(task, ground, ground.start_pose, Settings(reactive=settings),
                          controller=controller)
        outcome, _ = loop.run()
        findings.add_way(controller.ticks,
                         np.array([entry.pose[:2] for entry in loop.record.truth]))
        findings.times.append(outcome.time)
        findings.reached += outcome.ending is Ending.REACHED
        print(f'{terrain}, seed {seed}: {outcome.ending.value} in {outcome.time:.1f} s',
              file=sys.stderr, flush=True)
    return findings.figures(terrain.replace(':', '_'))


def main() -> None:
    """Run and print, as text or as one JSON object."""
    parser = argparse.ArgumentParser(description='measure the steering on the physics')
    parser.add_argument('--terrain', default='env1')
    parser.add_argument('--seeds', type=int, default=10, help='runs with seeds 0, 1, ...')
    parser.add_argument('--duration', type=float, default=300.0,
                        help='simulated time of each run at most [s]')
    parser.add_argument('--map', choices=('harmonic', 'purging', 'field'), default='harmonic')
    parser.add_argument('--json', action='store_true', help='one JSON object')
    options = parser.parse_args()
    figures = measure(options.terrain, options.seeds, options.duration,
                      ReactiveConfiguration(steering_map=options.map))
    if options.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f'{name:40s} {value:.4g}')


if __name__ == '__main__':
    main()
