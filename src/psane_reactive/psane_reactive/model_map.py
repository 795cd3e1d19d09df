# SPDX-License-Identifier: Apache-2.0
"""What every map from the region to its model space offers; steering uses nothing else of it."""

from dataclasses import dataclass
from typing import Protocol

from psane_mapping.grid import FloatArray


@dataclass(frozen=True)
class Way:
    """The first stretch of a way through the region.

    Parameters
    ----------
    points : (k, 2) float, map frame [m]
        From the robot (left out) on; all inside the region.
    ends_at_goal : bool
        True when the last point is the goal.
    """

    points: FloatArray
    ends_at_goal: bool


class ModelMap(Protocol):
    """A one-to-one map of a region onto a space in which the way is a simple one."""

    def to_model(self, points: FloatArray) -> FloatArray:
        """Map points (n, 2) of the region, map frame [m], to the model space (n, 2) [-]."""

    def jacobian(self, point: FloatArray) -> FloatArray:
        """Return d(model)/d(point) at a point (2,) of the region, (2, 2) [1/m]."""

    def way(self, position: FloatArray, goal: FloatArray, reach: float) -> Way | None:
        """Pull the model's way from a position to a goal, (2,) [m], back into the region.

        Returns
        -------
        Its first `reach` metres, or None where the map does not tell.
        """
