# SPDX-License-Identifier: Apache-2.0
"""The soils that there are, by name, each with its strength as a function of place.

Strength 1 is ground whose penetration resistance is 1 N/cm^3 (a horizontal plate feels 1 MPa for
each metre of depth); every soil but the rigid one weakens with the strength field.
"""

import math
from collections.abc import Callable

import numpy as np

from psane_mapping.grid import FloatArray
from psane_mapping.rft import NEWTON_PER_CUBIC_METRE
from psane_mapping.slip import CalibratedSlipCurve
from psane_sim.soils.element_soil import SoilLaw
from psane_sim.soils.laws import COLUMN, CONTACT, GRANULAR
from psane_sim.soils.strength_field import StrengthField

PUBLISHED_PATCH = 0.57
"""Width b of the loaded patch in k_c / b of the published run, whose k_c is below 0: the body's
length, since any much shorter one leaves no resistance at all [m]."""

PASSIVE_SHARE = 0.37
"""Pressure on an upright plate as a share of that on a level one, as resistive force theory has it
at strength 1 [-]."""

RIGID_STIFFNESS = 5.0e7
"""Of ground that is called rigid: a leg goes about a millimetre deep [Pa/m]."""


def granular_law(field: StrengthField, *, displacement: float = 0.0015, damping: float = 0.002,
                 depth_exponent: float = 1.0, horizontal: float = 1.0) -> SoilLaw:
    """Return resistive force theory (Li et al. 2013) with an elastic-plastic memory.

    Parameters
    ----------
    field : StrengthField
    displacement, damping : float
        At which the ground yields fully, delta [m], and time constant tau_d [s].
    depth_exponent, horizontal : float
        Power of depth with which stress grows, and share of the theory's horizontal stress: for
        ground that is not as the theory says [-].
    """
    settings = np.array([displacement, damping, depth_exponent - 1.0, horizontal])
    return SoilLaw(GRANULAR, settings, field.log_strength)


def _column_law(log_modulus: FloatArray, *, cohesion: float, friction_angle: float,
                shear_length: float, stiffening: float = 8.0, viscosity: float = 0.0125,
                exponent: float = 1.0) -> SoilLaw:
    settings = np.array([cohesion, math.tan(friction_angle), shear_length, stiffening, viscosity,
                         exponent, PASSIVE_SHARE])
    return SoilLaw(COLUMN, settings, log_modulus)


def scm_published_law(field: StrengthField) -> SoilLaw:
    """Return the soil contact model with the parameters of the published run.

    Notes
    -----
    n = 1, k_c = -100e3, cohesion 1.6e3 Pa, friction 31.1 deg, Janosi 0.012 m, elastic stiffness
    8 k_phi, damping 5e4; k_phi = 4e6 - 6e6 r for a risk r <= .5 and
    0.2e6 + 0.8e6 exp(-12 (r - .5) / .5) above. The risk is the calibrated slip of the strength.
    The damping is 5e4 Pa s/m at r = 0 and in proportion to the modulus elsewhere: a constant one
    would carry the robot on the weakest ground. The width b was not published. Where k_c / b eats
    up k_phi, a twentieth of k_phi remains.
    """
    risk = CalibratedSlipCurve().slip(np.exp(field.log_strength))
    frictional = np.where(risk <= 0.5, 4.0e6 - 6.0e6 * risk,
                          0.2e6 + 0.8e6 * np.exp(-12.0 * (risk - 0.5) / 0.5))
    modulus = np.maximum(frictional - 100.0e3 / PUBLISHED_PATCH, 0.05 * frictional)
    return _column_law(np.log(modulus), cohesion=1.6e3, friction_angle=math.radians(31.1),
                       shear_length=0.012)


def scm_highlands_law(field: StrengthField) -> SoilLaw:
    """Return the soil contact model of a lunar highlands simulant (LHS-1) at strength 1.

    Notes
    -----
    Pressure and sinkage as the Lunar Sourcebook has them for regolith (Carrier, Olhoeft, Mendell
    1991: k_c = 1.4e3 N/m^2, k_phi = 820e3 N/m^3, n = 1, Janosi 0.018 m), shear strength from the
    simulant's data sheet (cohesion 311 Pa, friction 31.5 deg). The leg's width is b.
    """
    modulus = 820.0e3 + 1.4e3 / 0.03
    return _column_law(field.log_strength + math.log(modulus), cohesion=311.0,
                       friction_angle=math.radians(31.5), shear_length=0.018)


def penetration_law(field: StrengthField) -> SoilLaw:
    """Return penetration resistance F = k z with Coulomb's friction as its shear."""
    return _column_law(field.log_strength + math.log(NEWTON_PER_CUBIC_METRE), cohesion=0.0,
                       friction_angle=math.radians(30.0), shear_length=0.005)


def soft_contact_law(field: StrengthField) -> SoilLaw:
    """Return springs and dampers with dry friction, as a rigid-body engine's soft contacts."""
    return SoilLaw(CONTACT, np.array([0.7, 0.6]),
                   field.log_strength + math.log(NEWTON_PER_CUBIC_METRE))


def rigid_law(field: StrengthField) -> SoilLaw:
    """Return hard ground with dry friction, the same at every strength."""
    return SoilLaw(CONTACT, np.array([0.8, 0.6]),
                   np.full(field.log_strength.shape, math.log(RIGID_STIFFNESS)))


SOILS: dict[str, Callable[[StrengthField], SoilLaw]] = {
    'granular': granular_law,
    'scm_published': scm_published_law,
    'scm_highlands': scm_highlands_law,
    'penetration': penetration_law,
    'soft_contact': soft_contact_law,
    'rigid': rigid_law,
}
"""Law of each soil, by name."""
