# SPDX-License-Identifier: Apache-2.0
"""Pictures of the hexapod on its ground, drawn without a display."""

import math
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_sim.robot.quiet_pybullet import pybullet
from psane_sim.robot.robot_body import load_robot
from psane_sim.terrains.terrain import Terrain

_TEXELS = 2048


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Where the picture is taken from, relative to what it looks at.

    Parameters
    ----------
    target : (x, y, z), optional
        Looked at, map frame [m]; the robot if there is none.
    distance : float
        From the target [m].
    yaw : float
        Direction of the camera as seen from the target, relative to the robot's heading when it
        looks at the robot, else to the map's x axis [rad].
    pitch : float
        Height of the camera above the horizon [rad].
    field_of_view : float
        Vertical [rad].
    """

    target: tuple[float, float, float] | None = None
    distance: float = 1.3
    yaw: float = -0.9
    pitch: float = 0.4
    field_of_view: float = 0.7


class Seen(Protocol):
    """What of a robot can be seen; `Truth` has it all."""

    @property
    def position(self) -> FloatArray:
        """Origin of the base frame (3,), map frame [m]."""

    @property
    def quaternion(self) -> FloatArray:
        """Attitude of the base in the map, x y z w (4,) [-]."""

    @property
    def joint_angle(self) -> FloatArray:
        """Hip joints (6,) [rad]."""

    @property
    def yaw(self) -> float:
        """Heading [rad]."""


class Renderer:
    """Draws truths of one robot on one terrain; it has an engine of its own.

    The ground is coloured by true slip, from dark (firm) to yellow (soft); what is below the
    surface is hidden by it.

    Parameters
    ----------
    terrain : Terrain
    robot : RobotModel, optional
    """

    def __init__(self, terrain: Terrain, robot: RobotModel | None = None) -> None:
        self._client = int(pybullet.connect(pybullet.DIRECT))
        self._body = load_robot(robot or RobotModel(), self._client, visible=True)
        add_ground(terrain, self._client)

    def frame(self, truth: Seen, width: int = 640, height: int = 480,
              camera: Camera | None = None) -> NDArray[np.uint8]:
        """Draw a truth; returns (height, width, 3) uint8, red green blue."""
        camera = camera or Camera()
        pybullet.resetBasePositionAndOrientation(self._body, truth.position, truth.quaternion,
                                                 physicsClientId=self._client)
        for leg, angle in enumerate(truth.joint_angle):
            pybullet.resetJointState(self._body, leg, angle, physicsClientId=self._client)
        target = truth.position if camera.target is None else np.array(camera.target)
        yaw = camera.yaw + (truth.yaw if camera.target is None else 0.0)
        eye = target + camera.distance * np.array([
            math.cos(yaw) * math.cos(camera.pitch), math.sin(yaw) * math.cos(camera.pitch),
            math.sin(camera.pitch)])
        view = pybullet.computeViewMatrix(eye.tolist(), target.tolist(), [0, 0, 1])
        lens = pybullet.computeProjectionMatrixFOV(math.degrees(camera.field_of_view),
                                                   width / height, 0.05, 50.0)
        picture = pybullet.getCameraImage(
            width, height, view, lens, shadow=1, lightDirection=[-2.0, 3.0, 6.0],
            lightAmbientCoeff=0.6, lightDiffuseCoeff=0.5, lightSpecularCoeff=0.05,
            renderer=pybullet.ER_TINY_RENDERER, physicsClientId=self._client)[2]
        return np.reshape(np.asarray(picture, dtype=np.uint8), (height, width, 4))[..., :3].copy()

    def close(self) -> None:
        """Close the renderer's engine."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1


def add_ground(terrain: Terrain, client: int) -> None:
    """Add a plane with the terrain's slip as its texture to an engine, for looks only."""
    with TemporaryDirectory() as folder:
        picture, mesh = Path(folder) / 'ground.png', Path(folder) / 'ground.obj'
        cv2.imwrite(str(picture), ground_texture(terrain))
        mesh.write_text(_plane_mesh(*terrain.grid_extent))
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH, fileName=str(mesh), rgbaColor=[1, 1, 1, 1],
            specularColor=[0, 0, 0], physicsClientId=client)
        ground = pybullet.createMultiBody(0.0, -1, shape, physicsClientId=client)
        texture = pybullet.loadTexture(str(picture), physicsClientId=client)
    pybullet.changeVisualShape(ground, -1, textureUniqueId=texture, physicsClientId=client)


def ground_texture(terrain: Terrain) -> NDArray[np.uint8]:
    """Return the slip as a picture (blue, green, red), north up, with grains and a 1 m grid."""
    min_x, min_y, max_x, max_y = terrain.grid_extent
    x = np.linspace(min_x, max_x, _TEXELS)
    y = np.linspace(max_y, min_y, _TEXELS)
    points = np.stack(np.meshgrid(x, y), axis=-1)
    slip = terrain.true_slip(points)
    colour = cv2.applyColorMap((255.0 * slip).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    sand = np.array([150.0, 190.0, 214.0])
    grains = np.random.default_rng(0).normal(1.0, 0.07, slip.shape)[..., None]
    mixed = (0.55 * colour + 0.45 * sand) * grains
    texel = (max_x - min_x) / _TEXELS
    line = (np.abs(points - np.round(points)) < texel).any(axis=-1)
    mixed[line] *= 0.8
    return np.clip(mixed, 0, 255).astype(np.uint8)


def _plane_mesh(min_x: float, min_y: float, max_x: float, max_y: float, cells: int = 40) -> str:
    """Return a flat square, cut small so that the painter's depth order holds, as an OBJ."""
    x = np.linspace(min_x, max_x, cells + 1)
    y = np.linspace(min_y, max_y, cells + 1)
    lines = [f'v {a:.5f} {b:.5f} 0' for b in y for a in x]
    lines += [f'vt {i / cells:.5f} {j / cells:.5f}' for j in range(cells + 1)
              for i in range(cells + 1)]
    lines.append('vn 0 0 1')
    for j in range(cells):
        for i in range(cells):
            a = j * (cells + 1) + i + 1
            corners = (a, a + 1, a + cells + 2, a + cells + 1)
            for triangle in (corners[:3], (corners[0], corners[2], corners[3])):
                lines.append('f ' + ' '.join(f'{c}/{c}/1' for c in triangle))
    return '\n'.join(lines) + '\n'
