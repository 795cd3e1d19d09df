# SPDX-License-Identifier: Apache-2.0
"""How fast the simulator runs on this machine, and what its time goes into.

Run ``python -m psane_sim.simulator_benchmark [--json]``.
"""

import argparse
import json
import time
from statistics import median

from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.terrains.catalogue import load_terrain

PARTS = 5

MEANINGS = {
    'rtf_simulator': 'simulated / wall time, walking on env1 with footprints, one core',
    'engine_step_us': "the engine's own step",
    'soil_us': 'granular soil with footprints under six legs and the belly',
    'state_us': "reading the engine's state",
    'forces_us': 'handing over forces and motor speeds',
    'gait_us': 'reference angles of the legs',
}
"""What each figure is; the last five are medians per tick in microseconds."""


def measure(duration: float = 10.0) -> dict[str, float]:
    """Return the figures of `MEANINGS`, measured now.

    Parameters
    ----------
    duration : float
        Simulated time that is walked for the real-time factor [s]; it is the best of five parts,
        since on a machine that is busy with something else the others measure that.
    """
    config = SimulatorConfiguration(footprints=True)
    with HexapodSimulator(config, load_terrain('env1'), (2.0, 7.0, 0.0)) as simulator:
        simulator.command(0.2, 0.15)
        simulator.step(1000)
        ticks = round(duration / PARTS / config.time_step)
        walls = []
        for _ in range(PARTS):
            began = time.perf_counter()
            simulator.step(ticks)
            walls.append(time.perf_counter() - began)
        return {'rtf_simulator': ticks * config.time_step / min(walls),
                **tick_costs(simulator, 2000)}


def tick_costs(simulator: HexapodSimulator, ticks: int) -> dict[str, float]:
    """Walk on with each part of a tick timed, and return the median of each [us]."""
    engine = simulator.engine
    parts = {
        'gait_us': simulator.gait.tick,
        'soil_us': lambda: simulator.soil.load(engine.state, simulator.config.time_step),
        'forces_us': simulator.apply_forces,
        'engine_step_us': engine.step,
        'state_us': engine.read,
    }
    spent: dict[str, list[float]] = {name: [] for name in parts}
    for _ in range(ticks):
        for name, part in parts.items():
            began = time.perf_counter()
            part()
            spent[name].append(1.0e6 * (time.perf_counter() - began))
    return {name: median(times) for name, times in spent.items()}


def main() -> None:
    """Print how fast the simulator runs here, and what its time goes into."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument('--json', action='store_true', help='one JSON object of named numbers')
    figures = measure()
    if parser.parse_args().json:
        print(json.dumps(figures))
    else:
        for name, value in figures.items():
            print(f'{name:16s} {value:8.2f}  {MEANINGS[name]}')


if __name__ == '__main__':
    main()
