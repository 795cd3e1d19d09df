# SPDX-License-Identifier: Apache-2.0
"""What the live view plots over time, in bounded memory."""

from collections import deque

import numpy as np

from psane_mapping.grid import FloatArray

MOST_POINTS = 600
"""Points of a plot; when there are more, every second one is dropped."""

WINDOW = 3.0
"""Time on the wall over which the real-time factor is a mean [s]."""


class Series:
    """Values over time. Old points get sparser, so that a long run fits.

    Parameters
    ----------
    count : int
        Values at each time.
    """

    def __init__(self, count: int) -> None:
        self._rows: list[tuple[float, ...]] = []
        self._count = count
        self._step = 0.0

    def add(self, time: float, *values: float) -> None:
        """Add values at a time [s]; too soon after the last ones, or before them, is ignored."""
        if len(values) != self._count:
            raise ValueError(f'{len(values)} values, expected {self._count}')
        if self._rows and time - self._rows[-1][0] <= self._step:
            return
        self._rows.append((time, *values))
        if len(self._rows) > MOST_POINTS:
            self._rows = self._rows[::2]
            self._step = (self._rows[-1][0] - self._rows[0][0]) / len(self._rows)

    def columns(self) -> tuple[FloatArray, ...]:
        """Return the times and each value's history."""
        table = np.array(self._rows).reshape(-1, 1 + self._count)
        return tuple(np.ascontiguousarray(column) for column in table.T)


class RealTimeFactor:
    """Simulated seconds for each second on the wall, over the last few seconds."""

    def __init__(self) -> None:
        self._pairs: deque[tuple[float, float]] = deque()

    def add(self, wall: float, time: float) -> None:
        """Take in the simulation's time at a time on the wall [s]."""
        if self._pairs and time < self._pairs[-1][1]:
            self._pairs.clear()
        self._pairs.append((wall, time))
        while wall - self._pairs[0][0] > WINDOW and len(self._pairs) > 2:
            self._pairs.popleft()

    @property
    def value(self) -> float:
        """The factor [-]; not a number until something is known."""
        if len(self._pairs) < 2:
            return float('nan')
        (wall, time), (wall_now, now) = self._pairs[0], self._pairs[-1]
        return (now - time) / max(wall_now - wall, 1e-9)
