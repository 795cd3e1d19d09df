# SPDX-License-Identifier: Apache-2.0
"""The way that the robot has come, thinned out."""

import math

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

from psane_mapping.conversions import header, pose_message
from psane_mapping.grid import FloatArray

SPACING = 0.1
"""Distance between the points that are kept [m]."""

LONGEST = 20_000
"""Points that are kept; a longer way loses its beginning."""


class Trail:
    """Keeps a point for every step of `SPACING`; `length` is that of the whole way [m]."""

    def __init__(self) -> None:
        self._points: list[FloatArray] = []
        self.length = 0.0
        self._poses: list[PoseStamped] = []

    def add(self, point: FloatArray) -> bool:
        """Take in a point (2,) [m]; return whether it was kept."""
        if self._points:
            step = point - self._points[-1]
            if float(step @ step) < SPACING**2:
                return False
            self.length += math.sqrt(float(step @ step))
        self._points.append(point)
        del self._points[:-LONGEST]
        return True

    def message(self, time: float, frame: str) -> Path:
        """Return the way as a message."""
        for point in self._points[len(self._poses):]:
            self._poses.append(pose_message(point, 0.0, time, frame))
        del self._poses[:-LONGEST]
        return Path(header=header(time, frame), poses=self._poses)
