# SPDX-License-Identifier: Apache-2.0
"""The small parts of a run: watchdog, pace, instants, truth log, score, summary, progress."""

import io
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from psane_mapping.grid import Grid
from psane_sim.pacing import LARGEST_BURST, Pacer
from psane_sim.progress import Progress, ProgressLine
from psane_sim.robot.feed_forward import Sweep
from psane_sim.runs.scoring import Scorer, reachable_safe_cells
from psane_sim.runs.summary import Ending, Outcome, Task, is_success, summarise, write_summary
from psane_sim.runs.truth_log import TruthEntry, TruthLog, TruthLogError, read_truth
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.touch.instant import LONGEST_WAIT, InstantCollector
from psane_sim.touch.sensing import ImuSample, JointSample, WrenchSample
from psane_sim.watchdog import CommandWatchdog

GRID = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1)


# --- watchdog and pace

def test_a_command_is_obeyed_until_it_is_too_old():
    watchdog = CommandWatchdog(0.3)
    assert watchdog.command(0.0) == (0.0, 0.0)
    watchdog.take(0.2, 0.1, 1.0)
    assert watchdog.command(1.29) == (0.2, 0.1)
    assert watchdog.command(1.31) == (0.0, 0.0)
    assert watchdog.is_silent(1.31)


@given(st.lists(st.floats(0.0, 0.2), min_size=1, max_size=60), st.floats(0.1, 10.0))
def test_simulated_time_never_runs_ahead_of_the_pace(waits, pace):
    pacer, wall, simulated = Pacer(pace, 0.0), 0.0, 0.0
    for wait in waits:
        wall += wait
        due = pacer.due(wall, simulated, 0.005)
        assert 0 <= due <= LARGEST_BURST
        simulated += 0.005 * due
        assert simulated <= wall * pace + 1e-6


def test_a_machine_that_keeps_up_keeps_the_pace():
    pacer, simulated = Pacer(2.0, 100.0), 0.0
    for tick in range(1, 2001):
        simulated += 0.005 * pacer.due(100.0 + 0.002 * tick, simulated, 0.005)
    assert simulated == pytest.approx(8.0, abs=0.01)


# --- instants

def samples(time):
    return (JointSample(time, *np.zeros((3, 6))), WrenchSample(time, *np.zeros((2, 6, 3))),
            ImuSample(time, np.array([0.0, 0.0, 0.0, 1.0]), *np.zeros((2, 3))))


def test_only_measurements_of_one_instant_are_put_together():
    collector = InstantCollector()
    (joints, wrenches, _), (_, _, imu) = samples(1.0), samples(1.005)
    collector.joints(joints)
    collector.wrenches(wrenches)
    collector.imu(imu)
    assert not list(collector.whole())
    collector.imu(samples(1.0)[2])
    assert [parts[0].time for parts in collector.whole()] == [1.0]


def test_an_instant_that_stays_incomplete_is_given_up_and_counted():
    collector = InstantCollector()
    for tick in range(LONGEST_WAIT + 5):
        collector.joints(samples(0.005 * tick)[0])
        assert not list(collector.whole())
    assert collector.incomplete == 5


# --- truth log

def entry(time, x=2.0, feet=None):
    feet = np.full((6, 2), np.nan) if feet is None else feet
    return TruthEntry(time=time, pose=np.array([x, 5.0, 0.1]), speed=0.2, feet=feet,
                      sweep=Sweep(0.5, -0.25, 1.0, -1.0))


def test_a_truth_log_comes_back_and_a_torn_last_line_is_left_out(tmp_path):
    path = tmp_path / 'truth.csv'
    log = TruthLog(path)
    log.write(entry(0.05))
    log.write(entry(0.10, x=2.5))
    log.close()
    with path.open('a') as file:
        file.write('0.15,2.')
    back = read_truth(path)
    assert [part.time for part in back] == [0.05, 0.1]
    assert back[1].pose[0] == 2.5
    assert back[1].sweep == entry(0.1).sweep
    assert len(back[0].grounded_feet) == 0


