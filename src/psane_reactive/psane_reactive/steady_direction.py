# SPDX-License-Identifier: Apache-2.0
"""Turn the direction of travel steadily, although region and subgoal change in steps."""

import math

import numpy as np

from psane_mapping.grid import FloatArray
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.law import Pose
from psane_reactive.limits import clip, wrap

# Beyond this pause what was steered towards means nothing any more [s].
_LONGEST_PAUSE = 0.5


class SteadyDirection:
    """Follows the direction to the target, no faster than a rate [rad/s], with a short memory.

    Notes
    -----
    Frontier subgoals hop between neighbouring cells several times a second. The direction
    approaches that of the target with a time constant, so hops to and fro cancel out, and its
    rate is limited besides.
    """

    def __init__(self, configuration: ReactiveConfiguration) -> None:
        self._configuration = configuration
        self._last: tuple[float, float] | None = None

    def reset(self) -> None:
        """Forget the direction of travel."""
        self._last = None

    def toward(self, pose: Pose, target: FloatArray, now: float) -> FloatArray:
        """Return the target (2,) [m] turned about the robot into the steady direction."""
        settings = self._configuration
        away = target - pose.position
        wanted = math.atan2(away[1], away[0])
        direction = wanted
        if self._last is not None and 0.0 <= now - self._last[0] <= _LONGEST_PAUSE:
            step, before = now - self._last[0], self._last[1]
            share = 1.0 - math.exp(-step / settings.direction_time)
            change = clip(share * wrap(wanted - before), settings.direction_rate * step)
            direction = wrap(before + change)
        self._last = (now, direction)
        distance = math.hypot(away[0], away[1])
        return pose.position + distance * np.array((math.cos(direction), math.sin(direction)))
