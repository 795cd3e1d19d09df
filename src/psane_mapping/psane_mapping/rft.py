# SPDX-License-Identifier: Apache-2.0
"""Granular resistive force theory: stress on a small plate that moves through dry granular ground.

Everything here is in a vertical plane: x forward, z up. The same functions serve the simulator's
soil and the regression that turns felt forces into strength.

Notes
-----
Li, Zhang and Goldman, "A terradynamics of legged locomotion on granular media", Science 2013; the
generic coefficients of its supplement, for strength 1.
"""

import math

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray

A00, A10, B11, B01, B_11 = 0.206, 0.169, 0.212, 0.358, 0.055
C11, C01, C_11, D10 = -0.124, 0.253, 0.007, 0.088

NEWTON_PER_CUBIC_METRE = 1.0e6
"""One N/cm^3 (a stress of 1 N/cm^2 for each cm of depth) in N/m^3."""

LATERAL_FACE, LATERAL_EDGE = 0.136, 0.37
"""Sideways stress of a plate that slides along its face, and of its two edges [N/cm^3]."""


@njit(cache=True, inline='always', error_model='numpy')
def _stress_of_angles(cos_2b: float, sin_2b: float, cos_g: float,
                      sin_g: float) -> tuple[float, float]:
    """Return alpha_x and alpha_z [N/cm^3] from sines and cosines (no trigonometry needed)."""
    cos_plus = cos_2b * cos_g - sin_2b * sin_g
    sin_plus = sin_2b * cos_g + cos_2b * sin_g
    cos_minus = cos_2b * cos_g + sin_2b * sin_g
    sin_minus = cos_2b * sin_g - sin_2b * cos_g
    alpha_z = A00 + A10 * cos_2b + B11 * sin_plus + B01 * sin_g + B_11 * sin_minus
    alpha_x = C11 * cos_plus + C01 * cos_g + C_11 * cos_minus + D10 * sin_2b
    return alpha_x, alpha_z


@njit(cache=True)
def stress(tilt: float, direction: float) -> tuple[float, float]:
    """Return alpha_x and alpha_z for a plate at one tilt, moving in one direction.

    Parameters
    ----------
    tilt : float
        Angle of the plate to the horizontal, beta [rad].
    direction : float
        Angle of the motion below the horizontal, gamma [rad].

    Returns
    -------
    (alpha_x, alpha_z) for strength 1 [N/cm^3].

    Notes
    -----
    Li et al. 2013, supplement, eq. (S4): alpha_z = sum A_mn cos(2 m beta + n gamma)
    + B_mn sin(2 m beta + n gamma), m = -1..1, n = 0..1; alpha_x likewise with C and D.
    """
    return _stress_of_angles(math.cos(2.0 * tilt), math.sin(2.0 * tilt), math.cos(direction),
                             math.sin(direction))


@njit(cache=True, inline='always', error_model='numpy')
def plate_stress(motion_x: float, motion_z: float, normal_x: float,
                 normal_z: float) -> tuple[float, float]:
    """Return the ground's stress on a plate per unit depth and strength, with its sign.

    Parameters
    ----------
    motion_x, motion_z : float
        Direction of motion (any length above 0) in the vertical plane [m] or [m/s].
    normal_x, normal_z : float
        Either of the plate's two normals (any length above 0) [-].

    Returns
    -------
    (x, z) : stress on the plate per metre of depth at strength 1 [N/m^3].

    Notes
    -----
    With the normal that points down (n_z <= 0) and s = sign(v_x): gamma = atan2(-v_z, s v_x),
    beta = atan2(s n_x, -n_z), stress = (-s alpha_x, alpha_z). It is continuous through v_x = 0.
    """
    if normal_z > 0.0:
        normal_x, normal_z = -normal_x, -normal_z
    sign = 1.0 if motion_x >= 0.0 else -1.0
    squared = normal_x * normal_x + normal_z * normal_z
    if squared == 0.0:
        return 0.0, 0.0
    cos_2b = (normal_z * normal_z - normal_x * normal_x) / squared
    sin_2b = -2.0 * sign * normal_x * normal_z / squared
    length = math.sqrt(motion_x * motion_x + motion_z * motion_z)
    if length == 0.0:
        return 0.0, 0.0
    alpha_x, alpha_z = _stress_of_angles(cos_2b, sin_2b, sign * motion_x / length,
                                         -motion_z / length)
    return (-sign * alpha_x * NEWTON_PER_CUBIC_METRE, alpha_z * NEWTON_PER_CUBIC_METRE)


