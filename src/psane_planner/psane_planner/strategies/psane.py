# SPDX-License-Identifier: Apache-2.0
"""The paper's strategy: the best product of both objectives on the Pareto front."""

from psane_planner.scores import FrontierScores
from psane_planner.strategies.strategy import Strategy, best_of


class Psane(Strategy):
    """Maximise V_goal P_e on the Pareto front (Jiang et al., Algorithm 1)."""

    name = 'psane'

    def choose(self, scores: FrontierScores) -> int:
        """Return the Pareto-optimal cell of the largest overall score."""
        return best_of(scores.pareto, scores.overall, scores.goal_value)
