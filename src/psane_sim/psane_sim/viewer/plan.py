# SPDX-License-Identifier: Apache-2.0
"""A plan in the live view: region, frontier, subgoal, goal, the way so far, and words."""

import numpy as np
import viser
from shapely.geometry import MultiPolygon, Polygon

from psane_mapping.grid import FloatArray
from psane_sim.viewer.colours import GOAL, PATH, REGION, SUBGOAL, shades_of
from psane_sim.viewer.shapes import lines_through, outline

REGION_HEIGHT, PATH_HEIGHT, FRONTIER_HEIGHT, DISC = 0.012, 0.014, 0.02, 0.03
"""Heights above the ground, and of the discs of subgoal and goal [m]."""


class PlanView:
    """Shows what a planner wants.

    Parameters
    ----------
    scene : viser.SceneApi
    name : str
        Of its node in the scene, beginning with a slash.
    """

    def __init__(self, scene: viser.SceneApi, name: str) -> None:
        self._scene, self._name = scene, name
        self._subgoal = scene.add_cylinder(f'{name}/subgoal', radius=0.08, height=DISC,
                                           color=SUBGOAL, visible=False)
        self._goal = scene.add_cylinder(f'{name}/goal', radius=0.15, height=DISC, color=GOAL,
                                        visible=False)
        self._words = scene.add_label(f'{name}/words', '', anchor='bottom-center',
                                      visible=False)

    def outline(self, region: Polygon | MultiPolygon | None) -> None:
        """Show the border of the region in which the robot is steered."""
        self._lines('region', outline(region, REGION_HEIGHT), REGION, 0.035)

    def line_up(self, points: FloatArray, scores: FloatArray) -> None:
        """Show the frontier (n, 2) [m], coloured by its scores (n,)."""
        raised = np.column_stack((points, np.full(len(points), FRONTIER_HEIGHT)))
        best = max(float(np.max(scores, initial=0.0)), 1e-12)
        # The node is made anew each time: a cloud cannot change its number of points.
        self._scene.add_point_cloud(
            f'{self._name}/frontier', raised.astype(np.float32),
            shades_of(scores, 'plasma', best), point_size=0.035, point_shape='square',
            precision='float32', point_shading='flat', visible=len(points) > 0)

    def walked(self, points: FloatArray) -> None:
        """Show the way (n, 2) [m] so far."""
        if len(points) > 1:
            self._lines('path', lines_through(points, PATH_HEIGHT), PATH, 0.03)

    def aim(self, subgoal: FloatArray | None) -> None:
        """Show the subgoal (2,) [m], or that there is none."""
        _put(self._subgoal, subgoal)

    def want(self, goal: FloatArray | None) -> None:
        """Show the goal (2,) [m], or that there is none."""
        _put(self._goal, goal)

    def say(self, words: str, place: FloatArray) -> None:
        """Show words above a place (3,) [m]."""
        self._words.text = words
        self._words.position = place
        self._words.visible = bool(words)

    def _lines(self, name: str, segments: FloatArray, colour: tuple[int, int, int],
               thickness: float) -> None:
        if len(segments):
            self._scene.add_line_segments(f'{self._name}/{name}', segments.astype(np.float32),
                                          colour, thickness=thickness)
        else:
            self._scene.remove_by_name(f'{self._name}/{name}')


def _put(disc: viser.CylinderHandle, point: FloatArray | None) -> None:
    if point is not None:
        disc.position = (float(point[0]), float(point[1]), DISC / 2.0)
    disc.visible = point is not None
