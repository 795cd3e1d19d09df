# SPDX-License-Identifier: Apache-2.0
"""What can go wrong in the planner; every error names the value and what was expected."""

from typing import Any


class PlannerError(Exception):
    """Root of the planner package's errors."""


class MapError(PlannerError, ValueError):
    """A map does not fit the planner's grid or holds values that mean nothing."""


class PoseError(PlannerError, ValueError):
    """A pose or goal holds a number that is not finite or has the wrong size."""

    def __init__(self, name: str, value: Any, expected: str) -> None:
        super().__init__(f'{name} = {value!r}, expected {expected}')
        self.name = name
        self.value = value
        self.expected = expected


class StrategyError(PlannerError, ValueError):
    """A strategy is not known."""

    def __init__(self, name: str, available: list[str]) -> None:
        super().__init__(f'unknown strategy {name!r}; available: {available}')
        self.name = name
        self.available = available
