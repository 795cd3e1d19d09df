# SPDX-License-Identifier: Apache-2.0
"""When the maps are worth publishing again."""

import math

_BUSY_SHARE = 0.2


class Pacer:
    """Lets a changed map out at once, but not too often, and not at the cost of the contacts.

    Parameters
    ----------
    rate : float
        Most publications in a second of the graph's time [Hz].
    """

    def __init__(self, rate: float) -> None:
        self._period = 1.0 / rate
        self._version = -1
        self._now = -math.inf
        self._wall = -math.inf
        self._cost = 0.0

    def is_due(self, version: int, now: float, wall: float) -> bool:
        """Tell whether to publish a map of a version.

        Parameters
        ----------
        version : int
            Counts the changes of the map.
        now : float
            Time of the graph [s]; it may jump back, as a simulation's does.
        wall : float
            Time of a clock that does not jump [s].
        """
        if version == self._version:
            return False
        early = 0.0 <= now - self._now < self._period * (1.0 - 1e-6)
        # A large map takes long to publish; contacts have the rest of the time to themselves.
        return not early and wall - self._wall >= self._cost / _BUSY_SHARE

    def published(self, version: int, now: float, wall: float, cost: float) -> None:
        """Note that a version was published, which ended at `wall` and took `cost` [s]."""
        self._version, self._now, self._wall, self._cost = version, now, wall, cost
