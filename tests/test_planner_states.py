# SPDX-License-Identifier: Apache-2.0
"""The planner always has a state, a reason and, where it can, a subgoal inside the region."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from psane_mapping.grid import Grid
from psane_planner.configuration import CERTIFICATIONS, STRATEGIES, PlannerConfiguration
from psane_planner.discs import count_in_discs, squared_radii, union_of_discs
from psane_planner.errors import MapError, PlannerError, PoseError
from psane_planner.geodesic import _reach_out, _solve
from psane_planner.planner import SafePlanner
from psane_planner.status import PlannerState as State

GRID = Grid.over_workspace(0.0, 0.0, 6.0, 5.0, 0.1)
UNKNOWN = (np.zeros(GRID.shape), np.full(GRID.shape, 0.5))
X, Y = np.meshgrid(GRID.x, GRID.y)


def felt(*discs, slip=0.1):
    """Return mean and std of a map that knows the ground within discs (x, y, radius)."""
    mean, std = (array.copy() for array in UNKNOWN)
    for x, y, radius in discs:
        inside = np.hypot(X - x, Y - y) <= radius
        mean[inside], std[inside] = slip, 0.05
    return mean, std


def pose(x, y, yaw=0.0):
    return np.array((x, y, yaw))


def planner_of(**details):
    return SafePlanner(PlannerConfiguration(**details), GRID)


def test_without_map_or_pose_the_planner_waits():
    planner = planner_of()
    for plan in (planner.update(None, None, pose(2, 2), None, 0.0),
                 planner.update(*UNKNOWN, None, None, 0.0)):
        assert plan.state is State.WAITING and plan.cause and plan.remedy
        assert plan.subgoal is None and plan.region is None


def test_a_map_without_estimates_certifies_nothing():
    empty = np.full(GRID.shape, np.nan)
    plan = planner_of().update(empty, empty, pose(2, 2), None, 0.0)
    assert not plan.certified.any() and plan.march


def test_with_nothing_certified_the_robot_marches_and_says_so_when_that_does_not_help():
    planner = planner_of()
    states = [planner.update(*UNKNOWN, pose(2, 2), np.array((4.0, 3.0)), t)
              for t in (0.0, 14.9, 15.1)]
    assert [plan.state for plan in states] == [State.SEEKING, State.SEEKING, State.STALLED]
    assert all(plan.march and plan.cause for plan in states) and states[-1].remedy


def test_ground_too_narrow_to_steer_in_is_felt_on_the_spot():
    plan = planner_of().update(*felt((2, 2, 0.12)), pose(2, 2), None, 0.0)
    assert plan.state is State.SEEKING and plan.march and 'narrow' in plan.cause
    assert plan.certified.any() and plan.region is None


def test_a_goal_in_the_region_is_gone_to_and_reached_for_good():
    planner, ground, goal = planner_of(), felt((2, 2, 1.5)), np.array((2.9, 2.0))
    plan = planner.update(*ground, pose(2, 2), goal, 0.0)
    assert plan.state is State.TO_GOAL and plan.subgoal_is_goal and not plan.march
    np.testing.assert_allclose(plan.subgoal, goal)
    assert planner.update(*ground, pose(2.61, 2), goal, 1.0).state is State.REACHED
    assert planner.update(*ground, pose(2.3, 2), goal, 2.0).state is State.REACHED
    other = planner.update(*ground, pose(2.3, 2), np.array((1.4, 2.0)), 3.0)
    assert other.state is State.TO_GOAL


def test_a_goal_just_outside_the_region_is_gone_to_from_inside_with_a_reason():
    plan = planner_of().update(*felt((2, 2, 1.0)), pose(2, 2), np.array((2.88, 2.0)), 0.0)
    assert plan.state is State.TO_GOAL and 'moved' in plan.subgoal_note
    assert plan.region.contains(shapely.Point(plan.subgoal))
    assert np.hypot(*(plan.subgoal - plan.goal)) <= 0.15


@pytest.mark.parametrize(('goal', 'word'), [
    ((7.0, 2.0), 'outside'), ((5.85, 2.0), 'border'), ((3.0, 4.0), 'keep-out')])
def test_a_goal_that_cannot_be_certified_is_refused_with_the_nearest_that_can(goal, word):
    keep_out = np.zeros(GRID.shape, bool)
    keep_out[35:45, 25:35] = True
    planner = planner_of()
    plan = planner.update(*felt((2, 2, 1.0)), pose(2, 2), np.array(goal), 0.0, keep_out)
    assert plan.state is State.STALLED and word in plan.cause and 'nearest is' in plan.remedy
    named = np.array([float(part) for part in plan.remedy.split('(')[1].split(')')[0].split(',')])
    again = planner.update(*felt((2, 2, 1.0)), pose(2, 2), named, 0.2, keep_out)
    assert again.state in (State.SEEKING, State.TO_GOAL)


def test_a_goal_in_ground_known_to_be_unsafe_is_refused():
    mean, std = felt((2, 2, 1.0))
    soft = np.hypot(X - 4, Y - 3) < 0.8
    mean[soft], std[soft] = 0.9, 0.05
    plan = planner_of().update(mean, std, pose(2, 2), np.array((4.0, 3.0)), 0.0)
    assert plan.state is State.STALLED and 'unsafe' in plan.cause


def test_an_unknown_goal_is_sought_along_the_frontier():
    plan = planner_of().update(*felt((2, 2, 1.0)), pose(2, 2), np.array((4.5, 2.0)), 0.0)
    assert plan.state is State.SEEKING and not plan.subgoal_is_goal
    assert plan.frontier_count > 10 and plan.subgoal_count == 1
    assert plan.subgoal[0] > 2.5 and abs(plan.subgoal[1] - 2.0) < 0.3
    assert plan.focus[0] > plan.subgoal[0] and 'moved' in plan.subgoal_note


def test_at_a_subgoal_that_is_not_the_goal_the_robot_marches():
    planner, ground, goal = planner_of(), felt((2, 2, 1.0)), np.array((4.5, 2.0))
    first = planner.update(*ground, pose(2, 2), goal, 0.0)
    there = planner.update(*ground, pose(*first.subgoal), goal, 1.0)
    assert not first.march and there.march


def visit_all(planner, ground, goal, duration):
    """Put the robot on each subgoal at once; return focus and plan of every cycle."""
    plan, plans = planner.update(*ground, pose(2, 2), goal, 0.0), []
    for tick in range(round(2 * duration)):
        where = pose(2, 2) if plan.subgoal is None else pose(*plan.subgoal)
        plan = planner.update(*ground, where, goal, 0.5 * (tick + 1))
        plans.append(plan)
    return plans


def test_frontiers_visited_in_vain_are_set_aside_and_then_tried_again_until_patience_ends():
    plans = visit_all(planner_of(patience=300.0, rest_time=1000.0), felt((2, 2, 1.0)),
                      np.array((4.5, 2.0)), 320.0)
    pauses = [k for k, plan in enumerate(plans) if plan.subgoal is None]
    assert pauses and 'in vain' in plans[pauses[0]].cause
    tried = {tuple(plan.focus) for plan in plans[:pauses[0]]}
    assert len(tried) > 3, 'other frontiers are tried'
    assert plans[pauses[0] + 1].subgoal is not None, 'with a goal nothing is waited for'
    assert all(plan.state is State.SEEKING for plan in plans[:590])
    assert plans[-1].state is State.STALLED and 'has not grown' in plans[-1].cause


def test_exploring_ends_when_every_frontier_was_visited_in_vain():
    plans = visit_all(planner_of(patience=3000.0, rest_time=1000.0), felt((2, 2, 1.0)), None,
                      320.0)
    assert plans[-1].state is State.EXPLORED and 'in vain' in plans[-1].cause


def test_exploring_that_wins_nothing_more_ends_as_explored_where_frontiers_were_reached():
    plans = visit_all(planner_of(patience=60.0), felt((2, 2, 1.0)), None, 70.0)
    assert all(plan.state is State.SEEKING for plan in plans[:110])
    assert plans[-1].state is State.EXPLORED and 'visited in vain' in plans[-1].cause


def test_exploring_stalls_where_the_robot_gets_to_no_frontier():
    planner, ground = planner_of(patience=60.0), felt((2, 2, 1.0))
    plans = [planner.update(*ground, pose(2, 2), None, float(t)) for t in range(70)]
    assert plans[-1].state is State.STALLED and 'has not grown' in plans[-1].cause


def test_a_subgoal_that_is_never_approached_is_set_aside():
    planner, ground, goal = planner_of(), felt((2, 2, 1.0)), np.array((4.5, 2.0))
    plans = [planner.update(*ground, pose(2, 2), goal, float(t)) for t in range(40)]
    assert np.hypot(*(plans[0].focus - plans[-1].focus)) > 0.3


def closed_ground():
    """Certified ground within a ring that is known to be unsafe."""
    mean, std = np.full(GRID.shape, 0.9), np.full(GRID.shape, 0.02)
    inside = np.hypot(X - 2, Y - 2) <= 1.0
    mean[inside] = 0.1
    return mean, std


def test_exploring_ends_when_no_frontier_can_grow():
    planner = planner_of()
    plans = [planner.update(*closed_ground(), pose(2, 2), None, t) for t in (0.0, 2.9, 3.1)]
    assert [p.state for p in plans] == [State.SEEKING, State.SEEKING, State.EXPLORED]
    assert plans[0].march and plans[-1].cause


def test_a_goal_behind_unsafe_ground_stalls_with_cause_and_remedy():
    planner = planner_of()
    mean, std = closed_ground()
    mean[:, 45:], std[:, 45:] = 0.0, 0.5
    for t in (0.0, 3.1):
        plan = planner.update(mean, std, pose(2, 2), np.array((5.0, 2.0)), t)
    assert plan.state is State.STALLED and 'slip_threshold' in plan.remedy
    assert 'no frontier is left' in plan.cause


def test_a_search_that_wins_no_ground_is_reported():
    planner, ground = planner_of(patience=20.0, strategy='sgh'), felt((2, 2, 1.0))
    states = [planner.update(*ground, pose(2, 2), np.array((4.5, 2.0)), float(t))
              for t in range(0, 30, 2)]
    assert states[5].state is State.SEEKING
    assert states[-1].state is State.STALLED and 'has not grown' in states[-1].cause
    assert states[-1].subgoal is not None


def test_a_robot_outside_is_led_back_and_the_state_does_not_flicker():
    planner, ground = planner_of(), felt((2, 2, 1.0))
    planner.update(*ground, pose(2, 2), None, 0.0)
    states, targets = [], []
    for now, x in enumerate((3.2, 3.45, 3.3, 3.2, 3.0), start=1):
        plan = planner.update(*ground, pose(x, 2), None, float(now))
        states.append(plan.state)
        targets.append(plan.subgoal)
    assert states == [State.SEEKING, State.LOST, State.LOST, State.LOST, State.SEEKING]
    # One target for the whole way back.
    np.testing.assert_array_equal(targets[1], targets[3])
    assert targets[1][0] < 2.9 and 'outside' in planner.update(
        *ground, pose(3.6, 2), None, 9.0).cause


def test_a_revoked_certificate_is_followed_by_a_way_back():
    planner = planner_of()
    planner.update(*felt((2, 2, 1.0), (3.2, 2, 1.0)), pose(3.8, 2), None, 0.0)
    mean, std = felt((2, 2, 1.0))
    soft = np.hypot(X - 2, Y - 2) > 1.0
    mean[soft], std[soft] = 0.8, 0.02
    plan = planner.update(mean, std, pose(3.8, 2), None, 1.0)
    assert plan.interval_resets > 0 and plan.state is State.LOST
    assert plan.region.contains(shapely.Point(plan.subgoal))


def test_ngh_goes_straight_to_the_goal_over_anything():
    plan = planner_of(strategy='ngh').update(*UNKNOWN, pose(2, 2), np.array((4.5, 2.0)), 0.0)
    assert plan.state is State.TO_GOAL
    np.testing.assert_array_equal(plan.subgoal, (4.5, 2.0))
    assert plan.region.contains(shapely.Point(plan.subgoal))
    aimless = planner_of(strategy='ngh').update(*UNKNOWN, pose(2, 2), None, 0.0)
    assert aimless.state is State.STALLED and 'needs a goal' in aimless.cause


@pytest.mark.parametrize('certification', CERTIFICATIONS)
@pytest.mark.parametrize('strategy', [name for name in STRATEGIES if name != 'ngh'])
@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), explores=st.booleans())
def test_a_subgoal_always_lies_inside_the_region_and_a_trouble_has_a_cause(
        strategy, certification, seed, explores):
    draw = np.random.default_rng(seed)
    planner = planner_of(strategy=strategy, certification=certification)
    goal = None if explores else draw.uniform((0, 0), (6, 5))
    for step in range(6):
        field = ndimage.gaussian_filter(draw.normal(size=GRID.shape), 4.0)
        mean = 0.3 + 3.0 * field
        std = np.full(GRID.shape, draw.uniform(0.01, 0.15))
        mean[draw.uniform(size=GRID.shape) < 0.02] = np.nan
        plan = planner.update(mean, std, pose(*draw.uniform((0, 0), (6, 5))), goal, 0.7 * step)
        if plan.subgoal is not None:
            point = shapely.Point(plan.subgoal)
            assert plan.region.contains(point)
            if not plan.region.buffer(-0.0101).is_empty:
                # A region nowhere 2 cm wide has no point that far inside.
                assert plan.region.boundary.distance(point) >= 0.01 - 1e-6
        if plan.state in (State.STALLED, State.LOST):
            assert plan.cause and plan.remedy
        if plan.state is State.SEEKING:
            assert plan.march or plan.subgoal is not None
        assert not (plan.component & ~plan.certified).any()


@pytest.mark.parametrize(('arguments', 'error', 'word'), [
    ((np.zeros((3, 3)), np.zeros((3, 3)), pose(2, 2), None, 0.0), MapError, 'shape'),
    ((*UNKNOWN, pose(math.nan, 2), None, 0.0), PoseError, 'pose'),
    ((*UNKNOWN, np.zeros(2), None, 0.0), PoseError, 'pose'),
    ((*UNKNOWN, pose(2, 2), np.array((math.inf, 0.0)), 0.0), PoseError, 'goal'),
    ((*UNKNOWN, pose(2, 2), None, math.nan), PoseError, 'now'),
    ((*UNKNOWN, pose(2, 2), None, 0.0, np.zeros((3, 3), bool)), MapError, 'keep_out')])
def test_an_argument_that_means_nothing_is_refused_and_changes_nothing(arguments, error, word):
    planner = planner_of()
    with pytest.raises(error, match=word) as refused:
        planner.update(*arguments)
    assert isinstance(refused.value, PlannerError)
    good = planner.update(*felt((2, 2, 1.0)), pose(2, 2), None, 1.0)
    assert good.state is State.SEEKING and good.total_interval_resets == 0


def test_the_same_input_gives_the_same_plans():
    def plans():
        planner = planner_of()
        return [planner.update(*felt((2, 2, 0.8 + 0.1 * k)), pose(2, 2), np.array((4.5, 3.0)),
                               0.5 * k) for k in range(6)]
    for first, second in zip(plans(), plans(), strict=True):
        assert first.state is second.state and first.region.equals(second.region)
        np.testing.assert_array_equal(first.subgoal, second.subgoal)


def test_a_robot_without_a_task_is_asked_for_nothing():
    plan = planner_of().idle(3.0)
    assert plan.state is State.WAITING and 'no task' in plan.cause and plan.now == 3.0
    assert plan.subgoal is None and plan.region is None and not plan.march


def test_warming_up_compiles_all_loops_of_a_cycle_and_leaves_no_trace():
    loops = (squared_radii, union_of_discs, count_in_discs, _solve, _reach_out)
    planner = planner_of(certification='lipschitz')
    planner.warm_up()
    compiled = [len(loop.signatures) for loop in loops]
    assert all(compiled)
    fresh = planner_of(certification='lipschitz')
    for now in (0.0, 1.0):
        first = planner.update(*felt((2, 2, 1.0)), pose(2, 2), np.array((4.5, 2.0)), now)
        second = fresh.update(*felt((2, 2, 1.0)), pose(2, 2), np.array((4.5, 2.0)), now)
        np.testing.assert_array_equal(first.certified, second.certified)
        np.testing.assert_array_equal(first.subgoal, second.subgoal)
    assert [len(loop.signatures) for loop in loops] == compiled


def test_a_new_threshold_holds_at_once_and_keeps_what_is_known():
    planner, ground = planner_of(), felt((2, 2, 1.0), slip=0.3)
    planner.update(*ground, pose(2, 2), None, 0.0)
    planner.reconfigure(PlannerConfiguration(slip_threshold=0.35))
    assert not planner.update(*UNKNOWN, pose(2, 2), None, 0.2).certified.any()
    planner.reconfigure(PlannerConfiguration(slip_threshold=0.45))
    # The map of this cycle is too vague: only intervals that were kept can certify.
    vague = ground[0], np.maximum(ground[1], 0.09)
    assert planner.update(*vague, pose(2, 2), None, 0.4).certified.any()
    planner.reconfigure(PlannerConfiguration(slip_threshold=0.45, confidence_scale=5.0))
    assert not planner.update(*vague, pose(2, 2), None, 0.6).certified.any()


def test_what_a_plan_holds_cannot_be_changed():
    plan = planner_of().update(*felt((2, 2, 1.0)), pose(2, 2), None, 0.0)
    for array in (plan.certified, plan.component, plan.lower, plan.upper):
        with pytest.raises(ValueError, match='read-only'):
            array[0, 0] = 1


def test_with_the_footprint_in_mind_no_foot_leaves_certified_ground_at_any_heading():
    ground, goal = felt((2, 2, 1.0)), np.array((4.5, 2.0))
    narrow, wide = (planner_of(footprint_aware=aware).update(*ground, pose(2, 2), goal, 0.0)
                    for aware in (False, True))
    assert wide.region.area < narrow.region.area
    reach = PlannerConfiguration().footprint_radius
    outline = np.asarray(wide.region.exterior.coords)
    around = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    feet = (outline[:, None, :] + reach * np.stack((np.cos(around), np.sin(around)), axis=1)
            ).reshape(-1, 2)
    cells = GRID.index_of(feet)
    assert wide.certified[cells[:, 0], cells[:, 1]].all()
    # The point that is steered to counts the same way.
    assert wide.region.contains(shapely.Point(*wide.subgoal))


def test_on_ground_with_slip_just_below_the_threshold_the_search_goes_on_cell_by_cell():
    mean, std = felt((2, 2, 1.0), slip=0.42)
    std[mean == 0.42] = 0.03
    planner = planner_of()
    plan = planner.update(mean, std, pose(2, 2), np.array((4.5, 2.0)), 0.0)
    # The cones of Algorithm 1 are smaller than a cell here, and the paper's strategy is at an end.
    assert plan.state is State.SEEKING and plan.subgoal is not None and plan.frontier.pareto.any()
    paper = planner_of(strategy='psane').update(mean, std, pose(2, 2), np.array((4.5, 2.0)), 0.0)
    assert paper.subgoal is None and not paper.frontier.eligible.any()


def test_a_passage_just_below_the_threshold_is_a_frontier_to_go_to():
    """No cone of lipschitz_constant leaves its cell there, yet the next cell is likely safe."""
    mean, std = np.full(GRID.shape, 0.42), np.full(GRID.shape, 0.06)
    near = np.hypot(X - 2.0, Y - 2.0) <= 0.8
    mean[near], std[near] = 0.40, 0.02
    plan = planner_of().update(mean, std, pose(2, 2), np.array((5.0, 4.0)), 0.0)
    assert plan.state is State.SEEKING and plan.certified.any()
    on_edge = plan.frontier.cells
    cone = squared_radii(plan.lower[on_edge[:, 0], on_edge[:, 1]], 0.5, 2.0, 0.1, 10**6)
    assert (cone < 1).any() and (plan.frontier.growth > 1.0).all()
