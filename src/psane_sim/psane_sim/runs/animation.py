# SPDX-License-Identifier: Apache-2.0
"""A moving picture of a run: the hexapod on its ground, and beside it its way over the truth."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from psane_mapping.grid import FloatArray
from psane_sim.robot.render import Camera, Renderer
from psane_sim.runs.run_data import StoredRun
from psane_sim.terrains.terrain import Terrain

Frame = NDArray[np.uint8]

SIZE = (400, 300)
"""Width and height of the view of the robot [pixels]; the map is as high."""

MOST_FRAMES = 120
FRAME_TIME = 90
"""How long each frame is shown [ms]."""

QUALITY = 55
_CAMERA = Camera(distance=1.9, yaw=2.5, pitch=0.55)


@dataclass(frozen=True)
class Posture:
    """How body and legs are, as `Renderer` wants it; see `Truth`."""

    position: FloatArray
    quaternion: FloatArray
    joint_angle: FloatArray

    @property
    def yaw(self) -> float:
        """Heading [rad]."""
        x, y, z, w = self.quaternion
        return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def animate(run: StoredRun, terrain: Terrain, threshold: float, path: Path) -> None:
    """Write a run that has postures as an animated picture (.webp or .gif)."""
    pictures = [Image.fromarray(frame) for frame in frames_of(run, terrain, threshold)]
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=FRAME_TIME,
                     loop=0, quality=QUALITY, method=4)


def frames_of(run: StoredRun, terrain: Terrain, threshold: float,
              most: int = MOST_FRAMES) -> list[Frame]:
    """Return frames (height, width, 3), red green blue, at equal times over the run."""
    postures = run.postures
    chosen = np.unique(np.linspace(0, len(postures) - 1, most).round().astype(int))
    ground = map_picture(terrain, threshold, SIZE[1])
    renderer = Renderer(terrain)
    try:
        return [_frame(renderer, ground, run, postures[index]) for index in chosen]
    finally:
        renderer.close()


def _frame(renderer: Renderer, ground: Frame, run: StoredRun, row: FloatArray) -> Frame:
    posture = Posture(row[1:4].astype(float), row[4:8].astype(float), row[8:].astype(float))
    view = renderer.frame(posture, *SIZE, _CAMERA)
    view = np.ascontiguousarray(view)
    cv2.putText(view, f'{row[0]:.0f} s', (10, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 0), 2,
                cv2.LINE_AA)
    way = run.path[run.path[:, 0] <= row[0] + 1e-6]
    plan = ground.copy()
    points = pixels_of(way[:, 1:], len(plan))
    cv2.polylines(plan, [points.reshape(-1, 1, 2)], False, (20, 20, 20), 2, cv2.LINE_AA)
    cv2.circle(plan, tuple(int(v) for v in pixels_of(row[None, 1:3], len(plan))[0]), 5,
               (215, 25, 28), -1, cv2.LINE_AA)
    return np.hstack((view, plan))


def map_picture(terrain: Terrain, threshold: float, size: int) -> Frame:
    """Return the true slip as a square picture, north up, with the line of the threshold."""
    at = np.linspace(0.0, 10.0, size)
    slip = terrain.true_slip(np.stack(np.meshgrid(at, at[::-1]), axis=-1))
    colour = cv2.applyColorMap((255 * slip).astype(np.uint8), cv2.COLORMAP_VIRIDIS)[..., ::-1]
    picture = (0.55 * colour + 0.45 * 235).astype(np.uint8)
    lines, _ = cv2.findContours((slip > threshold).astype(np.uint8), cv2.RETR_LIST,
                                cv2.CHAIN_APPROX_NONE)
    made = np.ascontiguousarray(picture)
    cv2.drawContours(made, lines, -1, (120, 0, 20), 1, cv2.LINE_AA)
    for point, tint in ((terrain.start, (26, 150, 65)), (terrain.goal, (255, 200, 0))):
        centre = pixels_of(np.array([point]), size)[0]
        cv2.circle(made, (int(centre[0]), int(centre[1])), 6, tint, -1, cv2.LINE_AA)
    return made


def pixels_of(points: FloatArray, size: int) -> NDArray[np.int32]:
    """Return columns and rows (n, 2) of points (n, 2), map frame [m], in a picture of the map."""
    scale = (size - 1) / 10.0
    x, y = points[:, 0] * scale, (size - 1) - points[:, 1] * scale
    return np.column_stack((x, y)).round().astype(np.int32)
