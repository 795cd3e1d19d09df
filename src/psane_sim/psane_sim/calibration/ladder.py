# SPDX-License-Identifier: Apache-2.0
"""Walk over uniform ground of many strengths and measure slip: the reference ladder.

Run ``python -m psane_sim.calibration.ladder`` to print the measured ladder beside the reference.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from psane_mapping.leg import RobotModel
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.feed_forward import STRAIGHT_SWEEP, Sweep
from psane_sim.robot.gait import wrap
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.terrains.terrain import Terrain

REFERENCE_SPEED = (SimulatorConfiguration().speed_per_sweep * STRAIGHT_SWEEP
                   * SimulatorConfiguration().stride_frequency)
"""Commanded speed that makes the reference gait's sweep of 1.2 rad at 0.75 turns/s [m/s]."""

RIGID_SPEED = 0.318
"""Speed of the reference gait on rigid ground; slip is 1 - speed / this [m/s]."""

REFERENCE = {
    0.030: (1.00, 0.218), 0.048: (0.833, 0.158), 0.075: (0.500, 0.145), 0.119: (0.306, 0.137),
    0.189: (0.197, 0.124), 0.300: (0.141, 0.107), 0.475: (0.104, 0.078), 0.754: (0.090, 0.058),
    1.194: (0.082, 0.043), 1.893: (0.070, 0.031), 3.000: (0.060, 0.022),
}
"""Slip [-] and deepest leg [m] at each strength, from an independent prototype."""


@dataclass(frozen=True)
class Stride:
    """What was measured on ground of one strength.

    Parameters
    ----------
    strength : float [-]
    speed : float [m/s]
        Mean speed along the body's heading.
    yaw_rate : float [rad/s]
    slip : float [-]
        1 - speed / rigid speed.
    depth : float [m]
        Deepest that a leg went.
    tilt : float [rad]
        Largest tilt of the body.
    """

    strength: float
    speed: float
    yaw_rate: float
    slip: float
    depth: float
    tilt: float


def measure_slip(strength: float, *, linear: float = REFERENCE_SPEED, angular: float = 0.0,
                 warm_up: float = 4.0, duration: float = 8.0,
                 config: SimulatorConfiguration | None = None, robot: RobotModel | None = None,
                 rigid_speed: float = RIGID_SPEED, sweep: Sweep | None = None) -> Stride:
    """Walk on uniform ground and measure.

    Parameters
    ----------
    strength : float [-]
    linear, angular : float
        Commanded [m/s], [rad/s].
    warm_up, duration : float
        Walked before, and while, it is measured; best whole strides [s].
    config : SimulatorConfiguration, optional
    robot : RobotModel, optional
    rigid_speed : float
        Speed without slip for this command [m/s].
    sweep : Sweep, optional
        Walked instead of the command.
    """
    config = config or SimulatorConfiguration()
    terrain = Terrain.uniform(strength)
    with HexapodSimulator(config, terrain, (5.0, 5.0, 0.0), robot=robot) as simulator:
        if sweep is None:
            simulator.command(linear, angular)
        else:
            simulator.walk(sweep)
        simulator.step(round(warm_up / config.time_step))
        depth = tilt = turned = path = 0.0
        before = simulator.truth()
        chunk = round(0.01 / config.time_step)
        for _ in range(round(duration / (chunk * config.time_step))):
            simulator.step(chunk)
            now = simulator.truth()
            turn = wrap(now.yaw - before.yaw)
            turned += turn
            step, middle = now.position - before.position, before.yaw + 0.5 * turn
            path += float(step[0] * np.cos(middle) + step[1] * np.sin(middle))
            depth = max(depth, float(now.foot_depth.max()))
            tilt = max(tilt, now.tilt)
            before = now
    speed = path / duration
    return Stride(strength, speed, turned / duration, 1.0 - speed / rigid_speed, depth, tilt)


def measure_creep(strength: float, *, settle: float = 2.0, duration: float = 2.0,
                  config: SimulatorConfiguration | None = None) -> float:
    """Return how fast a standing robot moves [m/s], after it has settled."""
    config = config or SimulatorConfiguration()
    with HexapodSimulator(config, Terrain.uniform(strength), (5.0, 5.0, 0.0)) as simulator:
        simulator.step(round(settle / config.time_step))
        before = simulator.truth().position
        simulator.step(round(duration / config.time_step))
        return float(np.linalg.norm(simulator.truth().position - before)) / duration


def measure_ladder(strengths: Sequence[float] = tuple(REFERENCE)) -> list[Stride]:
    """Walk the reference gait over each strength."""
    return [measure_slip(strength) for strength in strengths]


def main() -> None:
    """Print the measured ladder beside the reference."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument('strengths', nargs='*', type=float, default=list(REFERENCE))
    print('strength  slip  (reference)  deepest mm (reference)  tilt deg  creep mm/s')
    for strength in parser.parse_args().strengths:
        stride = measure_slip(strength)
        slip, depth = REFERENCE.get(strength, (float('nan'), float('nan')))
        creep = 1e3 * measure_creep(strength)
        print(f'{strength:8.3f} {stride.slip:6.3f} ({slip:5.3f}) {1e3 * stride.depth:10.0f} '
              f'({1e3 * depth:3.0f}) {np.degrees(stride.tilt):10.1f} {creep:10.4f}', flush=True)


if __name__ == '__main__':
    main()
