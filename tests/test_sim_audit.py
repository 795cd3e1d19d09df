# SPDX-License-Identifier: Apache-2.0
"""The audit: what it counts, that it goes on where it was broken off, and what it refuses."""

import json

import numpy as np
import pytest

from psane_sim import benchmark
from psane_sim.errors import AuditError
from psane_sim.trials import audit
from psane_sim.trials.audit_page import command_of, write_page
from psane_sim.trials.audit_table import as_markdown, summarise_rows
from psane_sim.trials.audit_trial import BETAS, AuditSettings, Trial, run_trial


def row(family='smooth', seed=0, **changes):
    made = {
        'family': family, 'seed': seed, 'success': True, 'ending': 'REACHED', 'cause': 'done',
        'time_s': 60.0, 'path_m': 9.0, 'unsafe_time_s': 0.0, 'unsafe_foot_share': 0.0,
        'false_certified_cells': 0, 'certified_cells': 1000, 'coverage': 0.3,
        'wall_s': 1.0, 'cpu_s': 1.0, 'is_possible': True, 'margin': 0.15, 'least_length_m': 6.0,
        'least_time_s': 30.0, 'calibration': [(100, 10 - k) for k in range(len(BETAS))]}
    return {**made, **changes}


def test_shares_are_of_the_trials_that_can_be_done():
    table = summarise_rows([
        row(), row(seed=1, success=False, ending='STALLED', time_s=99.0),
        row(seed=2, success=False, ending='TIMEOUT', is_possible=False,
            margin=None, least_length_m=None, least_time_s=None)])
    assert table['all'] == table['smooth']
    assert table['all']['trials'] == 3 and table['all']['possible'] == 2
    assert table['all']['success_share'] == 0.5
    assert table['all']['median_time_ratio'] == 2.0
    assert table['all']['median_length_ratio'] == 1.5
    assert table['all']['endings'] == {'REACHED': 1, 'STALLED': 1, 'TIMEOUT': 1}


def test_unsafe_time_false_cells_and_missing_reasons_are_added_up():
    table = summarise_rows([
        row(unsafe_time_s=1.5, false_certified_cells=4), row(seed=1, cause=''),
        row('patchy', 0, unsafe_time_s=0.5, false_certified_cells=16)])
    assert table['all']['unsafe_time_s'] == 2.0
    assert table['all']['trials_with_unsafe_time'] == 2
    assert table['all']['without_reason'] == 1
    assert table['smooth']['false_certified_share'] == pytest.approx(4 / 2000)
    assert table['all']['false_certified_share'] == pytest.approx(20 / 3000, abs=1e-6)


def test_the_calibration_weighs_cells_and_not_trials():
    heavy = [(900, 90)] * len(BETAS)
    light = [(100, 0)] * len(BETAS)
    shares = summarise_rows([row(calibration=heavy), row(seed=1, calibration=light)])
    assert set(shares['all']['false_share_by_beta'].values()) == {0.09}


def test_a_family_without_a_single_success_still_has_its_line():
    table = summarise_rows([row(success=False, is_possible=False, margin=None)])
    assert table['smooth']['success_share'] is None
    assert '| smooth | 1 | 0 | - |' in as_markdown(table)


def test_trials_take_the_families_in_turn_and_no_terrain_twice():
    trials = audit.trials_of(['smooth', 'patchy', 'corridors'], 8, 5)
    assert len(set(trials)) == 8 and {trial.seed for trial in trials} == {5, 6, 7}
    assert [trial.family for trial in trials[:4]] == ['smooth', 'patchy', 'corridors', 'smooth']


def test_a_trial_is_repeatable_and_can_be_written_as_json():
    settings = AuditSettings(duration=6.0)
    first, second = (run_trial(Trial('smooth', 3), settings) for _ in range(2))
    for result in (first, second):
        result.pop('wall_s'), result.pop('cpu_s')
    assert first == second and first['ending'] == 'TIMEOUT' and first['cause']
    assert json.loads(json.dumps(first))['calibration'] == [list(c) for c in first['calibration']]
    counts = np.array(first['calibration'])
    assert (np.diff(counts[:, 0]) <= 0).all(), 'a wider interval certifies no more'
    assert (counts[:, 1] <= counts[:, 0]).all()


