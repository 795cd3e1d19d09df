# SPDX-License-Identifier: Apache-2.0
"""The strategies by name; a new one is one file and one line here."""

from psane_planner.errors import StrategyError
from psane_planner.strategies.ngh import NaiveGoalHeuristic
from psane_planner.strategies.pgh import ParetoGoalHeuristic
from psane_planner.strategies.psane import Psane
from psane_planner.strategies.psane_geodesic import PsaneGeodesic
from psane_planner.strategies.sgh import SafeGoalHeuristic
from psane_planner.strategies.strategy import Strategy, Traits

AVAILABLE: dict[str, type[Strategy]] = {
    kind.name: kind
    for kind in (PsaneGeodesic, Psane, ParetoGoalHeuristic, SafeGoalHeuristic, NaiveGoalHeuristic)
}


def make_strategy(name: str) -> Strategy:
    """Return a new strategy.

    Raises
    ------
    StrategyError
        When there is none of that name; the message lists those there are.
    """
    if name not in AVAILABLE:
        raise StrategyError(name, sorted(AVAILABLE))
    return AVAILABLE[name]()


__all__ = ['AVAILABLE', 'Strategy', 'Traits', 'make_strategy']
