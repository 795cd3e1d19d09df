# SPDX-License-Identifier: Apache-2.0
"""Several robots in one world: room for each other, one clock, one map."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

from psane_mapping.conversions import seconds
from psane_mapping.grid import Grid
from psane_mapping.quality_of_service import DEFAULT, ODOMETRY_INPUT
from psane_planner.status import PlannerState
from psane_sim.demo.command import BAD_ARGUMENT, main
from psane_sim.demo.options import parse
from psane_sim.demo.team_demo import members_of
from psane_sim.pacing import LARGEST_BURST, Follower
from psane_sim.runs.closed_loop import Settings
from psane_sim.runs.neighbours import least_distance, taken_cells
from psane_sim.runs.patience import PATIENCE, Patience
from psane_sim.runs.summary import Ending
from psane_sim.runs.team_loop import TeamLoop

GRID = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1)
inside = st.tuples(st.floats(0.0, 10.0), st.floats(0.0, 10.0))


@settings(deadline=None)
@given(st.lists(inside, min_size=1, max_size=3))
def test_a_cell_is_taken_exactly_when_a_robot_is_nearer_than_the_room_it_needs(places):
    taken = taken_cells(GRID, [np.array(place) for place in places], 0.8).ravel()
    away = np.min([np.hypot(*(GRID.points - place).T) for place in places], axis=0)
    assert (taken == (away < 0.8)).all()


def test_nobody_in_the_way_takes_nothing():
    assert not taken_cells(GRID, []).any()


def test_the_least_distance_is_found_between_the_entries_of_the_logs():
    # They cross at t = 1, where neither log has an entry.
    first = [(0.0, 0.0, 0.0), (2.0, 2.0, 0.0)]
    second = [(0.0, 2.0, 1.0), (0.9, 1.1, 0.55), (2.0, 0.0, 0.0)]
    times = np.linspace(0.0, 2.0, 20001)
    gaps = np.hypot(
        np.interp(times, (0, 2), (0, 2)) - np.interp(times, (0, .9, 2), (2, 1.1, 0)),
        np.interp(times, (0, .9, 2), (1, .55, 0)))
    # Straight between entries, so the ends of the pieces bound it from above.
    assert gaps.min() <= least_distance([first, second]) <= gaps.min() + 0.2
    assert least_distance([first]) == math.inf
    assert least_distance([first, [(0.0, 5.0, 0.0)]]) == pytest.approx(3.0)


@settings(deadline=None)
@given(st.lists(st.floats(0.0, 0.2), min_size=1, max_size=50))
def test_a_follower_never_runs_ahead_and_catches_up(pauses):
    follower, leader, own, step = Follower(0.0), 0.0, 0.0, 0.005
    for pause in pauses:
        leader += pause
        follower.hear(leader)
        steps = follower.due(0.0, own, step)
        assert 0 <= steps <= LARGEST_BURST
        own += steps * step
        assert own <= leader + 1e-6
    while steps := follower.due(0.0, own, step):
        own += steps * step
    assert leader - own < step + 1e-6


def test_a_follower_does_not_go_back_when_an_old_clock_is_heard():
    follower = Follower(0.0)
    follower.hear(1.0)
    follower.hear(0.5)
    assert follower.due(0.0, 0.99, 0.005) == 2


def test_a_robot_that_is_stalled_for_a_while_goes_on_and_one_that_stays_stalled_has_ended():
    patience = Patience()
    assert patience.ending(PlannerState.STALLED, 5.0) is None
    assert patience.ending(PlannerState.SEEKING, 6.0) is None
    assert patience.ending(PlannerState.STALLED, 7.0) is None
    assert patience.ending(PlannerState.STALLED, 7.0 + 0.9 * PATIENCE) is None
    assert patience.ending(PlannerState.STALLED, 7.0 + PATIENCE) is Ending.STALLED
    assert Patience().ending(PlannerState.REACHED, 0.0) is Ending.REACHED


@pytest.mark.parametrize(('arguments', 'sentence'), [
    (['--explore'], 'each robot needs a goal'),
    (['--terrain', 'env2'], 'say where the second robot begins and goes'),
    (['--second', '1', '5', '99', '5'], '--goal 99 5: expected a point in'),
    (['--head-start', '-1'], '--head-start -1: expected a value in'),
])
def test_a_bad_team_gets_a_sentence(arguments, sentence, capsys, tmp_path):
    with pytest.raises(SystemExit) as ended:
        main(['--robots', '2', '--in-process', '--out', str(tmp_path), *arguments])
    assert ended.value.code == BAD_ARGUMENT
    assert sentence in capsys.readouterr().err


def test_the_second_robot_waits_for_its_departure_and_stands_on_what_the_first_one_felt():
    # It begins where the first one begins to walk to, so that the first one's map reaches it.
    members = members_of(parse(['--robots', '2', '--head-start', '2', '--duration', '3',
                                '--second', '3.3', '5', '5', '1.5']))
    first, second = TeamLoop(members, Settings()).run()
    assert first.outcome.ending is Ending.TIMEOUT
    assert first.outcome.time == pytest.approx(3.0, abs=0.01)
    assert second.outcome.time == pytest.approx(1.0, abs=0.01)
    assert len(first.record.contacts) > 5
    start = np.array(second.record.path[0][1:])
    waiting = [np.hypot(*(np.array(entry[1:]) - start)) for entry in second.record.path
               if entry[0] < 2.0]
    assert max(waiting) < 0.02
    assert second.record.slip_std is not None
    assert first.record.slip_std is not None
    # One map for both, at most one plan old; alone the second one would know nothing yet.
    assert second.record.slip_std == pytest.approx(first.record.slip_std, abs=1e-12)
    assert second.record.slip_std.min() < 0.1


def test_a_second_simulator_keeps_step_with_the_clock_of_the_first(start_node, probe):
    probe.listen(Clock, '/clock', DEFAULT)
    probe.listen(Odometry, '/follower/odom', ODOMETRY_INPUT)
    start_node('psane_sim', 'hexapod_sim', '--ros-args', '-r', '__ns:=/follower', '-p',
               'follow_clock:=true')
    probe.until(lambda: probe.node.count_publishers('/follower/odom') == 1)
    assert not probe.heard['/follower/odom']
    # So slow that what is said of one step is heard by all before the next one.
    leader = start_node('psane_sim', 'hexapod_sim', '--ros-args', '-r', '__ns:=/leader', '-p',
                        'pace:=0.05')
    probe.until(lambda: len(probe.heard['/follower/odom']) > 15)
    assert probe.node.count_publishers('/clock') == 1

    def keeps_step():
        behind = (seconds(probe.last('/clock').clock)
                  - seconds(probe.last('/follower/odom').header.stamp))
        return -1e-6 <= behind < 0.02 + 1e-6
    for _ in range(5):
        probe.until(keeps_step)
        probe.spin(0.5)
    leader.stop()

    def is_at_rest():
        before = probe.last('/follower/odom')
        probe.spin(1.0)
        return probe.last('/follower/odom') is before
    probe.until(is_at_rest)
    follower = [seconds(message.header.stamp) for message in probe.heard['/follower/odom']]
    steps = np.array(follower) / 0.02
    assert steps == pytest.approx(np.round(steps), abs=1e-6)
    assert np.diff(follower).min() > 0.0