def run(tmp_path, *arguments):
    with pytest.raises(SystemExit) as status:
        benchmark.main(['audit', '--out', str(tmp_path), '--workers', '1', '--duration', '4',
                        '--families', 'smooth', *arguments])
    return status.value.code


def test_an_audit_writes_table_and_figure_and_goes_on_where_it_was_broken_off(tmp_path, capsys):
    assert run(tmp_path, '--trials', '1') == 0
    path = tmp_path / 'trials.jsonl'
    before = path.read_text()
    # A line that was being written when the power went.
    path.write_text(before + '{"settings": "abc", "fam\n')
    assert run(tmp_path, '--trials', '2', '--json') == 0
    captured = capsys.readouterr()
    assert '1 of 2 trials are there already' in captured.err
    assert path.read_text().startswith(before)
    assert json.loads((tmp_path / 'table.json').read_text())['all']['trials'] == 2
    assert (tmp_path / 'audit.png').stat().st_size > 10_000
    assert '| smooth | 2 |' in (tmp_path / 'table.md').read_text()


def test_trials_of_other_settings_are_not_mixed_in(tmp_path, capsys):
    assert run(tmp_path, '--trials', '1') == 0
    assert run(tmp_path, '--trials', '1', '--weaker', '0.2') == 2
    assert 'other settings' in capsys.readouterr().err


@pytest.mark.parametrize('arguments', [
    ('--trials', '0'), ('--trials', '1', '--weaker', '1.0'), ('--trials', '1', '--weaker', '-1'),
    ('--trials', '1', '--noise', '-1'), ('--trials', '1', '--noise', 'nan'),
    ('--trials', '1', '--noise', '2', '--page', '.')])
def test_numbers_that_make_no_sense_are_refused(tmp_path, capsys, arguments):
    assert run(tmp_path, *arguments) == 2
    assert 'expected' in capsys.readouterr().err


def test_a_cluster_that_cannot_be_had_is_said_in_words(tmp_path, capsys):
    assert run(tmp_path, '--trials', '1', '--scheduler', 'tcp://127.0.0.1:9') == 2
    message = capsys.readouterr().err
    assert 'distributed' in message or 'no Dask scheduler answers' in message


def test_settings_that_differ_have_other_fingerprints():
    assert AuditSettings().fingerprint == AuditSettings().fingerprint
    assert AuditSettings().fingerprint != AuditSettings(weaker=0.1).fingerprint
    assert AuditSettings().fingerprint != AuditSettings(noise=2.0).fingerprint


def page_of(tmp_path, rows, weaker):
    figure = tmp_path / 'drawn.png'
    figure.write_bytes(b'picture')
    command = command_of(len(rows), 0, weaker)
    write_page(tmp_path, weaker, command, rows, summarise_rows(rows), figure)
    return (tmp_path / 'audit.md').read_text()


def test_an_audit_fills_its_own_part_of_the_page_and_no_other(tmp_path):
    (tmp_path / 'audit.md').write_text('Words.\n<!-- weaker 0:begin -->\nold\n'
                                       '<!-- weaker 0:end -->\n<!-- weaker 0.2:begin -->\n'
                                       '<!-- weaker 0.2:end -->\nEnd.\n')
    failed = row('patchy', 7, success=False, ending='STALLED', cause='nothing \\1 is left')
    weak = page_of(tmp_path, [row(), failed], 0.2)
    assert 'old' in weak and 'patchy 7: STALLED' in weak and 'nothing \\1 is left' in weak
    assert '--trials 2 --weaker 0.2`' in weak and not (tmp_path / 'audit.png').exists()
    both = page_of(tmp_path, [row()], 0.0)
    assert 'old' not in both and 'patchy 7' in both and 'Every trial with a way' in both
    assert both.startswith('Words.') and both.endswith('End.\n')
    assert (tmp_path / 'audit.png').read_bytes() == b'picture'
    assert page_of(tmp_path, [row()], 0.0) == both


def test_a_page_without_a_part_for_the_audit_is_refused(tmp_path):
    with pytest.raises(AuditError, match='weaker 0.3'):
        page_of(tmp_path, [row()], 0.3)
