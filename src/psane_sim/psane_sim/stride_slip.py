# SPDX-License-Identifier: Apache-2.0
"""Slip of each stride, measured on the true motion, to be compared with what the map says.

``python -m psane_sim.stride_slip`` runs env1 and prints how far map and truth are from it.
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from psane_mapping.grid import FloatArray
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.gait import wrap
from psane_sim.hexapod import HexapodSimulator
from psane_sim.terrain import Terrain

LEAST_SPEED, LARGEST_TURN = 0.12, 0.2
"""A stride counts when the same commands would have taken the robot forward at least this fast on
hard ground [m/s] and when it was told to turn, on average, by no more than this [rad/s]: spot
turns and marches have no slip ratio."""

Steps = list[tuple[float, float, float, float, float, float]]
"""Time [s], true x, y [m] and yaw [rad], and the command [m/s], [rad/s] in force from then on."""


@dataclass(frozen=True)
class StrideSlip:
    """One stride.

    Parameters
    ----------
    time : float
        At its end [s].
    point : (2,) float, map frame [m]
        Middle of the way of the body's centre.
    slip : float [-]
        1 - way / way that the same commands make on hard ground.
    turn : float [rad/s]
        Mean size of the commanded yaw rate.
    """

    time: float
    point: FloatArray
    slip: float
    turn: float


def ways_ahead(steps: FloatArray) -> FloatArray:
    """Return how far the body went along its heading between rows (n, >= 4) of steps, (n - 1,)."""
    yaw = steps[:-1, 3] + 0.5 * np.array([wrap(turn) for turn in np.diff(steps[:, 3])])
    step = np.diff(steps[:, 1:3], axis=0)
    return np.asarray(step[:, 0] * np.cos(yaw) + step[:, 1] * np.sin(yaw))


def on_hard_ground(steps: FloatArray, config: SimulatorConfiguration) -> FloatArray:
    """Return the steps (n, 6) that the same commands make on hard ground."""
    found = steps.copy()
    pose = tuple(float(value) for value in steps[0, 1:4])
    with HexapodSimulator(replace(config, soil='rigid', footprints=False), Terrain.uniform(1.0),
                          (pose[0], pose[1], pose[2])) as simulator:
        for row, following in zip(range(len(steps) - 1), steps[1:], strict=True):
            simulator.command(float(steps[row, 4]), float(steps[row, 5]))
            simulator.step(round((following[0] - steps[row, 0]) / config.time_step))
            found[row + 1, 1:4] = simulator.truth().pose
    return found


def strides_of(steps: Steps, config: SimulatorConfiguration) -> list[StrideSlip]:
    """Cut a run into strides and return the slip of those that have one."""
    table = np.array(steps)
    real, hard = ways_ahead(table), ways_ahead(on_hard_ground(table, config))
    period = 1.0 / config.stride_frequency
    strides, first = [], 0
    for last in range(1, len(table)):
        duration = table[last, 0] - table[first, 0]
        if duration < period - 1e-9:
            continue
        rows = slice(first, last)
        turn = float(np.abs(table[rows, 5]).mean())
        if hard[rows].sum() >= LEAST_SPEED * duration and turn <= LARGEST_TURN:
            strides.append(StrideSlip(float(table[last, 0]), table[rows, 1:3].mean(axis=0),
                                      float(1.0 - real[rows].sum() / hard[rows].sum()), turn))
        first = last
    return strides


def main(arguments: Sequence[str] | None = None) -> None:
    """Run env1 and compare the map's slip, and the true one, with that of the strides."""
    from psane_sim.catalogue import load_terrain
    from psane_sim.closed_loop import ClosedLoop, Settings
    from psane_sim.strength_field import interpolate
    from psane_sim.summary import Task

    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument('--seeds', type=int, default=5)
    terrain, settings = load_terrain('env1'), Settings()
    mapped, true = [], []
    for seed in range(parser.parse_args(arguments).seeds):
        loop = ClosedLoop(Task(terrain='env1', start=terrain.start, goal=terrain.goal,
                               strategy='psane_geodesic', threshold=0.5, seed=seed,
                               duration=120.0), terrain, terrain.start_pose, settings)
        loop.run()
        strides = strides_of(loop.record.steps, settings.simulator)
        points = np.array([stride.point for stride in strides]).reshape(-1, 2)
        slip = np.array([stride.slip for stride in strides])
        if loop.record.slip_mean is None or not strides:
            continue
        mapped.append(interpolate(loop.record.grid, loop.record.slip_mean, points) - slip)
        true.append(terrain.true_slip(points) - slip)
        print(f'seed {seed}: {len(slip)} strides; from the measured slip the map is off by '
              f'{_rmse(mapped[-1]):.3f}, the truth by {_rmse(true[-1]):.3f} (RMSE)', flush=True)
    for name, errors in (('map', np.concatenate(mapped)), ('truth', np.concatenate(true))):
        print(f'{name} - measured slip of {len(errors)} strides: RMSE {_rmse(errors):.3f}, mean '
              f'{errors.mean():+.3f}, median {np.median(errors):+.3f}')


def _rmse(errors: FloatArray) -> float:
    return math.sqrt(float(np.mean(np.square(errors))))


if __name__ == '__main__':
    main()