@njit(cache=True, inline='always', error_model='numpy')
def mobilised_force(x: float, y: float, z: float, share: float, normal_x: float, normal_z: float,
                    area: float, side: float, load: float) -> tuple[float, float, float]:
    """Return the ground's force on one element.

    Parameters
    ----------
    x, y, z : float
        Direction of motion, heading frame (x forward, y left, z up); any length.
    share : float
        Share of the full force per unit of (x, y, z): 1 / length when the ground flows, less
        when it has hardly been displaced yet.
    normal_x, normal_z : float
        Normal in the vertical plane [-].
    area, side : float
        Area of the element [m^2] and the equivalent area against sideways motion [m^2].
    load : float
        Strength times depth [m].

    Returns
    -------
    (x, y, z) : force [N], heading frame.
    """
    in_plane = math.sqrt(x * x + z * z) * share * load * area
    stress_x, stress_z = plate_stress(x, z, normal_x, normal_z)
    force_y = -y * share * load * side * NEWTON_PER_CUBIC_METRE
    return stress_x * in_plane, force_y, stress_z * in_plane


@njit(cache=True, inline='always', error_model='numpy')
def displaced(memory: FloatArray, velocity_x: float, velocity_y: float, velocity_z: float,
              dt: float, limit: float, damping: float) -> tuple[float, float, float, float]:
    """Move an element's displacement on by one step and return what the ground feels of it.

    Parameters
    ----------
    memory : (3,) float
        Displacement u of the ground at the element, heading frame [m]; it is changed.
    velocity_x, velocity_y, velocity_z : float
        Of the element, heading frame [m/s].
    dt : float [s]
    limit : float
        Displacement at which the ground yields fully, delta [m].
    damping : float
        Time constant tau_d [s].

    Returns
    -------
    (x, y, z, share) : what `mobilised_force` takes [m], [1/m].

    Notes
    -----
    u <- u + v dt, clipped to |u| <= delta; e = u + tau_d v; share = 1 / max(|e|, delta). Resistive
    force theory itself says nothing at rest; without a memory a standing robot creeps.
    """
    x = memory[0] + velocity_x * dt
    y = memory[1] + velocity_y * dt
    z = memory[2] + velocity_z * dt
    length = math.sqrt(x * x + y * y + z * z)
    if length > limit:
        x, y, z = x * limit / length, y * limit / length, z * limit / length
    memory[0], memory[1], memory[2] = x, y, z
    x, y, z = x + damping * velocity_x, y + damping * velocity_y, z + damping * velocity_z
    return x, y, z, 1.0 / max(limit, math.sqrt(x * x + y * y + z * z))


@njit(cache=True)
def flowing_forces(velocity: FloatArray, normal: FloatArray, area: FloatArray, side: FloatArray,
                   depth: FloatArray, strength: FloatArray) -> FloatArray:
    """Return the force on each element of a body that moves through flowing ground.

    Parameters
    ----------
    velocity, normal : (n, 3) float, heading frame [m/s], [-]
    area, side : (n,) float [m^2]
        See `side_area`.
    depth : (n,) float [m]
        Below the surface; elements above it (depth <= 0) feel nothing.
    strength : (n,) float [-]

    Returns
    -------
    (n, 3) float, heading frame [N].

    Notes
    -----
    No memory: at rest the force is 0. The in-plane force is scaled by the in-plane share of the
    motion and the sideways force by |v_y| / |v|, so that the whole is continuous.
    """
    force = np.zeros_like(velocity)
    for i in range(velocity.shape[0]):
        vx, vy, vz = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        speed = math.sqrt(vx * vx + vy * vy + vz * vz)
        if depth[i] > 0.0 and speed > 0.0:
            fx, fy, fz = mobilised_force(vx, vy, vz, 1.0 / speed, normal[i, 0], normal[i, 2],
                                         area[i], side[i], strength[i] * depth[i])
            force[i, 0], force[i, 1], force[i, 2] = fx, fy, fz
    return force


def side_area(area: FloatArray, thickness: float, arc_length: FloatArray) -> FloatArray:
    """Return the area that resists sideways motion at 1 N/cm^3 of stress [m^2].

    Parameters
    ----------
    area, arc_length : (n,) float [m^2], [m]
        Face of each element and its length along the leg.
    thickness : float
        Of the leg [m].
    """
    return LATERAL_FACE * area + LATERAL_EDGE * 2.0 * thickness * arc_length
