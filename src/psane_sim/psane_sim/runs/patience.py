# SPDX-License-Identifier: Apache-2.0
"""When the state of a planner ends the run of a robot among others.

A robot that stands in the way of another one stalls it only for a while.
"""

from psane_planner.status import PlannerState
from psane_sim.runs.closed_loop import ENDINGS
from psane_sim.runs.summary import Ending

PATIENCE = 20.0
"""Time for which a planner must be stalled before its run counts as ended [s]."""


class Patience:
    """Follows the states of one planner."""

    def __init__(self) -> None:
        self._stalled_since: float | None = None

    def ending(self, state: PlannerState, now: float) -> Ending | None:
        """Return how the run ended, or None while it goes on, at a time [s]."""
        if state is not PlannerState.STALLED:
            self._stalled_since = None
            return ENDINGS.get(state)
        if self._stalled_since is None:
            self._stalled_since = now
        return Ending.STALLED if now - self._stalled_since >= PATIENCE else None
