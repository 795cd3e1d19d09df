# SPDX-License-Identifier: Apache-2.0
"""Ways to read a stance, for comparison: all channels, one of them, or the truth itself."""

from collections.abc import Callable
from dataclasses import replace
from enum import Enum

import numpy as np

from psane_mapping.contact import LegContact
from psane_sim.terrains.terrain import Terrain

LEAST_DEVIATION = 0.1
"""Noise that the oracle's forces are said to have [N]."""


class TouchMethod(Enum):
    """What of a stance the map is told."""

    FORCE_AND_TORQUE = 'forces and torque'
    VERTICAL = 'vertical force alone'
    ORACLE = 'the true strength'


def felt_by(method: TouchMethod, terrain: Terrain) -> Callable[[LegContact], LegContact]:
    """Return what turns a stance as sensed into the stance that the map is told.

    The oracle puts the force of ground of the true strength, at the point where the foot felt it,
    in the place of what was measured: what remains is the map's and the planner's own error.
    """
    if method is TouchMethod.VERTICAL:
        return lambda contact: replace(contact, has_velocity=False)
    if method is TouchMethod.ORACLE:
        return lambda contact: _as_it_is(contact, terrain)
    return lambda contact: contact


def _as_it_is(contact: LegContact, terrain: Terrain) -> LegContact:
    strength = float(terrain.strength(contact.point[None, :])[0])
    return replace(contact, measured=strength * contact.response,
                   deviation=np.full(contact.measured.shape, LEAST_DEVIATION))
