# SPDX-License-Identifier: Apache-2.0
"""Strength of the ground from one stance, by regression of what was felt on what was predicted.

Notes
-----
The stress of granular ground is proportional to its strength (resistive force theory: Li, Zhang,
Goldman 2013), so that the slope of the measured force on the force predicted for strength 1 is the
strength. Four errors are told apart in the result's deviation:

- *scatter*: the residuals' own, for the number of samples that are really independent (samples
  a few milliseconds apart are not);
- *height*: if the foot is `b` deeper than believed, the force at depth `d` is larger by about
  ``exponent * b / d``, and every sample of a stance shares `b`. This dominates shallow stances;
- *disagreement*: the forward and the vertical force each tell a strength of their own. Where
  they contradict each other by more than their scatter, the ground is not as the force law says,
  and a share of the contradiction is how far off the result may be;
- *model*: what remains in deep, quiet stances (attitude, gains, shape of the force law), and what
  no stance can show of the ground (stress that does not grow in proportion to depth).
"""

import enum
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.grid import FloatArray
from psane_mapping.robust_slope import disagreement, regress


class Reason(enum.Enum):
    """Why a stance tells nothing about the ground."""

    TOO_FEW_SAMPLES = 'too few samples below the surface'
    TOO_SHALLOW = 'not deep enough'
    NO_RESPONSE = 'the motion would not load the ground'
    NOT_POSITIVE = 'the force does not rise with the predicted one'
    POOR_FIT = 'the force does not follow the predicted one'
    IMPLAUSIBLE = 'stronger or weaker than any ground'
    OUTSIDE_MAP = 'felt outside the map'
    DUPLICATE = 'came before'


@dataclass(frozen=True, kw_only=True)
class StrengthEstimate:
    """Strength of the ground under one stance.

    Parameters
    ----------
    strength : float
        Penetration resistance relative to ground of strength 1 [-].
    log_deviation : float
        Standard deviation of its natural logarithm [-].
    r_squared : float
        Share of the weighted square of the measurement that the regression explains [-].
    scatter_deviation, height_deviation, disagreement_deviation : float
        The parts of `log_deviation` from residuals, from the height's bias and from forces that
        contradict each other [-].
    samples : int
        Samples that were used [count].
    """

    strength: float
    log_deviation: float
    r_squared: float
    scatter_deviation: float
    height_deviation: float
    samples: int
    disagreement_deviation: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Rejection:
    """A stance that was not used, and why; `value` is what failed the test."""

    reason: Reason
    value: float


class _Beliefs(NamedTuple):
    """What the residuals cannot show of the error: see the module's notes."""

    depth_exponent: float
    model_deviation: float
    height_bias_deviation: float


def estimate_strength(contact: LegContact, config: MappingConfiguration
                      ) -> StrengthEstimate | Rejection:
    """Return the strength of the ground that a stance felt, or why there is none."""
    below = contact.depth > 0.0
    count = int(below.sum())
    if count < config.least_samples:
        return Rejection(reason=Reason.TOO_FEW_SAMPLES, value=float(count))
    deepest = float(contact.depth.max())
    if deepest < config.least_depth:
        return Rejection(reason=Reason.TOO_SHALLOW, value=deepest)
    if config.strength_method == 'linear_stiffness':
        predictor, measured, deviation = _stiffness_channel(contact, below, config)
        exponent, model = 1.0, config.fit_model_deviation
    else:
        predictor, measured, deviation = _force_channels(contact, below)
        exponent, model = config.depth_exponent, config.model_deviation
    predictor, measured = predictor / deviation, measured / deviation
    predicted = float(np.abs(predictor).max())
    if predicted < config.least_response:
        return Rejection(reason=Reason.NO_RESPONSE, value=predicted)
    beliefs = _Beliefs(exponent, model, config.height_bias_deviation)
    return _regress(predictor, measured, contact.depth[below], beliefs, config)


def _force_channels(contact: LegContact, below: NDArray[np.bool_]
                    ) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return prediction, measurement and noise (channels, n) [N] of the channels to trust."""
    channels = slice(0, 3) if contact.has_velocity else slice(1, 2)
    return (_rows(contact.response[below, channels]), _rows(contact.measured[below, channels]),
            np.maximum(_rows(contact.deviation[below, channels]), 1e-6))


def _stiffness_channel(contact: LegContact, below: NDArray[np.bool_],
                       config: MappingConfiguration
                       ) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the paper's linear fit: ``F_z = k z``, strength = k / (stiffness at strength 1).

    That stiffness is not the same at every depth, so that one constant fits only on average: over
    strengths 0.05 to 3 of the simulated hexapod the log-strength is off by 0.5 RMSE (the
    regression on the predicted force: 0.05), and most stances fail the fit's R^2.
    """
    predictor = config.fit_stiffness * contact.depth[None, below]
    return (predictor, _rows(contact.measured[below, 1:2]),
            np.maximum(_rows(contact.deviation[below, 1:2]), 1e-6))


def _rows(samples: FloatArray) -> FloatArray:
    """Return samples (n, channels) with one row a channel, as the regression wants them."""
    return np.ascontiguousarray(samples.T)


def _regress(predictor: FloatArray, measured: FloatArray, depth: FloatArray, beliefs: _Beliefs,
             config: MappingConfiguration) -> StrengthEstimate | Rejection:
    """Return the strength that samples (channels, n), scaled by their noise, tell of."""
    slope, r_squared, scatter, inverse_depth = regress(
        predictor, measured, np.maximum(depth, config.least_depth))
    if slope <= 0.0:
        return Rejection(reason=Reason.NOT_POSITIVE, value=slope)
    # Written so that a fit which is not a number fails too.
    if not r_squared >= config.least_r_squared:
        return Rejection(reason=Reason.POOR_FIT, value=r_squared)
    if not 1.0 / config.most_strength <= slope <= config.most_strength:
        return Rejection(reason=Reason.IMPLAUSIBLE, value=slope)
    height = beliefs.depth_exponent * inverse_depth * beliefs.height_bias_deviation
    contradiction = disagreement(predictor, measured) if len(predictor) > 1 else 0.0
    contradiction *= config.disagreement_share
    variance = scatter**2 + height**2 + contradiction**2 + beliefs.model_deviation**2
    return StrengthEstimate(strength=slope, log_deviation=math.sqrt(variance),
                            r_squared=r_squared, scatter_deviation=scatter,
                            height_deviation=height, samples=depth.size,
                            disagreement_deviation=contradiction)
