# SPDX-License-Identifier: Apache-2.0
"""A robot in the live view: its body, its turning legs, and how hard the ground pushes on them."""

import numpy as np
import viser

from psane_mapping.grid import FloatArray
from psane_mapping.leg import LEG_NAMES, TRIPOD, RobotModel
from psane_sim.robot.leg_mesh import half_circle
from psane_sim.viewer.colours import FORCE
from psane_sim.viewer.shapes import foot_points, force_arrows, leg_turn

BODY, NOSE = (40, 62, 98), (235, 235, 235)
LEGS = ((230, 140, 33), (240, 200, 70))
"""Colours of the body, of the mark at its front, and of the legs of the two tripods."""


class RobotView:
    """Shows a robot where it is.

    Parameters
    ----------
    scene : viser.SceneApi
    name : str
        Of its node in the scene, beginning with a slash.
    model : RobotModel
    """

    def __init__(self, scene: viser.SceneApi, name: str, model: RobotModel) -> None:
        self._model = model
        self._quaternion = np.array([0.0, 0.0, 0.0, 1.0])
        self._angles = np.zeros(len(LEG_NAMES))
        self._forces_shown = True
        self._frame = scene.add_frame(name, show_axes=False, visible=False)
        size = (model.body_length, model.body_width, model.body_height)
        scene.add_box(f'{name}/body', color=BODY, dimensions=size)
        scene.add_box(f'{name}/nose', color=NOSE,
                      dimensions=(0.04, 0.8 * size[1], 0.5 * size[2]),
                      position=(size[0] / 2.0, 0.0, 0.3 * size[2]))
        vertices, faces = half_circle(model)
        self._legs = [
            scene.add_mesh_simple(f'{name}/{leg}', vertices, faces, color=LEGS[TRIPOD[index]],
                                  side='double', flat_shading=True,
                                  position=tuple(model.hips[index]))
            for index, leg in enumerate(LEG_NAMES)]
        nothing = np.zeros((len(LEG_NAMES), 2, 3))
        self._forces = scene.add_arrows(f'{name}/forces', nothing, FORCE, shaft_radius=0.006,
                                        head_radius=0.015, head_length=0.03, visible=False)

    def move(self, position: FloatArray, quaternion: FloatArray) -> None:
        """Put the body somewhere: position (3,) [m] and attitude x y z w, map frame."""
        self._quaternion = quaternion
        x, y, z, w = quaternion
        self._frame.position = position
        self._frame.wxyz = (w, x, y, z)
        if not self._frame.visible:
            self._frame.visible = True

    def turn_legs(self, angles: FloatArray) -> None:
        """Turn the legs to hip angles (6,) [rad]."""
        self._angles = angles
        for leg, angle in zip(self._legs, angles, strict=True):
            leg.wxyz = leg_turn(angle)

    def push(self, forces: FloatArray) -> None:
        """Show the forces (6, 3) of the legs on the body, base frame [N], at the feet."""
        feet = foot_points(self._model, self._angles, self._quaternion)
        self._forces.points = force_arrows(feet, forces).astype(np.float32)
        self._forces.visible = self._forces_shown

    def show_forces(self, visible: bool) -> None:
        """Show or hide the forces."""
        self._forces_shown = visible
        self._forces.visible = visible
