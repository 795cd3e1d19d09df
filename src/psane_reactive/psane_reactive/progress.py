# SPDX-License-Identifier: Apache-2.0
"""Notice that the robot drives without getting anywhere."""

from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.law import Pose

_LEAST = 0.15
_LEAST_SHARE = 0.1


class Progress:
    """Compares the way driven with how far it led, once per stall time."""

    def __init__(self, configuration: ReactiveConfiguration) -> None:
        self._configuration = configuration
        self._since: tuple[float, Pose] | None = None
        self._last: Pose | None = None
        self._driven = 0.0
        self.stalls = 0

    def reset(self) -> None:
        """Begin anew, with a new subgoal."""
        self._since, self._last, self._driven, self.stalls = None, None, 0.0, 0

    def watch(self, pose: Pose, now: float) -> int:
        """Return for how many stall times the robot has been getting nowhere since `reset`."""
        if self._since is None or self._last is None:
            self._since, self._last = (now, pose), pose
            return self.stalls
        self._driven += _distance(pose, self._last)
        self._last = pose
        if now - self._since[0] >= self._configuration.stall_time:
            led = _distance(pose, self._since[1])
            if led < max(_LEAST, _LEAST_SHARE * self._driven):
                self.stalls += 1
            self._since, self._driven = (now, pose), 0.0
        return self.stalls


def _distance(first: Pose, second: Pose) -> float:
    return float(((first.x - second.x) ** 2 + (first.y - second.y) ** 2) ** 0.5)
