# SPDX-License-Identifier: Apache-2.0
"""Random Twist sequences on random ground, to see whether the robot ever falls over.

``python -m psane_sim.calibration.twist_trials [--count 1000] [--seed 0]`` prints how many
sequences it fell in, and which of them tilted the body the most.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.terrains.terrain import Terrain

FALLEN = 1.0
"""Tilt at which a robot counts as fallen [rad]."""


@dataclass(frozen=True)
class TwistTrial:
    """How one sequence went: its seed, strength of the ground [-] and largest tilt [rad]."""

    seed: int
    strength: float
    tilt: float


def walk_at_random(seed: int, commands: int = 4) -> TwistTrial:
    """Walk one random sequence, a fifth of which is standing, beyond the limits included."""
    generator = np.random.default_rng(seed)
    strength = float(np.exp(generator.uniform(np.log(0.015), np.log(3.0))))
    config = SimulatorConfiguration(footprints=bool(generator.random() < 0.5))
    tilt = 0.0
    with HexapodSimulator(config, Terrain.uniform(strength), (5.0, 5.0, 0.0)) as robot:
        for _ in range(commands):
            stands = generator.random() < 0.2
            robot.command(*((0.0, 0.0) if stands else generator.uniform(-0.6, 0.6, 2)))
            for _ in range(round(generator.uniform(4.0, 30.0))):
                robot.step(50)
                tilt = max(tilt, robot.truth().tilt)
    return TwistTrial(seed, strength, tilt)


def main(arguments: Sequence[str] | None = None) -> None:
    """Walk random sequences; the status is 1 when the robot fell in any."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument('--count', type=int, default=1000)
    parser.add_argument('--seed', type=int, default=0)
    options = parser.parse_args(arguments)
    trials = []
    for index in range(options.count):
        trials.append(walk_at_random(options.seed + index))
        if (index + 1) % 50 == 0:
            print(f'{index + 1} of {options.count}', file=sys.stderr, flush=True)
    worst = max(trials, key=lambda trial: trial.tilt)
    fallen = sum(trial.tilt > FALLEN for trial in trials)
    print(f'{fallen} of {len(trials)} fell; largest tilt {np.degrees(worst.tilt):.1f} deg '
          f'(seed {worst.seed}, strength {worst.strength:.3f})')
    sys.exit(1 if fallen else 0)


if __name__ == '__main__':
    main()
