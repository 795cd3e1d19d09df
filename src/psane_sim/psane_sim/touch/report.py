# SPDX-License-Identifier: Apache-2.0
"""How well the strength of the ground is felt, also where the ground is not as the model says.

Run ``./psane run psane_sim touch_report``. A robot walks over uniform ground of many strengths;
what its sensors would have said is made several times over, with other noise and other biases, so
that a walk is simulated once and felt often.
"""

import argparse
import json
import math
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_mapping.strength import Reason, Rejection, estimate_strength
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.robot.truth import Truth
from psane_sim.soils.element_soil import ElementSoil
from psane_sim.soils.family import granular_law
from psane_sim.terrains.terrain import Terrain
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.contact_sensing import ContactSensor
from psane_sim.touch.sensing import Sensors

STRENGTHS = (0.05, 0.09, 0.16, 0.29, 0.52, 0.94, 1.7, 3.0)
STRAIGHT = (0.2925, 0.0)
OTHER_GAITS = ((0.15, 0.0), (0.2, 0.15), (-0.15, 0.0))
"""Twists other than the one that slip is calibrated with [m/s], [rad/s]."""

SOILS: dict[str, dict[str, float]] = {
    'as modelled': {},
    'delta halved': {'displacement': 0.00075},
    'delta doubled': {'displacement': 0.003},
    'tilted 20 %': {'horizontal': 1.2},
    'tilted -20 %': {'horizontal': 0.8},
    'depth exponent 1.2': {'depth_exponent': 1.2},
}
"""What is different from the granular soil that the estimate believes in."""

NORMAL_90 = 1.645
"""Half width of a normal distribution's central 90 %, in standard deviations."""


def walk(strength: float, twist: tuple[float, float], seconds: float,
         **law: float) -> list[Truth]:
    """Return the truth of a walk over uniform granular ground at 200 Hz.

    Parameters
    ----------
    strength : float [-]
    twist : (linear, angular) [m/s], [rad/s]
    seconds : float
    law : float
        Departures from the granular law (see `granular_law`).
    """
    config, terrain = SimulatorConfiguration(), Terrain.uniform(strength)
    field = terrain.strength_field
    soil = ElementSoil(RobotModel(), field, granular_law(field, **law))
    truths = []
    with HexapodSimulator(config, terrain, (5.0, 5.0, 0.3), soil=soil) as simulator:
        simulator.command(*twist)
        for _ in range(round(200 * seconds)):
            simulator.step(5)
            truths.append(simulator.truth())
    return truths


def feel(truths: Sequence[Truth], seed: int, height_bias: float, *, learn_height: bool = True,
         with_odometry: bool = True) -> list[LegContact]:
    """Return the contacts of a walk as felt with one draw of noise and biases.

    Parameters
    ----------
    height_bias : float
        Deviation of the constant error of the height [m].
    with_odometry : bool
        Without it the body's velocity is unknown to the estimate.
    """
    sensors = Sensors(SimulatorConfiguration(height_bias=height_bias), seed)
    touch = ContactSensor(TouchConfiguration(learn_height=learn_height), RobotModel())
    contacts: list[LegContact] = []
    for tick, truth in enumerate(truths):
        if tick % 4 == 0:
            touch.set_odometry(sensors.odometry(truth))
        contacts += touch.update(sensors.joints(truth), sensors.wrenches(truth),
                                 sensors.imu(truth))
    if not with_odometry:
        contacts = [replace(contact, has_velocity=False) for contact in contacts]
    return contacts


@dataclass(frozen=True)
class Errors:
    """Errors of log-strength over many stances.

    Parameters
    ----------
    error, claimed : (n,) float [-]
        Of the natural logarithm, and the standard deviation that was claimed for it.
    rejected : Counter of Reason
        Stances that were not used.
    """

    error: FloatArray
    claimed: FloatArray
    rejected: Counter[Reason]

    @property
    def rmse(self) -> float:
        """Root mean square of the error of log-strength."""
        return float(np.sqrt(np.mean(self.error**2)))

    @property
    def median(self) -> float:
        """Median of the relative error of strength."""
        return float(np.median(np.abs(np.expm1(self.error))))

    @property
    def coverage(self) -> float:
        """Share of the truths within the claimed 90 % intervals."""
        return float(np.mean(np.abs(self.error) <= NORMAL_90 * self.claimed))

    @property
    def missing_deviation(self) -> float:
        """Deviation of log-strength that, added to the claimed one, would make 90 % hold."""
        needed = (self.error / NORMAL_90) ** 2 - self.claimed**2
        return math.sqrt(max(0.0, float(np.quantile(needed, 0.9))))

    @property
    def rejected_share(self) -> float:
        """Share of stances that were not used."""
        count = self.rejected.total()
        return count / max(1, count + len(self.error))


