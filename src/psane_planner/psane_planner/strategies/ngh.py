# SPDX-License-Identifier: Apache-2.0
"""Naive-goal heuristic: straight to the goal over whatever lies between."""

from psane_planner.scores import FrontierScores
from psane_planner.strategies.strategy import Strategy, Traits, best_of


class NaiveGoalHeuristic(Strategy):
    """No certification and no frontier (Jiang et al., section "Experimental Design").

    The planner sends such a strategy to the goal itself; `choose` only serves a caller that has
    frontiers all the same.
    """

    name = 'ngh'
    traits = Traits(is_certified=False, needs_growth=False)

    def choose(self, scores: FrontierScores) -> int:
        """Return the eligible cell of the largest goal value."""
        return best_of(scores.eligible, scores.goal_value, scores.expansion)
