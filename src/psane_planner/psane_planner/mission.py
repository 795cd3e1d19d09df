# SPDX-License-Identifier: Apache-2.0
"""From a scene to a decision that always has a reason."""

import math

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner import verdicts
from psane_planner.chooser import FrontierChooser
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import Integers, count_in_discs
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
from psane_planner.transfer import Transfer

# Progress toward a subgoal that counts as coming nearer [m].
_APPROACH_STEP = 0.02
# Certified area that counts as growth of the search as a whole [m^2].
_AREA_STEP = 0.1
# Share of the goal tolerance by which the point steered to may miss the goal; the rest is for
# the controller's own.
_GOAL_SHARE = 0.5
# A place that comes back from the steering is the same one up to rounding [m].
_SAME_SUBGOAL = 0.01


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
        self._begin(None)

    def _begin(self, goal: FloatArray | None) -> None:
        self._goal = goal
        self._chooser = FrontierChooser(self._configuration, self._grid, self._strategy)
        self._memory = FrontierMemory(self._configuration)
        self._without_region = Persistence()
        self._without_frontier = Persistence()
        self._area_growth = Growth(_AREA_STEP)
        self._approach = Growth(_APPROACH_STEP)
        self._has_reached = False
        self._subgoal: FloatArray | None = None
        self._focus: FloatArray | None = None
        self._retreat: FloatArray | None = None

    def move(self, grid: Grid, transfer: Transfer) -> None:
        """Go on on a grid of another extent; what is remembered are points, and stays."""
        self._grid = grid
        self._surveyor = FrontierSurveyor(self._configuration, grid, self._strategy.traits)
        self._chooser.move(grid, transfer)

    @property
    def subgoal_count(self) -> int:
        """Frontiers chosen since the goal was set."""
        return self._chooser.changes

    def decide(self, scene: Scene) -> tuple[Decision, FrontierScores | None]:
        """Return what to do, and the scored frontier where one was looked for."""
        self._take_goal(scene.goal)
        refusal = self._refuse(scene)
        if refusal is not None:
            return refusal, None
        self._note_reached(scene)
        region = scene.region
        lasted = self._without_region.duration(region is None, scene.now)
        if region is None:
            if self._has_reached:
                return Decision(state=PlannerState.REACHED), None
            return verdicts.without_region(scene, lasted, self._configuration), None
        known = self._known_way(scene, region)
        if known is not None:
            self._chooser.cell = None
            self._without_frontier.duration(False, scene.now)
            return known, None
        survey = self._surveyor.survey(scene, region, self._memory)
        return self._seek(scene, region, survey), survey.scores

    def _take_goal(self, goal: FloatArray | None) -> None:
        """Start afresh when the goal is another one."""
        both_none = goal is None and self._goal is None
        if not both_none and (goal is None or self._goal is None
                              or not np.array_equal(goal, self._goal)):
            self._begin(goal)

    def _refuse(self, scene: Scene) -> Decision | None:
        if scene.goal is None or self._has_reached:
            return None
        lower = scene.bounds.lower
        if not self._strategy.traits.is_certified:
            lower = np.full_like(lower, -np.inf)
        refusal = refuse_goal(scene.goal, self._grid, scene.admissible, lower,
                              self._configuration.slip_threshold,
                              self._configuration.goal_tolerance)
        return None if refusal is None else verdicts.refused(refusal)

    def _note_reached(self, scene: Scene) -> None:
        if scene.goal is not None:
            away = float(np.hypot(*(scene.goal - scene.position)))
            self._has_reached |= away <= self._configuration.goal_tolerance

    def _known_way(self, scene: Scene, region: Region) -> Decision | None:
        """Return the decision where no frontier is needed: back to safety, or to the goal."""
        if scene.is_lost:
            return self._lead_back(scene, region)
        self._retreat = None
        if not self._strategy.traits.is_certified and not self._has_reached:
            return verdicts.naive(scene.goal)
        if scene.goal is None:
            return None
        subgoal, moved = self._placement.place(region.polygon, scene.goal)
        allowed = _GOAL_SHARE * self._configuration.goal_tolerance
        if not self._has_reached and moved > allowed:
            return None
        state = PlannerState.REACHED if self._has_reached else PlannerState.TO_GOAL
        return Decision(state=state, subgoal=subgoal, subgoal_is_goal=True,
                        subgoal_note=_note(moved, 'goal'))

    def _lead_back(self, scene: Scene, region: Region) -> Decision:
        """Retreat to one point for as long as it stays in the region."""
        if self._retreat is None or self._placement.place(region.polygon, self._retreat)[1] > 0.0:
            self._retreat, _ = self._placement.place(region.polygon, scene.position)
        return verdicts.lost(scene, self._retreat)

    def _seek(self, scene: Scene, region: Region, survey: Survey) -> Decision:
        has_arrived = self._is_at(scene.position, self._subgoal)
        cell = self._chooser.choose(survey.scores, scene.component, has_arrived)
        lasted = self._without_frontier.duration(cell is None, scene.now)
        if cell is None:
            return self._without_choice(scene, lasted, survey)
        focus = self._grid.point_of(cell)
        if self._focus is None or not np.array_equal(focus, self._focus):
            self._approach.reset()
        self._focus = focus
        self._subgoal, moved = self._placement.place(region.polygon, focus)
        is_there = self._is_at(scene.position, self._subgoal)
        self._remember(scene, cell, focus, is_there)
        decision = Decision(state=PlannerState.SEEKING, subgoal=self._subgoal, focus=focus,
                            march=is_there, subgoal_note=_note(moved, 'frontier'),
                            cause=_search_cause(survey))
        return self._with_patience(scene, decision)

    def _without_choice(self, scene: Scene, lasted: float, survey: Survey) -> Decision:
        """Say that no frontier is left; with a goal, first try again those that were set aside.

        Waiting for the end of their rest would win nothing. A search that only repeats itself is
        ended by `patience`, which goes on counting.
        """
        is_resting = bool(self._memory.is_resting(survey.scores.points, scene.now).any())
        if is_resting and scene.goal is not None:
            self._memory.wake()
        self._subgoal = None
        decision = verdicts.nothing_left(scene, lasted, is_resting, survey.is_goal_cut_off,
                                         self._configuration)
        return self._with_patience(scene, decision)

    def _is_at(self, position: FloatArray, subgoal: FloatArray | None) -> bool:
        return (subgoal is not None
                and math.dist(subgoal, position) <= self._configuration.arrival_distance)

    def _remember(self, scene: Scene, cell: Integers, focus: FloatArray, is_there: bool) -> None:
        """Tell the memory of a stay at the frontier, or of a way there that leads nowhere."""
        if not self._strategy.traits.rests_frontiers or self._subgoal is None:
            return
        if is_there:
            self._approach.reset()
            radius = round((self._configuration.sensing_reach / self._grid.resolution) ** 2)
            nearby = count_in_discs(scene.certified, cell[None, :], np.array([radius]))
            self._memory.note_stay(focus, int(nearby[0]), scene.now)
            return
        away = math.dist(self._subgoal, scene.position)
        if self._approach.time_without(-away, scene.now) > self._configuration.approach_time:
            self._memory.set_aside(focus, scene.now)

    def give_up(self, subgoal: FloatArray, now: float) -> bool:
        """Set a subgoal (2,) [m] aside that the robot cannot get to; return whether it is sought.

        The goal itself is never set aside.
        """
        if (self._subgoal is None or self._focus is None
                or np.hypot(*(self._subgoal - subgoal)) > _SAME_SUBGOAL):
            return False
        self._memory.set_aside(self._focus, now)
        return True

    def _with_patience(self, scene: Scene, decision: Decision) -> Decision:
        """Report a search that goes on without winning ground."""
        area = float(scene.component.sum()) * self._grid.cell_area
        lasted = self._area_growth.time_without(area, scene.now)
        is_over = decision.state is not PlannerState.SEEKING
        if is_over or lasted <= self._configuration.patience:
            return decision
        is_explored = scene.goal is None and self._memory.only_in_vain_since(scene.now - lasted)
        return verdicts.without_growth(decision, lasted, is_explored)


def _note(moved: float, what: str) -> str:
    if moved <= 0.0:
        return ''
    return f'moved {moved:.2f} m from the {what} into the region that can be steered in'


def _search_cause(survey: Survey) -> str:
    if survey.is_goal_cut_off:
        return ('no way to the goal is left through ground that may be safe; '
                'winning ground elsewhere')
    return ''
