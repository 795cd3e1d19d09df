# SPDX-License-Identifier: Apache-2.0
"""Record the regions of runs on the physics: `python -m psane_sim.runs.record_regions`."""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely

from psane_reactive.recorded import SHIPPED, RecordedRegion, write_recording
from psane_sim.progress import Progress
from psane_sim.runs.closed_loop import ClosedLoop, Settings
from psane_sim.runs.summary import Task
from psane_sim.terrains.catalogue import load_terrain


class Run(NamedTuple):
    """Terrain, seed, whether it explores, and how long at most [s]."""

    terrain: str
    seed: int
    explores: bool
    duration: float


RUNS = (
    Run('env1', 0, False, 100.0), Run('env1', 1, True, 300.0),
    Run('env2', 0, False, 200.0), Run('env2', 1, True, 300.0),
    Run('smooth:1', 0, True, 150.0), Run('smooth:2', 1, False, 100.0),
    Run('patchy:1', 0, True, 150.0), Run('patchy:2', 1, False, 100.0),
    Run('corridors:1', 0, True, 150.0), Run('corridors:2', 1, False, 100.0),
)
"""What the shipped recording was made from."""


def record_run(run: Run, period: float) -> list[RecordedRegion]:
    """Run the closed loop and return its region every `period` seconds where there is one."""
    terrain = load_terrain(run.terrain)
    task = Task(terrain=run.terrain, start=terrain.start,
                goal=None if run.explores else terrain.goal, strategy='psane_geodesic',
                threshold=0.5, seed=run.seed, duration=run.duration)
    loop = ClosedLoop(task, terrain, terrain.start_pose, Settings())
    found: list[RecordedRegion] = []
    last = -np.inf

    def look(_: Progress) -> None:
        nonlocal last
        plan = loop.plan
        if (plan is None or plan.region is None or plan.subgoal is None or not loop.record.path
                or plan.now - last < period):
            return
        last = plan.now
        here = np.array(loop.record.path[-1][1:])
        # Single precision moves corners by a micrometre, which may make rings touch.
        polygon = shapely.Polygon(plan.region)
        if polygon.is_valid and not polygon.is_empty:
            found.append(RecordedRegion(polygon=polygon, position=here,
                                        subgoal=np.asarray(plan.subgoal), time=plan.now,
                                        source=f'{run.terrain} seed {run.seed}'))

    loop.run(look)
    return found


def main() -> None:
    """Run all and write the file."""
    parser = argparse.ArgumentParser(description='record regions for the tests of the steering')
    parser.add_argument('--output', type=Path, default=SHIPPED)
    parser.add_argument('--period', type=float, default=6.0, help='time between regions [s]')
    options = parser.parse_args()
    regions: list[RecordedRegion] = []
    for run in RUNS:
        found = record_run(run, options.period)
        print(f'{run.terrain} seed {run.seed}: {len(found)} regions', flush=True)
        regions += found
    options.output.parent.mkdir(parents=True, exist_ok=True)
    write_recording(regions, options.output)
    print(f'{len(regions)} regions, {options.output.stat().st_size / 1024.0:.0f} KiB: '
          f'{options.output}')


if __name__ == '__main__':
    main()
