# SPDX-License-Identifier: Apache-2.0
"""What the steering cannot reach is set aside by the planner."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from test_planner_states import felt, planner_of, pose

from psane_mapping.errors import MessageError
from psane_planner.conversions import stuck_at_of
from psane_reactive.command import Command, Mode
from psane_reactive.conversions import steering_status_of


def test_a_subgoal_at_which_the_steering_is_stuck_is_set_aside_at_once():
    planner, ground, goal = planner_of(), felt((2, 2, 1.0)), np.array((4.5, 2.0))
    before = planner.update(*ground, pose(2, 2), goal, 0.0)
    assert planner.note_stuck(before.subgoal, 1.0)
    after = planner.update(*ground, pose(2, 2), goal, 1.0)
    assert np.hypot(*(before.focus - after.focus)) > 0.3


@pytest.mark.parametrize('away', [0.05, 3.0])
def test_a_report_about_an_older_subgoal_changes_nothing(away):
    planner, ground, goal = planner_of(), felt((2, 2, 1.0)), np.array((4.5, 2.0))
    before = planner.update(*ground, pose(2, 2), goal, 0.0)
    assert not planner.note_stuck(before.subgoal + (away, 0.0), 1.0)
    after = planner.update(*ground, pose(2, 2), goal, 1.0)
    assert np.array_equal(before.focus, after.focus)


def test_the_goal_itself_is_never_set_aside():
    planner, ground, goal = planner_of(), felt((2, 2, 1.0)), np.array((2.3, 2.0))
    plan = planner.update(*ground, pose(2, 2), goal, 0.0)
    assert plan.subgoal_is_goal
    assert not planner.note_stuck(plan.subgoal, 1.0)
    assert planner.update(*ground, pose(2, 2), goal, 1.0).subgoal_is_goal


def test_the_message_carries_mode_reason_and_place():
    stuck = Command(0.1, 0.0, Mode.STUCK, 'harmonic, yet the robot has been getting nowhere')
    message = steering_status_of(stuck, np.array((1.25, -3.5)), '/reactive_controller')
    assert message.level == DiagnosticStatus.WARN and 'getting nowhere' in message.message
    assert np.array_equal(stuck_at_of(message), (1.25, -3.5))


@pytest.mark.parametrize('mode', [mode for mode in Mode if mode is not Mode.STUCK])
def test_only_a_steering_that_is_stuck_names_a_place_to_give_up(mode):
    message = steering_status_of(Command(0.0, 0.0, mode, ''), np.array((1.0, 2.0)), '')
    assert stuck_at_of(message) is None
    assert message.level == (DiagnosticStatus.WARN if mode is Mode.STOPPED
                             else DiagnosticStatus.OK)


@pytest.mark.parametrize('values', [{}, {'subgoal_x': 'here', 'subgoal_y': '1'},
                                    {'subgoal_x': 'nan', 'subgoal_y': '1'}])
def test_a_report_without_a_usable_place_is_refused(values):
    message = DiagnosticStatus(values=[
        KeyValue(key=key, value=value) for key, value in {'mode': 'stuck', **values}.items()])
    with pytest.raises(MessageError):
        stuck_at_of(message)
