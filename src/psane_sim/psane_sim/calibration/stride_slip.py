# SPDX-License-Identifier: Apache-2.0
"""Slip of each stride, measured on the true motion, to be compared with what the map says.

``python -m psane_sim.calibration.stride_slip`` runs env1 and prints how far map and truth are
from it.
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_sim.calibration.steered_walks import SteeredWalks, read_walks
from psane_sim.robot.gait import wrap
from psane_sim.runs.truth_log import TruthEntry
from psane_sim.soils.strength_field import interpolate

WALKS = Path(__file__).parents[1] / 'data' / 'calibration' / 'x_rhex_walks.csv'
"""Of the default robot."""

LEAST_ADVANCE = 0.16
"""A stride counts when on the firmest ground its sweeps would have carried the robot forward at
least this far [m], and both sides walked forward throughout: spot turns, marches and walking
backward have no slip that the curve is about."""


@dataclass(frozen=True)
class StrideSlip:
    """One stride.

    Parameters
    ----------
    time : float
        At its end [s].
    way : (n, 2) float, map frame [m]
        Of the body's centre.
    slip : float [-]
        Of a straight walk on uniform ground where the same sweeps make the same advance.
    """

    time: float
    way: FloatArray
    slip: float


def ways_ahead(poses: FloatArray) -> FloatArray:
    """Return how far the body went along its heading between poses (n, 3), (n - 1,) [m]."""
    yaw = poses[:-1, 2] + 0.5 * np.array([wrap(turn) for turn in np.diff(poses[:, 2])])
    step = np.diff(poses[:, :2], axis=0)
    return np.asarray(step[:, 0] * np.cos(yaw) + step[:, 1] * np.sin(yaw))


def strides_of(entries: Sequence[TruthEntry], walks: SteeredWalks,
               frequency: float) -> list[StrideSlip]:
    """Cut a run into strides, one turn of the clock each, and return those that have a slip.

    Parameters
    ----------
    entries : sequence of TruthEntry
    walks : SteeredWalks
        Of the robot that walked.
    frequency : float
        Of its strides [1/s].
    """
    if len(entries) < 2:
        return []
    time = np.array([entry.time for entry in entries])
    poses = np.array([entry.pose for entry in entries])
    sweep = np.array([entry.sweep for entry in entries])[:-1]
    ways = ways_ahead(poses)
    share = frequency * np.diff(time)[:, None]
    expected = share * walks.advances(0.5 * (sweep[:, 0] + sweep[:, 1]),
                                      0.5 * (sweep[:, 1] - sweep[:, 0]))
    is_forward = np.asarray(sweep[:, 2:].min(axis=1) > 0.0)
    strides, first = [], 0
    for last in range(1, len(time)):
        if time[last] - time[first] < 1.0 / frequency - 1e-9:
            continue
        rows, first = slice(first, last), last
        asked = expected[rows].sum(axis=0)
        if is_forward[rows].all() and asked.max() >= LEAST_ADVANCE:
            strides.append(StrideSlip(float(time[last]), poses[rows, :2],
                                      walks.slip_of(float(ways[rows].sum()), asked)))
    return strides


@dataclass(frozen=True)
class StrideComparison:
    """What the map, or the truth, says along each stride less the slip that was measured.

    Parameters
    ----------
    error : (n,) float [-]
    """

    error: FloatArray

    @property
    def rmse(self) -> float:
        """Root mean square; NaN without a stride."""
        return math.sqrt(float(np.mean(np.square(self.error)))) if len(self.error) else math.nan

    @property
    def mean(self) -> float:
        """Mean, below 0 where the ground looked better than it was; NaN without a stride."""
        return float(np.mean(self.error)) if len(self.error) else math.nan


def compare(strides: Sequence[StrideSlip], grid: Grid, slip: FloatArray) -> StrideComparison:
    """Compare a map of slip (rows, columns) with strides, each over the cells that it crossed."""
    return StrideComparison(np.array([
        float(interpolate(grid, slip, stride.way).mean()) - stride.slip for stride in strides]))


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a terrain and compare the map's slip, and the true one, with that of the strides."""
    from psane_sim.runs.closed_loop import ClosedLoop, Settings
    from psane_sim.runs.summary import Task
    from psane_sim.terrains.catalogue import load_terrain

    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument('--seeds', type=int, default=5)
    parser.add_argument('--terrain', default='env1')
    options = parser.parse_args(arguments)
    terrain, settings, walks = load_terrain(options.terrain), Settings(), read_walks(WALKS)
    errors: dict[str, list[FloatArray]] = {'map': [], 'truth': []}
    for seed in range(options.seeds):
        loop = ClosedLoop(Task(terrain=options.terrain, start=terrain.start, goal=terrain.goal,
                               strategy='psane_geodesic', threshold=0.5, seed=seed,
                               duration=120.0), terrain, terrain.start_pose, settings)
        loop.run()
        record = loop.record
        strides = strides_of(record.truth, walks, settings.simulator.stride_frequency)
        if record.slip_mean is None or not strides:
            continue
        felt = compare(strides, record.grid, record.slip_mean)
        true = compare(strides, terrain.grid, terrain.slip)
        errors['map'].append(felt.error)
        errors['truth'].append(true.error)
        print(f'seed {seed}: {len(strides)} strides; from the measured slip the map is off by '
              f'{felt.rmse:.3f} ({felt.mean:+.3f}), the truth by {true.rmse:.3f} '
              f'({true.mean:+.3f}) (RMSE, mean)', flush=True)
    for name, parts in errors.items():
        whole = StrideComparison(np.concatenate(parts))
        print(f'{name} - measured slip of {len(whole.error)} strides: RMSE {whole.rmse:.3f}, mean '
              f'{whole.mean:+.3f}, median {np.median(whole.error):+.3f}')


if __name__ == '__main__':
    main()
