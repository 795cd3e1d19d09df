# SPDX-License-Identifier: Apache-2.0
"""From a scene to a decision that always has a reason."""

import numpy as np
from psane_mapping.grid import FloatArray, Grid

from psane_planner.chooser import FrontierChooser
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import count_in_discs
from psane_planner.goal import refuse_goal
from psane_planner.memory import FrontierMemory
from psane_planner.persistence import Growth, Persistence
from psane_planner.placement import Placement
from psane_planner.region import Region
from psane_planner.scene import Scene
from psane_planner.scores import FrontierScores
from psane_planner.status import Decision, PlannerState
from psane_planner.strategies import Strategy
from psane_planner.survey import FrontierSurveyor, Survey
from psane_planner.verdicts import (
    bootstrap,
    lost,
    nothing_left,
    refused,
    too_narrow,
    without_growth,
)

# Progress toward a subgoal that counts as coming nearer [m].
_APPROACH_STEP = 0.02


class Mission:
    """Decides, cycle by cycle, on the way to one goal (or exploring without one)."""

    def __init__(self, configuration: PlannerConfiguration, grid: Grid,
                 strategy: Strategy) -> None:
        """Start without a goal and without a memory."""
        self._configuration = configuration
        self._grid = grid
        self._strategy = strategy
        self._surveyor = FrontierSurveyor(configuration, grid, strategy.traits)
        self._placement = Placement(configuration.subgoal_inset)
        self._goal: FloatArray | None = None
        self._begin()

    def _begin(self) -> None:
        self._chooser = FrontierChooser(self._configuration, self._grid, self._strategy)
        self._memory = FrontierMemory(self._configuration)
        self._without_ground = Persistence()
        self._without_frontier = Persistence()
        self._area_growth = Growth()
        self._approach = Growth(_APPROACH_STEP)
        self._has_reached = False
        self._subgoal: FloatArray | None = None

    @property
    def subgoal_count(self) -> int:
        """Frontiers chosen since the goal was set."""
        return self._chooser.changes

    def decide(self, scene: Scene) -> tuple[Decision, FrontierScores | None]:
        """Return what to do, and the scored frontier where one was looked for."""
        self._take_goal(scene.goal)
        decision = self._before_seeking(scene)
        if decision is not None or scene.region is None:
            self._without_frontier.duration(False, scene.now)
            self._chooser.cell = None
            assert decision is not None  # noqa: S101 - narrows the type; see _before_seeking
            return decision, None
        survey = self._survey(scene, scene.region)
        return self._seek(scene, scene.region, survey), survey.scores

    def _take_goal(self, goal: FloatArray | None) -> None:
        """Start afresh when the goal is another one."""
        is_same = (goal is None) == (self._goal is None) and (
            goal is None or np.array_equal(goal, self._goal))
        if not is_same:
            self._goal = goal
            self._begin()
