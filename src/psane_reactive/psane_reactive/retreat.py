# SPDX-License-Identifier: Apache-2.0
"""Lead a robot that is outside the region back by the shortest way."""

import math

from psane_mapping.grid import FloatArray
from psane_reactive.clearance import Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.law import Pose
from psane_reactive.limits import Velocity, clip, walkable, wrap

_DEPTH = 0.02
# Beyond this angle to the way back, driving does not bring the robot nearer.
_DRIVE_BELOW = 1.2


class Retreat:
    """Slow drive, forwards or backwards, to the nearest point inside; with hysteresis."""

    def __init__(self, configuration: ReactiveConfiguration) -> None:
        self._configuration = configuration
        self.is_active = False

    def is_needed(self, outside: float) -> bool:
        """Tell whether a robot `outside` [m] the region (negative inside) is to be led back."""
        if outside > self._configuration.outside_tolerance:
            self.is_active = True
        elif outside <= -0.25 * _DEPTH:
            self.is_active = False
        return self.is_active

    def velocity(self, border: Border, pose: Pose) -> Velocity:
        """Return the velocity towards the nearest point inside."""
        settings = self._configuration
        target = _just_inside(border, pose)
        error = pose.heading_error(target)
        direction = 1.0
        if abs(error) > math.pi / 2.0:
            error, direction = wrap(error + math.pi), -1.0
        angular = clip(settings.heading_gain * error, settings.angular_limit)
        if abs(error) > _DRIVE_BELOW:
            return Velocity(0.0, angular)
        return walkable(Velocity(direction * settings.retreat_speed, angular), settings)


def _just_inside(border: Border, pose: Pose) -> FloatArray:
    """Return a point a little beyond the nearest edge, seen from the robot, (2,) [m]."""
    edge = border.nearest(pose)
    outward = pose.position - edge
    distance = math.hypot(*outward)
    if border.outside_distance(pose) <= 0.0:
        outward = -outward
    if distance < 1e-9:
        return edge
    target: FloatArray = edge - _DEPTH * outward / distance
    return target
