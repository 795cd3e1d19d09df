# SPDX-License-Identifier: Apache-2.0
"""What a strategy is: a rule that picks a frontier, and a few facts about how it is to be run."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_planner.scores import FrontierScores


@dataclass(frozen=True, kw_only=True)
class Traits:
    """How the planner prepares the choice and follows it.

    Parameters
    ----------
    is_certified : bool
        False for a strategy that walks anywhere.
    needs_growth : bool
        Only frontiers with something to win (g_t > 0) may be chosen.
    is_geodesic : bool
        Distances are measured along the ground, g_t skips cells known to be unsafe, and frontiers
        that the steered point cannot come within reach of are passed over.
    holds_subgoal : bool
        A subgoal is kept until it is reached; otherwise every cycle may choose anew.
    rests_frontiers : bool
        Frontiers that do not grow are set aside for a while.
    """

    is_certified: bool = True
    needs_growth: bool = True
    is_geodesic: bool = False
    holds_subgoal: bool = True
    rests_frontiers: bool = False


class Strategy(ABC):
    """Chooses among scored frontier cells. A new strategy is one subclass in one file."""

    name: ClassVar[str]
    traits: ClassVar[Traits] = Traits()

    @abstractmethod
    def choose(self, scores: FrontierScores) -> int:
        """Return the index of the chosen cell; at least one cell of `scores` is eligible."""


def best_of(candidates: NDArray[np.bool_], first: FloatArray, second: FloatArray) -> int:
    """Return the candidate with the largest `first`, ties broken by `second`, then by order."""
    indices = np.flatnonzero(candidates)
    order = np.lexsort((-second[indices], -first[indices]))
    return int(indices[order[0]])
