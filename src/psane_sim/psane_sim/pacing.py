# SPDX-License-Identifier: Apache-2.0
"""Keeps simulated time in step with the clock on the wall, or with another simulator."""

LARGEST_BURST = 8
"""Steps that are made up for at once; a machine that cannot keep up falls behind instead."""


class Pacer:
    """Tells how many steps are due.

    Parameters
    ----------
    pace : float
        Simulated seconds for each second on the wall.
    wall : float
        Time on the wall at simulated time 0 [s].
    """

    def __init__(self, pace: float, wall: float) -> None:
        self._pace = pace
        self._began = wall
        self._anchor = wall

    def due(self, wall: float, simulated: float, step: float) -> int:
        """Return the steps to make now; time that was lost beyond a burst is given up.

        Parameters
        ----------
        wall, simulated : float
            Time on the wall, and in the simulation [s].
        step : float
            Simulated time of one step [s].
        """
        steps = int(((wall - self._anchor) * self._pace - simulated) / step + 1e-6)
        if steps > LARGEST_BURST:
            self._anchor = wall - (simulated + LARGEST_BURST * step) / self._pace
        return max(0, min(steps, LARGEST_BURST))

    def factor(self, wall: float, simulated: float) -> float:
        """Return the real-time factor since the beginning [-]."""
        return simulated / max(wall - self._began, 1e-9)


class Follower:
    """Tells how many steps are due behind a leader, whose time is heard now and then.

    Parameters
    ----------
    wall : float
        Time on the wall at simulated time 0 [s].
    """

    def __init__(self, wall: float) -> None:
        self._began = wall
        self._leader = 0.0

    def hear(self, time: float) -> None:
        """Take in the leader's time [s]; it never runs backwards."""
        self._leader = max(self._leader, time)

    def due(self, wall: float, simulated: float, step: float) -> int:
        """Return the steps to make now, a burst at most, so that messages are taken in between."""
        steps = int((self._leader - simulated) / step + 1e-6)
        return max(0, min(steps, LARGEST_BURST))

    def factor(self, wall: float, simulated: float) -> float:
        """Return the real-time factor since the beginning [-]."""
        return simulated / max(wall - self._began, 1e-9)
