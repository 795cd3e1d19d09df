# SPDX-License-Identifier: Apache-2.0
"""The command `soil_figures`: how a robot walks on every soil, and SandBot on granular ground.

``./psane run psane_sim soil_figures --out docs`` writes soils.png and sandbot.png.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from psane_sim.calibration.ladder import Stride, measure_slip
from psane_sim.configuration import SOIL_NAMES, SimulatorConfiguration
from psane_sim.robot.feed_forward import STRAIGHT_SWEEP
from psane_sim.robot.robots import read_robot

STRENGTHS = (0.004, 0.008, 0.016, 0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 3.0)
FREQUENCIES = (0.5, 1.0, 2.0, 3.0, 4.0, 5.0)
SANDBOT_STRENGTHS = (10.0, 3.0, 1.0, 0.6)
PUBLISHED_HARD, PUBLISHED_GRANULAR = 0.6, 0.3
"""SandBot's best speeds on hard and on granular ground (Li et al. 2009), about [m/s]."""


def walk_on(soil: str, strength: float) -> Stride:
    """Walk the default robot on one soil."""
    config = SimulatorConfiguration(soil=soil)
    stride = 1.0 / config.stride_frequency
    return measure_slip(strength, config=config, warm_up=4 * stride, duration=4 * stride)


def sandbot_speed(frequency: float, strength: float | None) -> float:
    """Return SandBot's speed at a limb frequency [Hz]; on hard ground without a strength [m/s]."""
    robot = read_robot('sandbot')
    config = robot.configuration(
        stride_frequency=frequency, speed_limit=5.0,
        soil='rigid' if strength is None else 'granular')
    speed = config.speed_per_sweep * STRAIGHT_SWEEP * frequency
    return measure_slip(strength or 1.0, config=config, robot=robot.model, linear=speed,
                        warm_up=4.0 / frequency, duration=6.0 / frequency).speed


def _draw_soils(path: Path, pyplot: Any) -> None:
    figure, (slip, depth) = pyplot.subplots(1, 2, figsize=(10.5, 4.0), constrained_layout=True)
    for soil in SOIL_NAMES:
        walked = [walk_on(soil, strength) for strength in STRENGTHS]
        slip.plot(STRENGTHS, [stride.slip for stride in walked], '.-', label=soil)
        depth.plot(STRENGTHS, [1e3 * stride.depth for stride in walked], '.-', label=soil)
        print(f'walked on {soil}', file=sys.stderr, flush=True)
    slip.set(xscale='log', xlabel='strength [-]', ylabel='slip [-]')
    depth.set(xscale='log', xlabel='strength [-]', ylabel='deepest leg [mm]')
    slip.legend(fontsize=7)
    for axes in (slip, depth):
        axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def _draw_sandbot(path: Path, pyplot: Any) -> None:
    figure, axes = pyplot.subplots(figsize=(6.0, 4.0), constrained_layout=True)
    axes.plot(FREQUENCIES, [sandbot_speed(frequency, None) for frequency in FREQUENCIES], 'k.-',
              label='hard ground')
    for strength in SANDBOT_STRENGTHS:
        axes.plot(FREQUENCIES, [sandbot_speed(frequency, strength) for frequency in FREQUENCIES],
                  '.-', label=f'strength {strength:g}')
        print(f'SandBot walked at strength {strength:g}', file=sys.stderr, flush=True)
    for speed, what in ((PUBLISHED_HARD, 'hard'), (PUBLISHED_GRANULAR, 'granular')):
        axes.axhline(speed, color='0.6', ls='--', lw=1)
        axes.text(0.5, speed + 0.01, f'published, about, {what} ground', fontsize=7, color='0.4')
    axes.set(xlabel='limb frequency [Hz]', ylabel='speed [m/s]')
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def main(arguments: Sequence[str] | None = None) -> None:
    """Walk on every soil, and draw how it went."""
    import matplotlib

    matplotlib.use('Agg')
    from matplotlib import pyplot

    parser = argparse.ArgumentParser(prog='soil_figures', description=main.__doc__)
    parser.add_argument('--out', type=Path, default=Path('.'), help='folder to write to')
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    _draw_soils(options.out / 'soils.png', pyplot)
    _draw_sandbot(options.out / 'sandbot.png', pyplot)


if __name__ == '__main__':
    main()
