# SPDX-License-Identifier: Apache-2.0
"""From an uncertain strength to an uncertain slip."""

import math
from typing import NamedTuple

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.grid import FloatArray
from psane_mapping.slip import CalibratedSlipCurve, RotaryWalking, SlipModel
from psane_mapping.strength import StrengthEstimate

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(15)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()


class SlipEstimate(NamedTuple):
    """Slip ratio [-] and the standard deviation of its error [-]."""

    slip: float
    deviation: float


def slip_model_of(config: MappingConfiguration) -> SlipModel:
    """Return the slip model that a configuration asks for."""
    if config.slip_model == 'calibrated':
        return CalibratedSlipCurve(
            residual=config.slip_curve_residual, amplitude=config.slip_curve_amplitude,
            half_strength=config.slip_curve_half_strength, exponent=config.slip_curve_exponent)
    return RotaryWalking(unit_stiffness=config.unit_stiffness,
                         clipped=config.slip_model == 'rotary_walking')


def propagate(estimate: StrengthEstimate, model: SlipModel,
              config: MappingConfiguration) -> SlipEstimate:
    """Return the slip of an estimated strength, with an honest deviation.

    Notes
    -----
    Three parts add up in the variance:

    - the mean square of the change of slip when log-strength errs, by Gauss-Hermite quadrature
      over its normal distribution. For small errors this is the delta method;
      near a bend of the curve it sees what lies beyond;
    - the chance that the strength lies where the curve has saturated, times
      `saturation_deviation` squared. There the slope is 0, and slip 1 would come out certain,
      although all that was felt is that it is about 1 or more;
    - `slip_noise_floor` squared.
    """
    strengths = estimate.strength * np.exp(estimate.log_deviation * _NODES)
    slips = _bounded(model.slip(np.append(strengths, estimate.strength)))
    slip = slips[-1]
    curve = float((_WEIGHTS * (slips[:-1] - slip)**2).sum())
    saturated = _chance_below(model.saturation_strength, estimate)
    variance = (curve + saturated * config.saturation_deviation**2
                + config.slip_noise_floor**2)
    return SlipEstimate(float(slip), math.sqrt(variance))


def _bounded(slip: FloatArray) -> FloatArray:
    return np.clip(slip, 0.0, 1.0)


def _chance_below(strength: float, estimate: StrengthEstimate) -> float:
    if strength <= 0.0:
        return 0.0
    distance = math.log(strength / estimate.strength)
    if estimate.log_deviation <= 0.0:
        return 1.0 if distance >= 0.0 else 0.0
    return 0.5 * math.erfc(-distance / (estimate.log_deviation * math.sqrt(2.0)))