def test_another_file_is_not_taken_for_a_truth_log(tmp_path):
    path = tmp_path / 'other.csv'
    path.write_text('a,b\n1,2\n')
    with pytest.raises(TruthLogError, match='is not a truth log'):
        read_truth(path)


# --- score

@pytest.fixture(scope='module')
def env1():
    return load_terrain('env1')


def scorer_of(terrain):
    return Scorer(terrain, GRID, np.array(terrain.start), 0.5)


def test_time_on_unsafe_ground_is_counted_for_the_centre_and_for_feet(env1):
    scorer, soft, firm = scorer_of(env1), np.array([3.75, 3.75]), np.array([2.0, 5.0])
    scorer.observe(firm, np.array([firm, soft]), 0.05)
    scorer.observe(soft, np.array([firm, firm]), 0.05)
    score = scorer.score()
    assert score.unsafe_time_s == pytest.approx(0.05)
    assert score.unsafe_foot_share == pytest.approx(0.25)


def test_a_false_certificate_is_remembered_after_it_was_taken_back(env1):
    scorer = scorer_of(env1)
    wrong = np.zeros(GRID.shape, bool)
    wrong[tuple(GRID.index_of(np.array([3.75, 3.75])))] = True
    scorer.certified(wrong)
    scorer.certified(np.zeros(GRID.shape, bool))
    assert scorer.score().false_certified_cells == 1
    assert scorer.score().certified_cells == 0


def test_all_safe_ground_is_full_coverage(env1):
    scorer = scorer_of(env1)
    scorer.certified(reachable_safe_cells(env1, GRID, np.array(env1.start), 0.5))
    score = scorer.score()
    assert score.coverage == 1.0
    assert score.false_certified_cells == 0


def test_the_sway_of_a_stride_adds_no_length(env1):
    scorer = scorer_of(env1)
    for tick in range(1000):
        scorer.observe(np.array([2.0, 5.0 + 0.02 * math.sin(tick)]), np.empty((0, 2)), 0.05)
    assert scorer.score().path_m == 0.0


# --- summary and progress

TASK = Task(terrain='env1', start=(2.0, 5.0), goal=(7.0, 1.5), strategy='psane_geodesic',
            threshold=0.5, seed=0, duration=300.0)


def outcome_of(ending):
    return Outcome(ending=ending, cause='', time=10.0, subgoals=3, contacts=40, wall=2.0)


@pytest.mark.parametrize('ending', Ending)
def test_only_the_goal_reached_without_unsafe_time_is_success(env1, ending):
    scorer = scorer_of(env1)
    assert is_success(TASK, outcome_of(ending), scorer.score()) == (ending is Ending.REACHED)
    scorer.observe(np.array([3.75, 3.75]), np.empty((0, 2)), 0.05)
    assert not is_success(TASK, outcome_of(ending), scorer.score())


def test_a_summary_is_written_whole(env1, tmp_path):
    summary = summarise(TASK, outcome_of(Ending.STALLED), scorer_of(env1).score())
    write_summary(summary, tmp_path / 'summary.json')
    assert json.loads((tmp_path / 'summary.json').read_text())['reason'] == 'STALLED'
    assert summary['timing']['real_time_factor'] == 5.0
    assert [path.name for path in tmp_path.iterdir()] == ['summary.json']


def test_progress_off_a_terminal_is_a_line_now_and_then_and_at_each_new_state():
    stream = io.StringIO()
    line = ProgressLine(stream, every=5.0)
    for tick in range(100):
        state = 'SEEKING' if tick < 73 else 'TO_GOAL'
        line.show(Progress(time=0.1 * tick, distance=1.0, area=2.0, contacts=3, state=state))
    line.close()
    shown = stream.getvalue().splitlines()
    assert len(shown) == 3
    assert 'TO_GOAL' in shown[2]
