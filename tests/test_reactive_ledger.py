# SPDX-License-Identifier: Apache-2.0
"""A long measurement that was broken off goes on where it was, and only with the same code."""

import numpy as np

from psane_reactive import ledger as ledger_file
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.ledger import Ledger
from psane_reactive.trials import obstacle_trials, run_trials


def test_results_are_read_back_but_for_a_line_that_was_cut_off(tmp_path):
    path = tmp_path / 'deep' / 'results.jsonl'
    first = Ledger(path)
    first.add('part', 'one', {'reached': True})
    first.add('part', 'two', {'reached': False})
    with path.open('a') as file:
        file.write('{"part": "part", "tri')
    second = Ledger(path)
    assert len(second) == 2
    assert second.row('part', 'one')['reached'] and not second.row('part', 'two')['reached']
    assert second.row('other', 'one') is None


def test_results_of_other_code_are_not_used(tmp_path, monkeypatch):
    path = tmp_path / 'results.jsonl'
    Ledger(path).add('part', 'one', {'reached': True})
    monkeypatch.setattr(ledger_file, 'fingerprint', lambda: 'another')
    assert len(Ledger(path)) == 0
    assert len(path.read_text().splitlines()) == 1


def test_a_drive_in_the_ledger_is_not_made_again_and_counts_the_same(tmp_path):
    trials = list(obstacle_trials(3, seed=8))
    settings = ReactiveConfiguration()
    path = tmp_path / 'results.jsonl'
    ledger = Ledger(path)
    before = run_trials(trials[:2], settings, 0.05, ledger, 'part')
    assert (before.drives, before.reached) == (2, 2)
    # Were it driven again, this trial could not be reached.
    spoilt = [trial._replace(goal=np.array((np.nan, 0.0))) for trial in trials[:2]]
    after = run_trials([*spoilt, trials[2]], settings, 0.05, Ledger(path), 'part')
    assert (after.drives, after.reached) == (3, 3)
    assert after.ratios[:2] == before.ratios
