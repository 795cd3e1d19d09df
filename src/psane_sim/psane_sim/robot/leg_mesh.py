# SPDX-License-Identifier: Apache-2.0
"""A half-circle leg as triangles, for everything that draws one."""

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel


def half_circle(robot: RobotModel, pieces: int = 24) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return a leg at angle 0 as triangles, relative to its hip.

    Parameters
    ----------
    pieces : int
        Straight pieces that stand for the arc.

    Returns
    -------
    (4 * (pieces + 1), 3) float [m], corners; (8 * pieces + 4, 3) int, their numbers.
    """
    angle = np.linspace(0.0, np.pi, pieces + 1)
    half = robot.leg_width / 2.0
    thick = robot.leg_thickness / 2.0
    corners = ((thick, half), (thick, -half), (-thick, -half), (-thick, half))
    vertices = [(-(robot.leg_radius + out) * np.sin(a), y,
                 (robot.leg_radius + out) * np.cos(a) - robot.leg_radius)
                for a in angle for out, y in corners]
    faces = []
    for piece in range(pieces):
        for corner in range(4):
            a, b = 4 * piece + corner, 4 * piece + (corner + 1) % 4
            faces += [(a, b, b + 4), (a, b + 4, a + 4)]
    last = 4 * pieces
    faces += [(0, 2, 1), (0, 3, 2), (last, last + 1, last + 2), (last, last + 2, last + 3)]
    return np.array(vertices), np.array(faces)
