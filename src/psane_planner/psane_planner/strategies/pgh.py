# SPDX-License-Identifier: Apache-2.0
"""Pareto-goal heuristic: the two objectives take turns."""

from psane_planner.scores import FrontierScores
from psane_planner.strategies.strategy import Strategy, best_of

_SCHEDULE = ('goal', 'goal', 'expansion')


class ParetoGoalHeuristic(Strategy):
    """Rotating priority {goal, goal, expansion} on the Pareto front, ties by the other one.

    Notes
    -----
    Jiang et al., section "Experimental Design". One turn is one choice.
    """

    name = 'pgh'

    def __init__(self) -> None:
        """Begin with the goal's turn."""
        self._turn = 0

    def choose(self, scores: FrontierScores) -> int:
        """Return the best Pareto-optimal cell for the objective whose turn it is."""
        preferred = _SCHEDULE[self._turn % len(_SCHEDULE)]
        self._turn += 1
        if preferred == 'goal':
            return best_of(scores.pareto, scores.goal_value, scores.expansion)
        return best_of(scores.pareto, scores.expansion, scores.goal_value)
