# SPDX-License-Identifier: Apache-2.0
"""The robot stops by itself when nobody commands it any more."""

import math


class CommandWatchdog:
    """Hands on the last command while it is young enough, and standstill afterwards.

    Parameters
    ----------
    timeout : float
        Age at which a command is void [s].
    """

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self._command = (0.0, 0.0)
        self._time = -math.inf

    def take(self, linear: float, angular: float, now: float) -> None:
        """Take in a command of forward speed [m/s] and yaw rate [rad/s]."""
        self._command, self._time = (linear, angular), now

    def is_silent(self, now: float) -> bool:
        """Tell whether the last command is too old to be obeyed."""
        return now - self._time > self.timeout

    def command(self, now: float) -> tuple[float, float]:
        """Return the command to obey at `now` [s]."""
        return (0.0, 0.0) if self.is_silent(now) else self._command
