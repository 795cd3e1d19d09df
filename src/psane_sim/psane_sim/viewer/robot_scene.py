# SPDX-License-Identifier: Apache-2.0
"""All that is shown of one robot: its newest data until the next drawing."""

from typing import Any

import numpy as np
import viser
from shapely.geometry import MultiPolygon, Polygon

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_sim.viewer.data import Situation
from psane_sim.viewer.plan import PlanView
from psane_sim.viewer.robot import RobotView
from psane_sim.viewer.words import headline

WORDS_ABOVE = 0.6
"""Height of the words above the body [m]."""


class RobotScene:
    """Keeps what is new of a robot and draws it when asked to.

    Parameters
    ----------
    scene : viser.SceneApi
    name : str
        Its namespace, which may be empty.
    model : RobotModel

    Attributes
    ----------
    situation : Situation or None
        What its planner said last.
    """

    def __init__(self, scene: viser.SceneApi, name: str, model: RobotModel) -> None:
        node = name.strip('/') or 'robot'
        self._name = name
        self._body = RobotView(scene, f'/{node}', model)
        self._plan = PlanView(scene, f'/{node}_plan')
        self.situation: Situation | None = None
        self._place: FloatArray | None = None
        self._pose: tuple[FloatArray, FloatArray] | None = None
        self._angles: FloatArray | None = None
        self._forces: FloatArray | None = None
        self._slow: dict[str, Any] = {}

    @property
    def place(self) -> FloatArray | None:
        """Where the body was last (3,), map frame [m]."""
        return self._place

    def take_pose(self, position: FloatArray, quaternion: FloatArray) -> None:
        """Take where the body is: position (3,) [m] and attitude x y z w, map frame."""
        self._pose = (position, quaternion)
        self._place = position

    def take_joints(self, angles: FloatArray) -> None:
        """Take the hip angles (6,) [rad]."""
        self._angles = angles

    def take_forces(self, forces: FloatArray) -> None:
        """Take the forces (6, 3) of the legs on the body, base frame [N]."""
        self._forces = forces

    def take_region(self, region: Polygon | MultiPolygon | None) -> None:
        """Take the region in which the robot is steered."""
        self._slow['region'] = region

    def take_frontier(self, points: FloatArray, scores: FloatArray) -> None:
        """Take the frontier (n, 2) [m] and its scores (n,)."""
        self._slow['frontier'] = (points, scores)

    def take_path(self, points: FloatArray) -> None:
        """Take the way (n, 2) [m] so far."""
        self._slow['path'] = points

    def take_subgoal(self, point: FloatArray | None) -> None:
        """Take the subgoal (2,) [m]; None where there is none."""
        self._plan.aim(point)

    def take_goal(self, point: FloatArray | None) -> None:
        """Take the goal (2,) [m]; None where there is none."""
        self._plan.want(point)

    def show_forces(self, visible: bool) -> None:
        """Show or hide the forces at the feet."""
        self._body.show_forces(visible)

    def draw(self, slow: bool) -> None:
        """Send what is new; lines and frontier only when `slow` says so."""
        if self._angles is not None:
            self._body.turn_legs(self._angles)
        if self._pose is not None:
            self._body.move(*self._pose)
            self._say(self._pose[0])
        if self._forces is not None:
            self._body.push(self._forces)
        self._angles = self._forces = self._pose = None
        if slow:
            self._draw_plan()

    def _say(self, position: FloatArray) -> None:
        if self.situation is not None:
            words = headline(self.situation)
            self._plan.say(f'{self._name} {words}'.strip(),
                           position + np.array([0.0, 0.0, WORDS_ABOVE]))

    def _draw_plan(self) -> None:
        slow, self._slow = self._slow, {}
        if 'region' in slow:
            self._plan.outline(slow['region'])
        if 'frontier' in slow:
            self._plan.line_up(*slow['frontier'])
        if 'path' in slow:
            self._plan.walked(slow['path'])
