# SPDX-License-Identifier: Apache-2.0
"""Where the live view is looked at from."""

import numpy as np
import viser

from psane_mapping.grid import FloatArray, Grid

CLOSE = 1.8
"""Distance of the camera from a robot [m]."""

BACK, UP = 0.62, 0.78
"""Where the camera is: shares of its distance to the south of what it looks at, and above it."""


def overview_of(grid: Grid) -> tuple[FloatArray, float]:
    """Return the middle (3,) of the ground and a distance from which it is seen whole [m]."""
    width, height = grid.columns * grid.resolution, grid.rows * grid.resolution
    middle = np.array([grid.origin_x + width / 2.0, grid.origin_y + height / 2.0, 0.0])
    return middle, 1.02 * max(width, height)


def point_camera(camera: viser.InitialCameraConfig | viser.CameraHandle, target: FloatArray,
                 distance: float) -> None:
    """Look at a target (3,) [m] from the south, at a distance [m]."""
    position = target + distance * np.array([0.0, -BACK, UP])
    if isinstance(camera, viser.CameraHandle):
        camera.up_direction = (0.0, 0.0, 1.0)
    else:
        camera.up = (0.0, 0.0, 1.0)
    camera.position = tuple(position)
    camera.look_at = tuple(target)
