# SPDX-License-Identifier: Apache-2.0
"""The default: the paper's product, with distances measured along the ground."""

from psane_planner.scores import FrontierScores
from psane_planner.strategies.strategy import Strategy, Traits, best_of


class PsaneGeodesic(Strategy):
    """Maximise V_goal P_e with ways along certified, then along possibly safe ground.

    Notes
    -----
    Differs from Jiang et al. in its traits: see `Traits`.
    """

    name = 'psane_geodesic'
    traits = Traits(is_geodesic=True, holds_subgoal=False, rests_frontiers=True)

    def choose(self, scores: FrontierScores) -> int:
        """Return the Pareto-optimal cell of the largest overall score."""
        return best_of(scores.pareto, scores.overall, scores.goal_value)
