# SPDX-License-Identifier: Apache-2.0
"""What a walk over many strengths says of a robot: slip curve, feed-forward, rigid speed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.optimize import least_squares, linprog

from psane_mapping.errors import ParameterError
from psane_mapping.grid import FloatArray
from psane_mapping.slip import CalibratedSlipCurve
from psane_sim.robot.feed_forward import UNPUSHED_SWEEP

LEAST_FACTOR = 0.01
"""No factor of the feed-forward may be smaller: it would ask for sweeps without end."""

POWERS = np.round(np.arange(0.7, 1.41, 0.02), 2)
"""Of the half difference of sweeps, that are tried [-]."""

MAPPER, SIMULATOR = 'terrain_mapper', 'hexapod_sim'
"""The nodes that a calibration is for."""


@dataclass(frozen=True)
class SlipFit:
    """A falling curve through measured slip, with its uncertainty.

    Parameters
    ----------
    curve : CalibratedSlipCurve
    rmse : float
        Of slip around the curve [-].
    strength, low, high : (n,) float [-]
        Band that holds 90 % of measurements: the curve's own uncertainty and their scatter.
    """

    curve: CalibratedSlipCurve
    rmse: float
    strength: FloatArray
    low: FloatArray
    high: FloatArray


def fit_slip(strength: FloatArray, slip: FloatArray, *, draws: int = 40, seed: int = 0) -> SlipFit:
    """Fit the calibrated curve to slip (n,) measured at strengths (n,).

    Notes
    -----
    Least squares in the four parameters, which are bounded so that the curve falls. The band is
    from fits to residuals drawn with replacement (the residual bootstrap).
    """
    curve = _fitted(strength, slip)
    residual = slip - curve.slip(strength)
    generator = np.random.default_rng(seed)
    grid = np.geomspace(strength.min(), strength.max(), 60)
    others = np.array([
        _fitted(strength, curve.slip(strength) + generator.choice(residual, len(residual))
                ).slip(grid) + generator.choice(residual, len(grid)) for _ in range(draws)])
    low, high = np.quantile(others, (0.05, 0.95), axis=0)
    return SlipFit(curve, float(np.sqrt(np.mean(residual**2))), grid, np.minimum(low, 1.0),
                   np.minimum(high, 1.0))


def _fitted(strength: FloatArray, slip: FloatArray) -> CalibratedSlipCurve:
    def curve_of(values: FloatArray) -> CalibratedSlipCurve:
        residual, amplitude, log_half, exponent = (float(value) for value in values)
        return CalibratedSlipCurve(residual=residual, amplitude=amplitude,
                                   half_strength=math.exp(log_half), exponent=exponent)

    measured = np.clip(slip, 0.0, 1.0)
    best = least_squares(lambda values: curve_of(values).slip(strength) - measured,
                         (0.08, 1.1, math.log(0.06), 2.0),
                         bounds=((0.0, 0.2, -6.0, 0.5), (0.5, 4.0, 4.0, 8.0)))
    return curve_of(best.x)


@dataclass(frozen=True)
class SweepResponse:
    """What two stance sweeps made the robot do on firm ground.

    Parameters
    ----------
    left, right : float [rad]
    linear, angular : float
        Speed [m/s] and yaw rate [rad/s].
    """

    left: float
    right: float
    linear: float
    angular: float


def fit_feed_forward(forward: Sequence[SweepResponse], backward: Sequence[SweepResponse],
                     spot: Sequence[SweepResponse], frequency: float) -> dict[str, float]:
    """Return the feed-forward's parameters (see `SimulatorConfiguration`).

    Notes
    -----
    With mean m and half difference d of the sweeps, forward: v / f = a m + b |d| (1 - m / 1.4) and
    w / f = (c + e m) d^p; backward: v / f = a' m, w / f = c' d; on the spot: w / f = c'' d^q. The
    largest relative error is made as small as can be (a linear programme; p and q by trial); no
    factor is below `LEAST_FACTOR`.
    """
    mean, half, speed, turn = _columns(forward, frequency)
    push = np.abs(half) * np.maximum(0.0, 1.0 - mean / UNPUSHED_SWEEP)
    along, pushed = _positive(np.column_stack((mean, push)), speed)[0]
    (constant, gain), exponent = _with_power(half, np.column_stack((np.ones_like(mean), mean)),
                                             turn)
    back, around = _columns(backward, frequency), _columns(spot, frequency)
    (spot_turn,), spot_exponent = _with_power(around[1], np.ones((len(around[1]), 1)), around[3])
    return {
        'speed_per_sweep': along, 'speed_per_turn': pushed, 'turn_per_sweep': constant,
        'turn_gain': gain, 'turn_exponent': exponent,
        'backward_speed_per_sweep': _positive(back[0][:, None], back[2])[0][0],
        'backward_turn_per_sweep': _positive(back[1][:, None], back[3])[0][0],
        'spot_turn_per_sweep': spot_turn, 'spot_turn_exponent': spot_exponent,
    }


def _columns(responses: Sequence[SweepResponse], frequency: float
             ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return mean and half difference of sweeps [rad], speed [m] and turn [rad] of a stride."""
    table = np.array([(r.left, r.right, r.linear, r.angular) for r in responses])
    left, right, linear, angular = table.T
    return 0.5 * (left + right), 0.5 * (right - left), linear / frequency, angular / frequency


