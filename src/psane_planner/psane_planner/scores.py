# SPDX-License-Identifier: Apache-2.0
"""What speaks for a frontier: the chance to win ground there, and how far out of the way it is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_planner.discs import Integers
from psane_planner.pareto import pareto_front


@dataclass(frozen=True, kw_only=True)
class FrontierScores:
    """The frontier cells of one cycle and their merits.

    Parameters
    ----------
    cells : (n, 2) int
        Row and column.
    points : (n, 2) float, map frame [m]
    growth : (n,) float [-], count
        g_t, the cells that might be certified from here.
    expansion : (n,) float [-], probability
        P_e = 1 - exp(-k_e g_t).
    goal_value : (n,) float [-]
        V_goal = exp(-k_g (way to the goal + way from the robot)).
    overall : (n,) float [-]
        P_e V_goal.
    eligible : (n,) bool
        Cells the strategy may choose; the others are kept for display.
    pareto : (n,) bool
        Pareto front of (P_e, V_goal) among the eligible.
    """

    cells: Integers
    points: FloatArray
    growth: FloatArray
    expansion: FloatArray
    goal_value: FloatArray
    overall: FloatArray
    eligible: NDArray[np.bool_]
    pareto: NDArray[np.bool_]

    @property
    def count(self) -> int:
        """Number of frontier cells."""
        return int(self.cells.shape[0])


def score_frontier(cells: Integers, points: FloatArray, growth: FloatArray, way: FloatArray,
                   eligible: NDArray[np.bool_], expansion_rate: float,
                   goal_decay: float) -> FrontierScores:
    """Score frontier cells.

    Parameters
    ----------
    way : (n,) float [m]
        Way from the robot to the cell, and on to the goal if there is one.
    expansion_rate : float [-]
        k_e.
    goal_decay : float [1/m]
        k_g.

    Notes
    -----
    Jiang et al., section "Subgoal Selection". Without a goal the term |x - goal| is left out.
    """
    expansion = 1.0 - np.exp(-expansion_rate * growth)
    goal_value = np.exp(-goal_decay * way)
    pareto = np.zeros(cells.shape[0], dtype=np.bool_)
    pareto[eligible] = pareto_front(expansion[eligible], goal_value[eligible])
    return FrontierScores(cells=cells, points=points, growth=growth, expansion=expansion,
                          goal_value=goal_value, overall=expansion * goal_value,
                          eligible=eligible, pareto=pareto)
