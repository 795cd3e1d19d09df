# SPDX-License-Identifier: Apache-2.0
"""How long something has been so without a break."""


class Persistence:
    """Time since a condition began to hold."""

    def __init__(self) -> None:
        """Start with the condition not holding."""
        self._since: float | None = None

    def duration(self, is_so: bool, now: float) -> float:
        """Return how long `is_so` has held without a break [s], 0 when it does not hold."""
        if not is_so:
            self._since = None
            return 0.0
        if self._since is None or now < self._since:
            self._since = now
        return now - self._since


class Growth:
    """Time since a quantity last exceeded its record."""

    def __init__(self, step: float = 0.0) -> None:
        """Count as growth only what exceeds the record by more than `step`."""
        self._step = step
        self._record = float('-inf')
        self._since = 0.0

    def reset(self) -> None:
        """Forget the record."""
        self._record = float('-inf')

    def time_without(self, value: float, now: float) -> float:
        """Return the time since growth [s], having taken note of `value`."""
        if value > self._record + self._step or now < self._since:
            self._record = value
            self._since = now
        return now - self._since