def _with_power(base: FloatArray, columns: FloatArray, target: FloatArray
                ) -> tuple[list[float], float]:
    """Return factors of the columns times a power of the base, and the power that fits best."""
    trials = []
    for power in POWERS:
        scaled = (np.sign(base) * np.abs(base)**power)[:, None] * columns
        trials.append((*_positive(scaled, target), float(power)))
    factors, _, best = min(trials, key=lambda trial: trial[1])
    return factors, best


def _positive(columns: FloatArray, target: FloatArray) -> tuple[list[float], float]:
    """Return factors whose largest relative error is least, and that error.

    Targets near 0 count less.
    """
    size = np.maximum(np.abs(target), 0.3 * np.abs(target).max() + 1e-9)
    rows, wanted = columns / size[:, None], target / size
    slack = -np.ones((len(rows), 1))
    found = linprog(np.append(np.zeros(columns.shape[1]), 1.0),
                    A_ub=np.vstack((np.hstack((rows, slack)), np.hstack((-rows, slack)))),
                    b_ub=np.concatenate((wanted, -wanted)),
                    bounds=[(LEAST_FACTOR, None)] * columns.shape[1] + [(0.0, None)])
    return [float(value) for value in found.x[:-1]], float(found.x[-1])


@dataclass(frozen=True)
class Calibration:
    """Parameters of mapper and simulator that belong to one robot and gait, and how good they are.

    Parameters
    ----------
    mapper, simulator : dict of float
        By the names of `MappingConfiguration` and `SimulatorConfiguration`.
    rigid_speed : float
        Of the reference gait on hard ground [m/s].
    slip_rmse : float [-]
    """

    mapper: dict[str, float]
    simulator: dict[str, float]
    rigid_speed: float
    slip_rmse: float

    def write(self, path: Path) -> None:
        """Write a file that both nodes take with ``--params-file``."""
        sections = {f'/**/{node}': {'ros__parameters': {
            name: round(value, 5) for name, value in values.items()}}
            for node, values in ((MAPPER, self.mapper), (SIMULATOR, self.simulator))}
        head = ('# SPDX-License-Identifier: Apache-2.0\n'
                '# Made by: psane_sim calibrate. For --params-file of both nodes.\n'
                f'# rigid speed: {self.rigid_speed:.4f} m/s, RMSE of slip: {self.slip_rmse:.4f}\n')
        path.write_text(head + yaml.safe_dump(sections, sort_keys=False))


def read_calibration(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the mapper's and the simulator's parameters of a calibration file.

    Raises
    ------
    ParameterError
        When the file has no such sections.
    """
    content = yaml.safe_load(path.read_text())
    try:
        mapper, simulator = (dict(content[f'/**/{node}']['ros__parameters'])
                             for node in (MAPPER, SIMULATOR))
    except (KeyError, TypeError) as error:
        raise ParameterError('calibration', str(path), f'a file with parameters of {MAPPER} and '
                             f'{SIMULATOR}') from error
    return mapper, simulator


def mapper_parameters(curve: CalibratedSlipCurve) -> dict[str, float]:
    """Return a curve by the names of `MappingConfiguration`."""
    return {'slip_curve_residual': curve.residual, 'slip_curve_amplitude': curve.amplitude,
            'slip_curve_half_strength': curve.half_strength, 'slip_curve_exponent': curve.exponent}
