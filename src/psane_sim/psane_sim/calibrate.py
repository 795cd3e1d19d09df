# SPDX-License-Identifier: Apache-2.0
"""The command `calibrate`: walk a robot over a ladder of strengths, write what was learnt.

``./psane run psane_sim calibrate --out DIR`` writes DIR/ROBOT.yaml, which mapper and simulator
load with ``--params-file``, and figures beside it.
"""

import argparse
import os
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from psane_mapping.leg import RobotModel
from psane_mapping.slip import RotaryWalking
from psane_sim.calibration import (
    Calibration,
    SlipFit,
    SweepResponse,
    fit_feed_forward,
    fit_slip,
    mapper_parameters,
)
from psane_sim.calibration_figures import draw_calibration
from psane_sim.errors import SimulationError
from psane_sim.feed_forward import STRAIGHT_SWEEP, sweeps_of
from psane_sim.ladder import REFERENCE, Stride, measure_slip
from psane_sim.robots import Robot, read_robot, robot_names

TWISTS = ((0.08, 0.0), (0.15, 0.0), (0.22, 0.0), (0.28, 0.0), (0.15, 0.1), (0.22, 0.1),
          (0.22, 0.2), (0.28, 0.1), (-0.1, 0.0), (-0.15, 0.0), (-0.15, 0.05), (0.0, 0.2),
          (0.0, 0.4))
"""Walked for the feed-forward, at the gait's default frequency [m/s], [rad/s]."""

FIRM = (0.3, 0.75, 2.0)
"""Strengths on which the feed-forward is to hold, on the default robot's ladder [-]."""


