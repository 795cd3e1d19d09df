# SPDX-License-Identifier: Apache-2.0
"""Laws of soils for one small plate: how it is pushed when it lies and moves in the ground.

Every law works in a frame whose z axis is the surface's normal and whose x axis points along the
robot's heading, and keeps what it must remember in a row of `MEMORY` numbers that is cleared when
the plate leaves the ground.
"""

import math

from numba import njit

from psane_mapping.grid import FloatArray
from psane_mapping.rft import displaced, mobilised_force

GRANULAR, COLUMN, CONTACT = 0, 1, 2
"""Which law: resistive force theory, sinkage under pressure with shear, spring and damper."""

MEMORY = 6
"""Numbers that a plate remembers."""

_OLD_LIMIT, _OLD_AREA, _PLASTIC = 3, 4, 5

# Settings of the granular law.
DISPLACEMENT, DAMPING, EXCESS_EXPONENT, HORIZONTAL = 0, 1, 2, 3
REFERENCE_DEPTH = 0.05
"""Depth at which ground whose stress does not grow linearly is as strong as ground where it does
[m]."""

# Settings of the column law.
COHESION, FRICTION, SHEAR_LENGTH, STIFFENING, VISCOSITY, EXPONENT, PASSIVE = 0, 1, 2, 3, 4, 5, 6

SHEAR_DAMPING = 0.004
"""Time constant of small shear displacements: without it a standing robot would tremble [s]."""

# Settings of the contact law.
CONTACT_FRICTION, CONTACT_DAMPING = 0, 1


@njit(cache=True, inline='always', error_model='numpy')
def granular(memory: FloatArray, settings: FloatArray, strength: float, depth: float, vx: float,
             vy: float, vz: float, nx: float, nz: float, area: float, side: float,
             dt: float) -> tuple[float, float, float]:
    """Return the force [N] of resistive force theory with an elastic-plastic memory.

    Notes
    -----
    Li, Zhang and Goldman 2013; the memory is that of `rft.displaced`.
    """
    ex, ey, ez, share = displaced(memory, vx, vy, vz, dt, settings[DISPLACEMENT],
                                  settings[DAMPING])
    load = strength * depth
    if settings[EXCESS_EXPONENT] != 0.0:
        load *= (depth / REFERENCE_DEPTH) ** settings[EXCESS_EXPONENT]
    fx, fy, fz = mobilised_force(ex, ey, ez, share, nx, nz, area, side, load)
    return settings[HORIZONTAL] * fx, fy, fz


@njit(cache=True, inline='always', error_model='numpy')
def column(memory: FloatArray, settings: FloatArray, modulus: float, depth: float, vx: float,
           vy: float, vz: float, nz: float, area: float,
           dt: float) -> tuple[float, float, float]:
    """Return the force [N] of a column of soil: pressure by sinkage, shear by displacement.

    Parameters
    ----------
    modulus : float
        (k_c / b + k_phi) of Bekker's law [Pa/m^n].

    Notes
    -----
    Pressure p = modulus z^n, unloaded along a steeper straight line (Bekker 1969, Wong); shear
    (c + p tan phi)(1 - exp(-j / K)) (Janosi and Hanamoto 1961), with c + p tan phi as Mohr and
    Coulomb have it. The shear displacement j is a vector that is cut off at 3 K and shrinks when
    the limit grows, so that no cycle gains energy; for the same reason a plate that turns its face
    to the load keeps its force, not its strain. An upright plate that is pushed sideways meets a
    share of the pressure that a level one would, which takes part in the shear.
    """
    flat = area * abs(nz)
    upright = area * math.sqrt(max(0.0, 1.0 - nz * nz))
    strain = depth - memory[_PLASTIC]
    if memory[_OLD_AREA] > 0.0 and flat > memory[_OLD_AREA]:
        strain *= memory[_OLD_AREA] / flat
    memory[_OLD_AREA] = flat
    elastic = settings[STIFFENING] * modulus
    limit = modulus * depth ** settings[EXPONENT]
    strain = min(strain, limit / elastic)
    memory[_PLASTIC] = depth - strain
    pressure = max(0.0, elastic * strain)
    push = 0.0
    if pressure > 0.0:
        push = flat * (pressure + settings[VISCOSITY] * modulus * max(0.0, -vz))
    bearing = upright * settings[PASSIVE] * limit
    if pressure > 0.0:
        bearing += flat * (settings[COHESION] + settings[FRICTION] * pressure)
    if memory[_OLD_LIMIT] > 0.0 and bearing > memory[_OLD_LIMIT]:
        memory[0] *= memory[_OLD_LIMIT] / bearing
        memory[1] *= memory[_OLD_LIMIT] / bearing
    memory[_OLD_LIMIT] = bearing
    length = settings[SHEAR_LENGTH]
    jx, jy = memory[0] + vx * dt, memory[1] + vy * dt
    moved = math.sqrt(jx * jx + jy * jy)
    if moved > 3.0 * length:
        jx, jy = jx * 3.0 * length / moved, jy * 3.0 * length / moved
    memory[0], memory[1] = jx, jy
    ex, ey = jx + SHEAR_DAMPING * vx, jy + SHEAR_DAMPING * vy
    moved = math.sqrt(ex * ex + ey * ey)
    shear = bearing * (1.0 - math.exp(-moved / length)) / max(moved, 1.0e-12)
    return -shear * ex, -shear * ey, push


@njit(cache=True, inline='always', error_model='numpy')
def contact(memory: FloatArray, settings: FloatArray, stiffness: float, depth: float, vx: float,
            vy: float, vz: float, area: float, dt: float) -> tuple[float, float, float]:
    """Return the force [N] of a spring and damper with dry friction.

    Parameters
    ----------
    stiffness : float
        Pressure for each metre of depth [Pa/m].

    Notes
    -----
    As pybullet's own soft contacts have it (contactStiffness, contactDamping), with a tangential
    spring of the same stiffness that slides at the friction's limit. The area does not change as
    the plate turns: else the spring would not be conservative.
    """
    spring = stiffness * area
    damping = settings[CONTACT_DAMPING] * math.sqrt(spring)
    normal = max(0.0, spring * depth - damping * vz)
    sx, sy = memory[0] + vx * dt, memory[1] + vy * dt
    limit = settings[CONTACT_FRICTION] * normal
    stretched = spring * math.sqrt(sx * sx + sy * sy)
    if stretched > limit:
        sx, sy = sx * limit / stretched, sy * limit / stretched
    memory[0], memory[1] = sx, sy
    tx, ty = spring * sx + damping * vx, spring * sy + damping * vy
    size = math.sqrt(tx * tx + ty * ty)
    if size > limit:
        tx, ty = tx * limit / size, ty * limit / size
    return -tx, -ty, normal
