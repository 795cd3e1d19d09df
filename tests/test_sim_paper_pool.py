# SPDX-License-Identifier: Apache-2.0
"""Workers that die, and how long the rest will take."""

import io
import multiprocessing
import os
import time
from multiprocessing import connection

import pytest
from node_process import PATIENCE

from psane_sim.trials.steady_pool import run_steadily
from psane_sim.trials.work_estimate import WorkBar, WorkEstimate

FATAL = 3


def square(number, shared):
    if number == FATAL:
        os._exit(1)
    return number, number * number + shared


def given_up(number, shared):
    return number, None


def test_a_worker_that_dies_costs_its_own_trial_and_no_other():
    results = dict(run_steadily(square, [1, 2, FATAL, 4, 5], 100, 2, given_up))
    assert results == {1: 101, 2: 104, FATAL: None, 4: 116, 5: 125}


def sleep_long(number, shared):
    if number:
        time.sleep(600.0)
    return number


def test_an_experiment_that_is_broken_off_leaves_no_worker_behind():
    others = set(multiprocessing.active_children())
    results = run_steadily(sleep_long, [0, 1, 2], None, 2, given_up)
    assert next(results) == 0
    workers = set(multiprocessing.active_children()) - others
    assert workers
    results.close()
    # The sentinels: for a moment the pool's own thread alone knows that a child it waited for
    # has ended, and ``is_alive`` is wrong.
    assert all(connection.wait([worker.sentinel], PATIENCE) for worker in workers)


def test_nothing_to_do_starts_no_worker():
    assert list(run_steadily(square, [], 0, 2, given_up)) == []


LONG, BRIEF = ('explore',), ('goal',)


def test_the_work_left_is_weighed_by_kind():
    estimate = WorkEstimate({LONG: 100.0, BRIEF: 10.0}, [LONG, LONG, BRIEF, BRIEF])
    assert estimate.left == pytest.approx(220.0)
    # A brief one takes twice its guess: so will, as far as is known, the long ones.
    estimate.note(BRIEF, 20.0)
    assert estimate.left == pytest.approx(20.0 + 2 * 200.0)
    estimate.note(LONG, 150.0)
    assert estimate.left == pytest.approx(20.0 + 150.0)
    estimate.note(BRIEF, 20.0)
    estimate.note(LONG, 150.0)
    assert estimate.left == 0.0 and estimate.spent == pytest.approx(340.0)


def test_the_bar_says_what_ended_and_how_long_the_rest_takes():
    stream = io.StringIO()
    bar = WorkBar(WorkEstimate({BRIEF: 10.0}, [BRIEF] * 4), 2, stream)
    bar.advance(BRIEF, 60.0, 'first: REACHED')
    text = stream.getvalue()
    assert '1/4' in text and 'about 90 s left' in text and 'first: REACHED' in text