@dataclass(frozen=True)
class Walk:
    """One walk of a calibration.

    Parameters
    ----------
    purpose : str
        'rigid', 'slip' or 'twist'.
    robot : str
        Name or file.
    strength, linear, angular : float [-], [m/s], [rad/s]
    strides : int
        Measured, after half as many that are not.
    """

    purpose: str
    robot: str
    strength: float
    linear: float
    angular: float
    strides: int

    def run(self) -> Stride:
        """Walk."""
        robot = read_robot(self.robot)
        config = robot.configuration(soil='rigid' if self.purpose == 'rigid' else 'granular')
        stride = 1.0 / config.stride_frequency
        return measure_slip(
            self.strength, linear=self.linear, angular=self.angular,
            warm_up=max(2, self.strides // 2) * stride, duration=self.strides * stride,
            config=config, robot=robot.model)


def strength_scale(model: RobotModel) -> float:
    """Return how much firmer than for the default robot the ground must be to carry this one.

    A leg of width w and radius R that is loaded with m g sinks by m g / (strength w R) or so; what
    counts is that depth as a share of R.
    """
    default = RobotModel()

    def load(robot: RobotModel) -> float:
        return robot.mass / (robot.leg_width * robot.leg_radius**2)

    return load(model) / load(default)


def rotary_walking(robot: Robot) -> RotaryWalking:
    """Return the published model for a robot; stiffness goes with the size of its legs."""
    model, default, published = robot.model, RobotModel(), RotaryWalking()
    frequency = robot.configuration().stride_frequency
    size = model.leg_width * model.leg_radius / (default.leg_width * default.leg_radius)
    return RotaryWalking(
        mass=model.mass, leg_radius=model.leg_radius, hip_height=model.hip_above_belly,
        angular_velocity=2.0 * np.pi * frequency, loading_time=0.3 / frequency,
        unit_stiffness=size * published.unit_stiffness)


def reference_speed(robot: Robot) -> float:
    """Return the command that makes the reference sweep of 1.2 rad [m/s]."""
    config = robot.configuration()
    return min(config.speed_limit,
               config.speed_per_sweep * STRAIGHT_SWEEP * config.stride_frequency)


def plan(name: str, strides: int) -> list[Walk]:
    """Return all walks of a calibration."""
    robot = read_robot(name)
    scale, speed = strength_scale(robot.model), reference_speed(robot)
    pace = robot.configuration().stride_frequency / 0.75 * robot.model.leg_radius / 0.0875
    walks = [Walk('rigid', name, 1.0, speed, 0.0, strides)]
    walks += [Walk('slip', name, scale * strength, speed, 0.0, strides) for strength in REFERENCE]
    walks += [Walk('twist', name, scale * strength, pace * linear, angular, strides)
              for strength in FIRM for linear, angular in TWISTS]
    return walks


def walk_all(walks: Sequence[Walk], jobs: int) -> dict[Walk, Stride]:
    """Run walks in processes of their own and show how far they are."""
    found: dict[Walk, Stride] = {}
    with ProcessPoolExecutor(jobs, mp_context=get_context('spawn')) as pool:
        running = {pool.submit(walk.run): walk for walk in walks}
        for done in as_completed(running):
            found[running[done]] = done.result()
            _show(len(found), len(walks))
    print(file=sys.stderr)
    return found


def _show(done: int, total: int, width: int = 40) -> None:
    full = width * done // total
    print(f'\rwalking [{"#" * full}{"." * (width - full)}] {done}/{total}', end='',
          file=sys.stderr, flush=True)


def calibration_of(name: str, found: dict[Walk, Stride]) -> tuple[Calibration, SlipFit]:
    """Fit everything to the walks."""
    config = read_robot(name).configuration()
    rigid = next(stride.speed for walk, stride in found.items() if walk.purpose == 'rigid')
    ladder = sorted((walk.strength, 1.0 - stride.speed / rigid)
                    for walk, stride in found.items() if walk.purpose == 'slip')
    strength, slip = np.array(ladder).T
    fit = fit_slip(strength, slip)
    responses: dict[str, list[SweepResponse]] = {'forward': [], 'backward': [], 'spot': []}
    for walk, stride in found.items():
        if walk.purpose == 'twist':
            sweep = sweeps_of(walk.linear, walk.angular, config)
            kind = ('spot' if sweep.swing_left != sweep.swing_right
                    else 'forward' if sweep.swing_left > 0.0 else 'backward')
            responses[kind].append(SweepResponse(sweep.left, sweep.right, stride.speed,
                                                 stride.yaw_rate))
    simulator = fit_feed_forward(responses['forward'], responses['backward'], responses['spot'],
                                 config.stride_frequency)
    return Calibration(mapper_parameters(fit.curve), simulator, rigid, fit.rmse), fit


def spearman(strides: Iterable[tuple[float, float]]) -> float:
    """Return the rank correlation of pairs."""
    ranks = np.argsort(np.argsort(np.array(list(strides)), axis=0), axis=0)
    return float(np.asarray(np.corrcoef(ranks.T))[0, 1])


def main(arguments: Sequence[str] | None = None) -> None:
    """Calibrate a robot."""
    parser = argparse.ArgumentParser(prog='calibrate', description=__doc__.splitlines()[0])
    parser.add_argument('--robot', default='x_rhex',
                        help=f'one of {robot_names()}, or a YAML file')
    parser.add_argument('--out', type=Path, default=Path('calibration'), help='folder to write to')
    parser.add_argument('--jobs', type=int, default=os.cpu_count() or 1, help='processes')
    parser.add_argument('--strides', type=int, default=6, help='measured strides of each walk')
    options = parser.parse_args(arguments)
    try:
        found = walk_all(plan(options.robot, options.strides), options.jobs)
    except SimulationError as error:
        parser.exit(2, f'calibrate: {error}\n')
    calibration, fit = calibration_of(options.robot, found)
    options.out.mkdir(parents=True, exist_ok=True)
    name = Path(options.robot).stem
    calibration.write(options.out / f'{name}.yaml')
    draw_calibration(options.out / f'{name}.png', found, calibration, fit,
                     rotary_walking(read_robot(options.robot)))
    pairs = sorted((walk.strength, 1.0 - stride.speed / calibration.rigid_speed)
                   for walk, stride in found.items() if walk.purpose == 'slip')
    for strength, slip in pairs:
        print(f'strength {strength:8.3f}  slip {slip:6.3f}  '
              f'curve {float(fit.curve.slip(strength)):6.3f}')
    print(f'rigid speed {calibration.rigid_speed:.4f} m/s, rank correlation '
          f'{spearman(pairs):.3f}, RMSE {fit.rmse:.4f}; wrote {options.out / name}.yaml')


if __name__ == '__main__':
    main()