def errors_of(felt: Sequence[tuple[float, LegContact]], config: MappingConfiguration) -> Errors:
    """Estimate each contact's strength and compare it with the true one."""
    found, rejected = [], Counter[Reason]()
    for strength, contact in felt:
        estimate = estimate_strength(contact, config)
        if isinstance(estimate, Rejection):
            rejected[estimate.reason] += 1
        else:
            found.append((math.log(estimate.strength / strength), estimate.log_deviation))
    table = np.array(found).reshape(-1, 2)
    return Errors(table[:, 0], table[:, 1], rejected)


@dataclass(frozen=True)
class Effort:
    """How much is walked: seconds of each walk, draws of noise, strengths."""

    seconds: float = 8.0
    draws: int = 4
    strengths: tuple[float, ...] = STRENGTHS


def _felt(effort: Effort, twists: Sequence[tuple[float, float]], height_bias: float,
          law: dict[str, float], *, learn_height: bool = True,
          with_odometry: bool = True) -> list[tuple[float, LegContact]]:
    return [(strength, contact) for strength in effort.strengths for twist in twists
            for truths in [_walked(strength, twist, effort.seconds, law)]
            for seed in range(effort.draws)
            for contact in feel(truths, seed, height_bias, learn_height=learn_height,
                                with_odometry=with_odometry)]


_WALKS: dict[tuple[object, ...], list[Truth]] = {}


def _walked(strength: float, twist: tuple[float, float], seconds: float,
            law: dict[str, float]) -> list[Truth]:
    """Return a walk, from memory where it has been simulated before."""
    key = (strength, twist, seconds, *sorted(law.items()))
    if key not in _WALKS:
        _WALKS[key] = walk(strength, twist, seconds, **law)
    return _WALKS[key]


def measure(effort: Effort | None = None) -> dict[str, Errors]:
    """Return the errors of each method, bias, gait and soil, by name."""
    effort = effort or Effort()
    config = MappingConfiguration()
    linear = replace(config, strength_method='linear_stiffness', least_r_squared=0.0)
    matched = _felt(effort, [STRAIGHT], 0.005, {})
    report = {'5 mm': errors_of(matched, config), '5 mm, F = k z': errors_of(matched, linear)}
    _say('felt the reference walk')
    for bias in (0.002, 0.010):
        report[f'{1e3 * bias:.0f} mm'] = errors_of(_felt(effort, [STRAIGHT], bias, {}), config)
    for bias in (0.002, 0.005, 0.010):
        report[f'{1e3 * bias:.0f} mm, height not learnt'] = errors_of(
            _felt(effort, [STRAIGHT], bias, {}, learn_height=False), config)
    report['5 mm, F_z alone'] = errors_of(
        _felt(effort, [STRAIGHT], 0.005, {}, with_odometry=False), config)
    _say('felt it with other biases')
    report['5 mm, other gaits'] = errors_of(_felt(effort, OTHER_GAITS, 0.005, {}), config)
    for name, law in SOILS.items():
        if law:
            report[f'5 mm, {name}'] = errors_of(_felt(effort, [STRAIGHT], 0.005, law), config)
            _say(f'felt ground with {name}')
    return report


def figures(report: dict[str, Errors]) -> dict[str, float]:
    """Return the report as named numbers."""
    named: dict[str, float] = {}
    for name, errors in report.items():
        key = 'touch_' + '_'.join(name.replace('%', 'percent').replace('=', '').replace(
            '-', 'minus_').replace('.', 'p').replace(',', '').lower().split())
        named |= {f'{key}_log_rmse': errors.rmse, f'{key}_median_error': errors.median,
                  f'{key}_coverage_90': errors.coverage,
                  f'{key}_missing_deviation': errors.missing_deviation,
                  f'{key}_rejected_share': errors.rejected_share}
    return named


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure how well strength is felt, and print it."""
    parser = argparse.ArgumentParser(prog='touch_report', description=main.__doc__)
    parser.add_argument('--json', action='store_true', help='one JSON object of named numbers')
    parser.add_argument('--draws', type=int, default=4, help='draws of noise for each walk')
    parser.add_argument('--seconds', type=float, default=8.0, help='length of each walk [s]')
    options = parser.parse_args(arguments)
    report = measure(Effort(seconds=options.seconds, draws=options.draws))
    if options.json:
        print(json.dumps(figures(report), indent=2))
        return
    print('add: deviation of log-strength that is missing for 90 % of the truths to lie within')
    print(f'{"":28s} log-RMSE  median  90 % holds  add  rejected  (stances)')
    for name, errors in report.items():
        print(f'{name:28s} {errors.rmse:8.3f} {errors.median:7.1%} {errors.coverage:11.1%} '
              f'{errors.missing_deviation:5.2f}'
              f'{errors.rejected_share:9.1%}  {len(errors.error)}')
