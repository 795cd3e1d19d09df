# SPDX-License-Identifier: Apache-2.0
"""The command `calibrate`: walk a robot over a ladder of strengths, write what was learnt.

``./psane run psane_sim calibrate --out DIR`` writes DIR/ROBOT.yaml, which mapper and simulator
load with ``--params-file``, DIR/ROBOT_walks.csv, which `stride_slip` compares strides with, and
figures beside them.
"""

import argparse
import os
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from psane_mapping.leg import RobotModel
from psane_mapping.slip import RotaryWalking
from psane_sim.calibration.calibration import (
    Calibration,
    SlipFit,
    SweepResponse,
    fit_feed_forward,
    fit_slip,
    mapper_parameters,
)
from psane_sim.calibration.figures import draw_calibration
from psane_sim.calibration.ladder import REFERENCE, Stride, measure_slip
from psane_sim.calibration.steered_walks import SteeredWalks
from psane_sim.calibration.twist_tracking import centred, tracking_of
from psane_sim.errors import SimulationError
from psane_sim.robot.chosen_robot import strength_scale
from psane_sim.robot.feed_forward import STRAIGHT_SWEEP, Sweep
from psane_sim.robot.robots import Robot, read_robot, robot_names

TWISTS = ((0.08, 0.0), (0.15, 0.0), (0.22, 0.0), (0.28, 0.0), (0.15, 0.1), (0.22, 0.1),
          (0.22, 0.2), (0.28, 0.1), (-0.1, 0.0), (-0.15, 0.0), (-0.22, 0.0),
          (-0.15, 0.05), (0.0, 0.1), (0.0, 0.2), (0.0, 0.4))
"""Walked to see how well the feed-forward is followed, at 0.75 strides/s [m/s], [rad/s]."""

FIRM = (0.3, 0.6, 1.2, 3.0)
"""Strengths on which the feed-forward is to hold, on the default robot's ladder [-]."""

STEERED = (0.04, 0.055, 0.075, 0.11, 0.17, *FIRM)
"""Strengths on which walks of all sweeps are measured, on the same ladder [-]."""

MEANS, HALVES = (0.0, 0.35, 0.7, 1.05, 1.4), (0.0, 0.35, 0.7, 1.05)
"""Mean and half difference of the sweeps of those walks [rad]."""

LEAST_MEAN = 0.3
"""Mean sweep from which walks forward count for the feed-forward [rad]."""

BACKWARD = tuple(Sweep(-mean - half, -mean + half, -1.0, -1.0)
                 for mean, half in ((0.4, 0.0), (0.8, 0.0), (1.2, 0.0), (0.5, 0.15), (0.8, 0.15),
                                    (0.8, 0.3)))
SPOT = tuple(Sweep(-half, half, -1.0, 1.0) for half in (0.2, 0.4, 0.6, 0.8, 1.0))
"""Sweeps of walks backward and on the spot."""


