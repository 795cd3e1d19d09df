# SPDX-License-Identifier: Apache-2.0
"""How wrong the contacts of whole runs are: what the stand-in's simulated touch is made after.

``python -m psane_sim.calibration.contact_errors`` runs env1 and env2 on the physics, with the
published noise, and prints it.
"""

import argparse
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from psane_mapping.sample import TerrainSample
from psane_sim.terrains.terrain import Terrain

SLIPS = (0.2, 0.7)
"""True slips between which contacts count: where it is decided what is certified [-]."""

FEWEST = 10
"""Contacts below which a run says nothing [count]."""


class ContactErrors(NamedTuple):
    """Errors of a run's contacts against the ground right under the foot.

    Parameters
    ----------
    contacts : int
    log_bias, log_deviation : float
        Mean and standard deviation of the error of the natural logarithm of strength [-].
    slip_bias, slip_deviation : float
        The same of slip [-].
    """

    contacts: int
    log_bias: float
    log_deviation: float
    slip_bias: float
    slip_deviation: float


def errors_of_run(samples: Sequence[TerrainSample], terrain: Terrain) -> ContactErrors | None:
    """Compare a run's accepted contacts with the true ground; None for too few that count."""
    points = np.array([sample.point for sample in samples]).reshape(-1, 2)
    slip = terrain.true_slip(points)
    felt = np.array([(math.log(sample.strength), sample.slip)
                     for sample in samples]).reshape(-1, 2)
    counts = (slip >= SLIPS[0]) & (slip <= SLIPS[1])
    if int(counts.sum()) < FEWEST:
        return None
    errors = (felt - np.column_stack((np.log(terrain.strength(points)), slip)))[counts]
    (log_bias, slip_bias), (log_own, slip_own) = errors.mean(axis=0), errors.std(axis=0)
    return ContactErrors(len(errors), float(log_bias), float(log_own), float(slip_bias),
                         float(slip_own))


def main(arguments: Sequence[str] | None = None) -> None:
    """Run terrains and print how wrong the contacts of each run were."""
    from psane_sim.runs.closed_loop import ClosedLoop, Settings
    from psane_sim.runs.summary import Task
    from psane_sim.terrains.catalogue import load_terrain

    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument('--seeds', type=int, default=8, help='runs on each terrain')
    parser.add_argument('--terrains', nargs='+', default=['env1', 'env2'], metavar='TERRAIN')
    options = parser.parse_args(arguments)
    found = []
    for name in options.terrains:
        terrain = load_terrain(name)
        for seed in range(options.seeds):
            loop = ClosedLoop(Task(terrain=name, start=terrain.start, goal=terrain.goal,
                                   strategy='psane_geodesic', threshold=0.5, seed=seed,
                                   duration=200.0), terrain, terrain.start_pose, Settings())
            loop.run()
            errors = errors_of_run(loop.record.samples, terrain)
            if errors is None:
                continue
            found.append(errors)
            print(f'{name} seed {seed}: {errors.contacts} contacts; log-strength '
                  f'{errors.log_bias:+.3f} +- {errors.log_deviation:.3f}, slip '
                  f'{errors.slip_bias:+.4f} +- {errors.slip_deviation:.4f}', flush=True)
    if found:
        table = np.array(found)
        bias = np.sqrt(np.mean(np.square(table[:, (1, 3)]), axis=0))
        own = np.sqrt(np.mean(np.square(table[:, (2, 4)]), axis=0))
        print(f'{len(found)} runs: what a run has in common is {bias[0]:.3f} in log-strength, '
              f'{bias[1]:.4f} in slip; each contact adds {own[0]:.3f} and {own[1]:.4f} (RMS)')


if __name__ == '__main__':
    main()
