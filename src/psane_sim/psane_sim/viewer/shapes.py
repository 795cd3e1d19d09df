# SPDX-License-Identifier: Apache-2.0
"""Shapes of the live view from plain data: lines, arrows, and where a click meets the ground."""

from collections.abc import Iterable

import numpy as np
from shapely.geometry import MultiPolygon, Polygon

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel, elements_in_base

NEWTON = 0.006
"""Length of the arrow of a force of 1 N [m]."""


def rotation_of(quaternion: FloatArray) -> FloatArray:
    """Return the matrix (3, 3) of an attitude x y z w."""
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def leg_turn(angle: float) -> tuple[float, float, float, float]:
    """Return the attitude w x y z of a leg at an angle [rad] in the frame of the base."""
    return (float(np.cos(angle / 2.0)), 0.0, float(np.sin(angle / 2.0)), 0.0)


def lines_through(points: FloatArray, height: float) -> FloatArray:
    """Return the segments (n - 1, 2, 3) of a way through points (n, 2) at a height [m]."""
    raised = np.column_stack((points, np.full(len(points), height)))
    return np.stack((raised[:-1], raised[1:]), axis=1)


def outline(region: Polygon | MultiPolygon | None, height: float) -> FloatArray:
    """Return the segments (n, 2, 3) of all rings of a region at a height [m]."""
    if region is None or region.is_empty:
        return np.empty((0, 2, 3))
    polygons: Iterable[Polygon] = getattr(region, 'geoms', (region,))
    rings = [ring for polygon in polygons for ring in (polygon.exterior, *polygon.interiors)]
    return np.concatenate([lines_through(np.asarray(ring.coords)[:, :2], height)
                           for ring in rings])


def foot_points(model: RobotModel, angles: FloatArray, quaternion: FloatArray) -> FloatArray:
    """Return the lowest point (6, 3) of each leg, base frame [m].

    Parameters
    ----------
    angles : (6,) float
        Of the hips [rad].
    quaternion : (4,) float
        Attitude of the base in the map, x y z w [-]: it says what is down.
    """
    up = rotation_of(quaternion)[2]
    legs = [elements_in_base(model, leg, angle)[0] for leg, angle in enumerate(angles)]
    return np.array([points[np.argmin(points @ up)] for points in legs])


def force_arrows(feet: FloatArray, forces: FloatArray) -> FloatArray:
    """Return arrows (6, 2, 3) that begin at the feet and point where the ground pushes.

    Parameters
    ----------
    feet : (6, 3) float, base frame [m]
    forces : (6, 3) float, base frame [N]
        What each leg does to the body.
    """
    return np.stack((feet, feet + NEWTON * forces), axis=1)


def ground_under(origin: FloatArray, direction: FloatArray) -> FloatArray | None:
    """Return where a ray meets the ground (2,) [m]; None when it points at the sky.

    Parameters
    ----------
    origin, direction : (3,) float, map frame [m], [-]
    """
    if origin[2] <= 0.0 or direction[2] >= -1e-6:
        return None
    return np.asarray((origin - direction * (origin[2] / direction[2]))[:2])
