# SPDX-License-Identifier: Apache-2.0
"""A map that grows while the robot walks: what was certified, chosen and remembered stays."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.grid import Grid
from psane_planner.configuration import PlannerConfiguration
from psane_planner.planner import SafePlanner
from psane_planner.status import PlannerState
from psane_planner.transfer import transfer_between

SMALL = Grid(origin_x=0.0, origin_y=0.0, resolution=0.1, rows=50, columns=60)
SIDES = st.integers(-20, 20)


def grown(left, down, right, up):
    """Return the small grid with so many cells more (or fewer) on each side."""
    return Grid(origin_x=-0.1 * left, origin_y=-0.1 * down, resolution=0.1,
                rows=50 + down + up, columns=60 + left + right)


def felt(grid, slip=0.1):
    """Return mean and std of a map that knows a disc around (2, 2)."""
    away = np.hypot(*(grid.points - 2.0).T).reshape(grid.shape)
    return (np.where(away <= 1.0, slip, 0.0), np.where(away <= 1.0, 0.05, 0.5))


def planned(planner, grid, now, slip=0.1, goal=(4.5, 2.0)):
    return planner.update(*felt(grid, slip), np.array((2.0, 2.0, 0.0)), np.array(goal), now)


@settings(max_examples=60, deadline=None)
@given(SIDES, SIDES, SIDES, SIDES)
def test_a_number_stays_with_its_place_and_new_cells_get_the_filling(left, down, right, up):
    new = grown(left, down, right, up)
    transfer = transfer_between(SMALL, new)
    numbers = np.arange(SMALL.rows * SMALL.columns).reshape(SMALL.shape)
    moved = transfer.of(numbers, -1)
    points = new.points
    was_there = SMALL.contains(points)
    cells = SMALL.index_of(points[was_there])
    expected = np.full(len(points), -1)
    expected[was_there] = numbers[cells[:, 0], cells[:, 1]]
    np.testing.assert_array_equal(moved.ravel(), expected)


@pytest.mark.parametrize('other', [
    Grid(origin_x=0.05, origin_y=0.0, resolution=0.1, rows=50, columns=60),
    Grid(origin_x=0.0, origin_y=0.0, resolution=0.05, rows=100, columns=120)])
def test_a_grid_with_other_cells_is_not_moved_to(other):
    planner = SafePlanner(PlannerConfiguration(), SMALL)
    assert transfer_between(SMALL, other) is None
    assert not planner.move(other) and planner.grid == SMALL


def test_a_search_goes_on_at_the_same_places_when_the_map_grows():
    planner = SafePlanner(PlannerConfiguration(), SMALL)
    before = planned(planner, SMALL, 0.0)
    large = grown(17, 9, 30, 5)
    assert planner.move(large)
    after = planned(planner, large, 0.2)
    kept = transfer_between(SMALL, large).of(before.certified, False)
    np.testing.assert_array_equal(after.certified, kept)
    np.testing.assert_allclose(after.focus, before.focus, atol=1e-9)
    assert after.subgoal_count == before.subgoal_count
    assert after.region.equals_exact(before.region, 1e-6)


def test_intervals_stay_narrow_when_the_map_grows():
    planner = SafePlanner(PlannerConfiguration(), SMALL)
    narrow = planned(planner, SMALL, 0.0)
    large = grown(10, 10, 10, 10)
    planner.move(large)
    mean, std = felt(large)
    wider = planner.update(mean, 1.5 * std, np.array((2.0, 2.0, 0.0)), None, 0.2)
    row, column = large.index_of(np.array((2.0, 2.0)))
    assert wider.upper[row, column] == pytest.approx(narrow.upper[row - 10, column - 10])
    assert wider.interval_resets == 0


def test_a_goal_that_was_reached_stays_reached_and_the_motion_s_lesson_is_kept():
    planner = SafePlanner(PlannerConfiguration(), SMALL)
    planned(planner, SMALL, 0.0, goal=(2.1, 2.0))
    lesson = planner.strides
    planner.move(grown(3, 0, 0, 0))
    plan = planned(planner, grown(3, 0, 0, 0), 0.2, goal=(2.1, 2.0))
    assert plan.state is PlannerState.REACHED and planner.strides is lesson


def test_the_old_border_can_be_certified_once_the_map_reaches_beyond_it():
    """A strip along the edge of the workspace is left out, and the edge has moved."""
    config = PlannerConfiguration(border_width=1.5)
    planner = SafePlanner(config, SMALL)
    before = planned(planner, SMALL, 0.0)
    large = grown(20, 20, 20, 20)
    planner.move(large)
    after = planned(planner, large, 0.2)
    assert before.certified.sum() < after.certified.sum()


def test_forgotten_ground_that_is_cut_off_takes_the_choice_with_it():
    planner = SafePlanner(PlannerConfiguration(), SMALL)
    planned(planner, SMALL, 0.0)
    part = grown(0, 0, -35, 0)
    assert planner.move(part)
    plan = planned(planner, part, 0.2, goal=(1.5, 4.0))
    assert plan.certified.shape == part.shape and plan.state is PlannerState.SEEKING
