# SPDX-License-Identifier: Apache-2.0
"""When an errand of the action ends, and with which code."""

from dataclasses import replace

import numpy as np
import pytest

from psane_mapping.grid import Grid
from psane_planner.configuration import PlannerConfiguration
from psane_planner.navigation import LIMITS, Errand, ErrorCode
from psane_planner.planner import SafePlanner
from psane_planner.status import PlannerState

GRID = Grid.over_workspace(0.0, 0.0, 6.0, 5.0, 0.1)


def plan_in(state, now, **details):
    planner = SafePlanner(PlannerConfiguration(), GRID)
    plan = planner.update(None, None, None, None, 0.0)
    return replace(plan, state=state, now=now, **details)


@pytest.mark.parametrize('state', [PlannerState.REACHED, PlannerState.EXPLORED])
def test_success_ends_an_errand_at_once(state):
    assert Errand(0.0, 0.0).end(plan_in(state, 1.0)).code is ErrorCode.NONE


@pytest.mark.parametrize('state', [PlannerState.SEEKING, PlannerState.TO_GOAL])
def test_an_errand_under_way_goes_on(state):
    errand = Errand(0.0, 0.0)
    assert all(errand.end(plan_in(state, float(now))) is None for now in range(500))


@pytest.mark.parametrize('state', LIMITS)
def test_a_state_that_leads_nowhere_ends_an_errand_when_it_lasts(state):
    limit, code = LIMITS[state]
    errand = Errand(0.0, 0.0)
    assert errand.end(plan_in(state, 10.0)) is None
    assert errand.end(plan_in(state, 10.0 + 0.9 * limit)) is None
    assert errand.end(plan_in(PlannerState.SEEKING, 10.0 + 0.95 * limit)) is None
    assert errand.end(plan_in(state, 10.0 + limit)) is None, 'a break starts the clock anew'
    end = errand.end(plan_in(state, 10.0 + 2.0 * limit, cause='stuck', remedy='dig'))
    assert end.code is code and 'stuck' in end.message and 'dig' in end.message


def test_a_refused_goal_ends_an_errand_at_once_and_names_the_nearest_that_is_not():
    planner = SafePlanner(PlannerConfiguration(), GRID)
    ground = np.zeros(GRID.shape), np.full(GRID.shape, 0.03)
    plan = planner.update(*ground, np.ones(3), np.array((9.0, 1.0)), 0.0)
    end = Errand(0.0, 0.0).end(plan)
    assert end.code is ErrorCode.INVALID_GOAL
    assert 'outside the workspace' in end.message and 'nearest' in end.message


def test_time_and_way_count_from_acceptance():
    errand = Errand(12.0, 3.5)
    assert errand.time(20.0) == 8.0 and errand.walked(5.0) == 1.5


def test_another_strategy_can_be_taken_at_run_time_without_losing_what_is_certified():
    planner = SafePlanner(PlannerConfiguration(), GRID)
    ground = np.zeros(GRID.shape), np.full(GRID.shape, 0.03)
    planner.update(*ground, np.ones(3), np.array((5.0, 4.0)), 0.0)
    planner.reconfigure(replace(planner.configuration, strategy='pgh'))
    plan = planner.update(*ground, np.ones(3), np.array((5.0, 4.0)), 0.2)
    assert plan.strategy == 'pgh' and plan.certified.any()
