# SPDX-License-Identifier: Apache-2.0
"""When an errand of the action `navigate_safely` is over, and how it ended."""

from dataclasses import dataclass
from enum import IntEnum

from psane_planner.persistence import Persistence
from psane_planner.status import Plan, PlannerState


class ErrorCode(IntEnum):
    """How an errand ended; the numbers are those of `psane_msgs/NavigateSafely`."""

    NONE = 0
    INVALID_GOAL = 1
    INVALID_STRATEGY = 2
    INVALID_FRAME = 3
    STALLED = 4
    LOST = 5
    NO_DATA = 6
    PREEMPTED = 7
    UNKNOWN = 100


@dataclass(frozen=True)
class End:
    """The end of an errand: its code, and what happened in words."""

    code: ErrorCode
    message: str


LIMITS = {PlannerState.STALLED: (2.0, ErrorCode.STALLED),
          PlannerState.LOST: (60.0, ErrorCode.LOST),
          PlannerState.WAITING: (10.0, ErrorCode.NO_DATA)}
"""How long a state must last to end an errand [s], and the code it ends with."""


class Errand:
    """One goal of the action, or one exploration, from acceptance to its end."""

    def __init__(self, began: float, length: float) -> None:
        """Begin at the time `began` [s], after a way of `length` [m]."""
        self._began = began
        self._length = length
        self._lasting = {state: Persistence() for state in LIMITS}

    def end(self, plan: Plan) -> End | None:
        """Return how the errand has ended, None while it goes on."""
        lasted = {state: self._lasting[state].duration(plan.state is state, plan.now)
                  for state in LIMITS}
        if plan.state in (PlannerState.REACHED, PlannerState.EXPLORED):
            return End(ErrorCode.NONE, plan.cause or 'the goal is reached')
        if plan.is_refused:
            return End(ErrorCode.INVALID_GOAL, f'{plan.cause}; {plan.remedy}')
        if plan.state in LIMITS:
            limit, code = LIMITS[plan.state]
            if lasted[plan.state] >= limit:
                return End(code, f'{plan.cause}; {plan.remedy}')
        return None

    def time(self, now: float) -> float:
        """Return the time since acceptance [s]."""
        return now - self._began

    def walked(self, length: float) -> float:
        """Return the way since acceptance, from the length of the whole way [m]."""
        return length - self._length