@dataclass(frozen=True)
class Walk:
    """One walk of a calibration.

    Parameters
    ----------
    purpose : str
        'rigid', 'slip', 'sweep' or 'twist'.
    robot : str
        Name or file.
    strength, linear, angular : float [-], [m/s], [rad/s]
    strides : int
        Measured, after half as many that are not.
    sweep : Sweep, optional
        Walked instead of the Twist.
    gait : tuple of (name, value)
        Of the simulator's configuration, where they are not the robot's own.
    """

    purpose: str
    robot: str
    strength: float
    linear: float
    angular: float
    strides: int
    sweep: Sweep | None = None
    gait: tuple[tuple[str, float], ...] = ()

    def run(self) -> Stride:
        """Walk."""
        robot = read_robot(self.robot)
        config = robot.configuration(soil='rigid' if self.purpose == 'rigid' else 'granular',
                                     **dict(self.gait))
        stride = 1.0 / config.stride_frequency
        return measure_slip(
            self.strength, linear=self.linear, angular=self.angular, sweep=self.sweep,
            warm_up=max(2, self.strides // 2) * stride, duration=self.strides * stride,
            config=config, robot=robot.model)


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
    """Return the walks of a calibration that parameters are fitted to."""
    robot = read_robot(name)
    scale, speed = strength_scale(robot.model), reference_speed(robot)
    walks = [Walk('rigid', name, 1.0, speed, 0.0, strides)]
    walks += [Walk('slip', name, scale * strength, speed, 0.0, strides) for strength in REFERENCE]
    forward = [Sweep(mean - half, mean + half) for mean in MEANS for half in HALVES]
    sweeps = [(strength, sweep) for strength in STEERED for sweep in forward]
    sweeps += [(strength, sweep) for strength in FIRM for sweep in BACKWARD + SPOT]
    walks += [Walk('sweep', name, scale * strength, 0.0, 0.0, min(strides, 4), sweep)
              for strength, sweep in sweeps]
    return walks


def plan_twists(name: str, gait: dict[str, float], strides: int) -> list[Walk]:
    """Return walks that show how well a fitted feed-forward is followed."""
    robot = read_robot(name)
    scale = strength_scale(robot.model)
    pace = robot.configuration().stride_frequency / 0.75
    speed = pace * robot.model.leg_radius / RobotModel().leg_radius
    return [Walk('twist', name, scale * strength, speed * linear, angular, strides,
                 gait=tuple(gait.items()))
            for strength in FIRM for linear, angular in TWISTS]


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
    firm = [strength_scale(read_robot(name).model) * strength for strength in FIRM]
    for walk, stride in found.items():
        sweep = walk.sweep
        if sweep is not None and walk.strength in firm and is_usual(sweep, config.sweep_limit):
            responses[sweep.kind].append(SweepResponse(sweep.left, sweep.right, stride.speed,
                                                       stride.yaw_rate))
    simulator = fit_feed_forward(responses['forward'], responses['backward'], responses['spot'],
                                 config.stride_frequency)
    return Calibration(mapper_parameters(fit.curve), simulator, rigid, fit.rmse), fit


def is_usual(sweep: Sweep, limit: float) -> bool:
    """Tell whether a gait walks like this often: no march, no arc on one side's legs alone."""
    mean, half = 0.5 * (sweep.left + sweep.right), 0.5 * (sweep.right - sweep.left)
    if sweep.kind == 'forward' and mean < LEAST_MEAN:
        return False
    return abs(mean) + abs(half) <= limit + 1e-9


def steered_walks_of(name: str, found: dict[Walk, Stride], rigid_speed: float) -> SteeredWalks:
    """Put together the walks of all sweeps; their slip is that of the straight reference walk."""
    robot = read_robot(name)
    scale, frequency = strength_scale(robot.model), robot.configuration().stride_frequency
    shape = (len(STEERED), len(MEANS), len(HALVES))
    advance, turn = np.zeros(shape), np.zeros(shape)
    by_sweep = {(walk.strength, walk.sweep): stride for walk, stride in found.items()}
    for i, j, k in np.ndindex(shape):
        sweep = Sweep(MEANS[j] - HALVES[k], MEANS[j] + HALVES[k])
        stride = by_sweep[scale * STEERED[i], sweep]
        advance[i, j, k], turn[i, j, k] = stride.speed / frequency, stride.yaw_rate / frequency
    straight = np.array([np.interp(STRAIGHT_SWEEP, MEANS, row) for row in advance[:, :, 0]])
    return SteeredWalks(scale * np.array(STEERED), np.array(MEANS), np.array(HALVES), advance,
                        turn, 1.0 - frequency * straight / rigid_speed)


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
    trial = walk_all(plan_twists(options.robot, calibration.simulator, options.strides),
                     options.jobs)
    calibration = replace(calibration,
                          simulator=centred(calibration.simulator, tracking_of(trial)))
    found |= walk_all(plan_twists(options.robot, calibration.simulator, options.strides),
                      options.jobs)
    options.out.mkdir(parents=True, exist_ok=True)
    name = Path(options.robot).stem
    calibration.write(options.out / f'{name}.yaml')
    steered_walks_of(options.robot, found, calibration.rigid_speed).write(
        options.out / f'{name}_walks.csv')
    draw_calibration(options.out / f'{name}.png', found, calibration, fit,
                     rotary_walking(read_robot(options.robot)))
    pairs = sorted((walk.strength, 1.0 - stride.speed / calibration.rigid_speed)
                   for walk, stride in found.items() if walk.purpose == 'slip')
    for strength, slip in pairs:
        print(f'strength {strength:8.3f}  slip {slip:6.3f}  '
              f'curve {float(fit.curve.slip(strength)):6.3f}')
    for tracking in tracking_of(found):
        low, high = tracking.speed
        slow, fast = tracking.turn
        print(f'{tracking.kind:8s} speed {low:+.1%} .. {high:+.1%}  yaw rate {slow:+.1%} .. '
              f'{fast:+.1%} of what was asked, on firm ground')
    print(f'rigid speed {calibration.rigid_speed:.4f} m/s, rank correlation '
          f'{spearman(pairs):.3f}, RMSE {fit.rmse:.4f}; wrote {options.out / name}.yaml')


if __name__ == '__main__':
    main()
