# SPDX-License-Identifier: Apache-2.0
"""Safe-goal heuristic: the frontier nearest the goal, whatever can be won there."""

from psane_planner.scores import FrontierScores
from psane_planner.strategies.strategy import Strategy, Traits, best_of


class SafeGoalHeuristic(Strategy):
    """Maximise V_goal alone (Jiang et al., section "Experimental Design")."""

    name = 'sgh'
    traits = Traits(needs_growth=False)

    def choose(self, scores: FrontierScores) -> int:
        """Return the eligible cell of the largest goal value."""
        return best_of(scores.eligible, scores.goal_value, scores.expansion)
