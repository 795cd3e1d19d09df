# SPDX-License-Identifier: Apache-2.0
"""Which frontier the robot is on its way to, from one cycle to the next."""

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import Integers, Mask
from psane_planner.scores import FrontierScores
from psane_planner.strategies import Strategy
from psane_planner.transfer import Transfer


class FrontierChooser:
    """Asks the strategy, and keeps to what was chosen as long as that is right.

    A strategy that holds its subgoal is asked again when the subgoal is reached or has dropped
    out of the robot's component. Any other is asked in every cycle: the frontier under way is
    kept while it is one and no other scores `keep_ratio` times better; when it has ceased to be
    one, cells near it are preferred by the same ratio, so that two frontiers of equal merit do
    not pull the robot to and fro.
    """

    def __init__(self, configuration: PlannerConfiguration, grid: Grid,
                 strategy: Strategy) -> None:
        """Start on the way to nowhere."""
        self._configuration = configuration
        self._grid = grid
        self._strategy = strategy
        self.cell: Integers | None = None
        self.changes = 0

    def reset(self) -> None:
        """Forget the frontier under way and the number of choices."""
        self.cell = None
        self.changes = 0

    def move(self, grid: Grid, transfer: Transfer) -> None:
        """Go on on a grid of another extent."""
        self._grid = grid
        if self.cell is None:
            return
        cell = self.cell + (transfer.rows, transfer.columns)
        is_inside = (cell >= 0).all() and (cell < transfer.shape).all()
        self.cell = cell if is_inside else None

    def choose(self, scores: FrontierScores, component: Mask,
               has_arrived: bool) -> Integers | None:
        """Return row and column of the frontier to go to, None when none is eligible.

        Parameters
        ----------
        component : (rows, columns) bool
            The robot's certified cells.
        has_arrived : bool
            Whether the robot stands at the subgoal that stems from the last choice.
        """
        if self._strategy.traits.holds_subgoal and self.cell is not None and not has_arrived \
                and component[self.cell[0], self.cell[1]]:
            return self.cell
        if not scores.eligible.any():
            return None
        best = self._strategy.choose(scores)
        if not self._strategy.traits.holds_subgoal and self.cell is not None:
            best = self._with_inertia(scores, best, self.cell)
        chosen = scores.cells[best]
        if self.cell is None or not np.array_equal(chosen, self.cell):
            self.changes += 1
        self.cell = chosen
        return self.cell

    def _with_inertia(self, scores: FrontierScores, best: int, cell: Integers) -> int:
        ratio = self._configuration.keep_ratio
        overall = np.where(scores.eligible, scores.overall, -1.0)
        same = np.flatnonzero((scores.cells == cell).all(axis=1) & scores.eligible)
        if same.size:
            return int(same[0]) if overall[same[0]] * ratio >= overall[best] else best
        here: FloatArray = self._grid.point_of(cell)
        near = ((scores.points - here) ** 2).sum(axis=1) <= self._configuration.neighbourhood**2
        preferred = int(np.argmax(np.where(near, overall, -1.0)))
        return preferred if overall[preferred] * ratio >= overall[best] else best
