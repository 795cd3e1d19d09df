# SPDX-License-Identifier: Apache-2.0
"""Close the loop without dynamics: the robot reaches its goal and is never on unsafe ground.

The requirement that these tests defend: success is the goal reached with zero time where the true
slip exceeds the threshold.
"""

import cv2
import numpy as np
import pytest
from planner_worlds import GRID, SlipField, run

from psane_planner.configuration import PlannerConfiguration
from psane_planner.planner import SafePlanner
from psane_planner.status import PlannerState

THRESHOLD = PlannerConfiguration().slip_threshold
START, GOAL = (2.0, 5.0), (7.0, 1.5)


def drive(slip, start, goal, seed, duration=200.0, **details):
    planner = SafePlanner(PlannerConfiguration(**details), GRID)
    return run(planner, slip, start, goal, seed, duration)


@pytest.mark.parametrize('seed', [0, 1])
def test_the_default_crosses_the_smooth_environment_on_safe_ground(seed):
    outcome = drive(SlipField.smooth(), START, GOAL, seed)
    assert outcome.plan.state is PlannerState.REACHED, outcome.plan.cause
    assert outcome.worst_slip <= THRESHOLD and outcome.false_cells == 0
    # The straight line is 6.1 m and unsafe; a prototype with dynamics took 8.3 m.
    assert outcome.length <= 9.0 and outcome.time <= 40.0
    assert PlannerState.LOST not in outcome.states


@pytest.mark.parametrize('details', [
    {'strategy': 'psane'}, {'certification': 'lipschitz'},
    {'strategy': 'pgh', 'monotone': True, 'revocation_scale': 0.0, 'felt_slope': 0.0}])
def test_the_other_ways_of_planning_are_safe_and_arrive_too(details):
    outcome = drive(SlipField.smooth(), START, GOAL, 0, **details)
    assert outcome.plan.state is PlannerState.REACHED, outcome.plan.cause
    assert outcome.worst_slip <= THRESHOLD and outcome.false_cells == 0


def test_without_certification_the_danger_is_real():
    outcome = drive(SlipField.smooth(), START, GOAL, 0, strategy='ngh')
    assert outcome.worst_slip > 0.8


def random_mission(seed):
    """Return a random field and a start and goal on its largest well-connected safe ground."""
    slip = SlipField.random(seed)
    safe = (slip(GRID.points).reshape(GRID.shape) <= 0.3).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(
        cv2.erode(safe, np.ones((7, 7), np.uint8)), connectivity=4)
    cells = np.argwhere(labels == 1 + np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    start, goal = np.random.default_rng(seed).choice(len(cells), 2, replace=False)
    return slip, tuple(GRID.point_of(cells[start])), tuple(GRID.point_of(cells[goal]))


@pytest.mark.parametrize('seed', range(8))
def test_random_missions_on_random_ground_succeed_on_safe_ground(seed):
    slip, start, goal = random_mission(seed)
    outcome = drive(slip, start, goal, seed)
    assert outcome.plan.state is PlannerState.REACHED, outcome.plan.cause
    assert outcome.worst_slip <= THRESHOLD and outcome.false_cells == 0


def test_exploring_wins_ground_safely_and_never_without_a_subgoal_or_a_march():
    outcome = drive(SlipField.smooth(), START, None, 0, duration=60.0)
    assert outcome.plan.certified_area >= 10.0
    assert outcome.worst_slip <= THRESHOLD and outcome.false_cells == 0
    assert set(outcome.states) == {PlannerState.SEEKING}
