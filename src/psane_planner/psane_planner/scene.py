# SPDX-License-Identifier: Apache-2.0
"""All that one decision is made from."""

from dataclasses import dataclass

from psane_mapping.grid import FloatArray
from psane_planner.confidence import Bounds
from psane_planner.discs import Mask
from psane_planner.region import Region


@dataclass(frozen=True, kw_only=True)
class Scene:
    """The robot, its goal and the certified ground at one instant.

    Parameters
    ----------
    now : float [s]
    position : (2,) float, map frame [m]
    heading : float [rad]
        Yaw of the robot in the map.
    goal : (2,) float, map frame [m], or None
    bounds : Bounds
        Ends of C_t.
    admissible, certified, component : (rows, columns) bool
        Cells that may be certified, those that are, and those of them joined to the robot.
    outside_distance : float [m]
        Distance of the robot to the component.
    is_lost : bool
        Whether the robot counts as outside certified ground (with hysteresis).
    region : Region or None
        Where the robot may be steered.
    """

    now: float
    position: FloatArray
    heading: float
    goal: FloatArray | None
    bounds: Bounds
    admissible: Mask
    certified: Mask
    component: Mask
    outside_distance: float
    is_lost: bool
    region: Region | None
