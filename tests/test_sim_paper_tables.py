# SPDX-License-Identifier: Apache-2.0
"""What the tables say of rows, and that they say it of the rows that there are."""

import csv
import io
import math
import re

import numpy as np
import pytest
from paper_rows import row

from psane_sim.paper.ablation_report import study_table, variant_groups
from psane_sim.paper.ablations import STUDIES, ablation_trials, twin_of
from psane_sim.paper.groups import QUANTITIES, Group, grouped, quantity_named
from psane_sim.paper.published import PUBLISHED, published_for
from psane_sim.paper.remarks import remark_on
from psane_sim.paper.tables import as_latex, as_markdown, groups_as_csv, trials_as_csv
from psane_sim.paper.task import Robot

TIME, PATH, SUCCESS = (quantity_named(name) for name in ('time_s', 'path_m', 'success'))


def group_of(*rows):
    (made,) = grouped(rows)
    return made


def lost(reason='STALLED', **summary):
    return {'success': False, 'reason': reason, 'time_ratio': None, 'length_ratio': None,
            **summary}


def test_means_and_deviations_are_those_of_the_sample():
    group = group_of(*(row(seed=k, time_s=time) for k, time in enumerate((40.0, 50.0, 75.0))))
    spread = group.spread(TIME)
    assert spread.mean == pytest.approx(55.0)
    assert spread.deviation == pytest.approx(np.std([40.0, 50.0, 75.0], ddof=1))


def test_time_and_path_leave_out_trials_that_did_not_arrive():
    group = group_of(row(time_s=40.0), row(seed=1, time_s=400.0, **lost()))
    assert group.spread(TIME) == (40.0, 0.0, 1)
    assert group.spread(SUCCESS).mean == 0.5


def test_an_arrival_over_unsafe_ground_counts_for_the_time_and_not_as_success():
    group = group_of(row(success=False, unsafe_time_s=0.4))
    assert group.spread(TIME).trials == 1 and group.spread(SUCCESS).mean == 0.0
    assert 'unsafe ground' in remark_on(group)


def test_an_exploration_is_neither_success_nor_failure():
    group = group_of(row(task='explore_env2', **lost(coverage=0.9)))
    assert math.isnan(group.spread(SUCCESS).mean)
    assert '| psane | 1 | - |' in as_markdown([group])


def test_a_trial_that_failed_is_counted_and_its_reason_is_told():
    failed = row(seed=1)
    failed['summary'] = {'success': False, 'reason': 'FAILED', 'cause': 'ValueError: no ground'}
    group = group_of(row(), failed)
    assert group.spread(SUCCESS).mean == 0.5
    assert 'ValueError: no ground' in remark_on(group)
    assert all(group.spread(quantity).trials <= 2 for quantity in QUANTITIES)


@pytest.mark.parametrize(('time', 'words'), [
    (111.0, 'time alike'), (50.0, 'time shorter (0.45 x)'), (223.6, 'time longer (2.00 x)')])
def test_a_remark_says_how_ours_stands_to_the_paper(time, words):
    assert words in remark_on(group_of(row(time_s=time)))


def test_a_remark_tells_a_detour_from_a_slow_walk():
    slow = remark_on(group_of(row(time_s=223.62, path_m=14.54)))
    assert 'time longer (2.00 x), path alike, at 0.07 m/s against 0.13' in slow
    assert 'm/s' not in remark_on(group_of(row(strategy='sgh')))


def test_like_causes_are_counted_together():
    group = group_of(*(row(seed=k, cause=f'the certified area has not grown for {180 + k} s',
                           **lost()) for k in range(3)))
    assert '3 x STALLED (the certified area has not grown for ...)' in remark_on(group)


def test_the_figures_of_the_paper_are_those_of_its_text():
    psane, pgh = PUBLISHED['goal_env1', 'psane'], PUBLISHED['goal_env1', 'pgh']
    assert psane['time_s'] == (111.81, 17.93) and psane['path_m'] == (14.54, 2.41)
    assert pgh['time_s'] == (209.02, 64.07) and pgh['path_m'] == (31.89, 11.60)
    assert published_for('explore_env2', 'psane', 'coverage') == (0.67, 0.05)
    assert published_for('explore_env2', 'pgh', 'coverage') == (0.59, 0.12)
    assert published_for('goal_env1', 'psane_geodesic', 'time_s') == psane['time_s']
    assert published_for('goal_env2', 'psane', 'time_s') is None


@pytest.fixture
def groups():
    return grouped([row(strategy='pgh'), row(), row(seed=1, time_s=70.0),
                    row(task='explore_env2', time_s=1000.0)])


def test_groups_come_in_the_order_of_tasks_and_strategies(groups):
    assert [(g.task, g.strategy, len(g.rows)) for g in groups] == [
        ('goal_env1', 'psane', 2), ('goal_env1', 'pgh', 1), ('explore_env2', 'psane', 1)]


def test_the_markdown_holds_our_figure_and_the_papers_beside_it(groups):
    text = as_markdown(groups)
    assert '65.0 ± 7.1 [111.8 ± 17.9]' in text and '100% [100%]' in text
    widths = {line.count('|') for line in text.splitlines() if line.startswith('|')}
    assert widths == {len(QUANTITIES) + 3}


def test_the_latex_is_balanced_and_escaped(groups):
    text = as_latex(groups)
    assert not re.search(r'(?<!\\)[_%](?! Needs)', text)
    columns = {line.count(' & ') + line.startswith(' &') for line in text.splitlines()
               if line.endswith(r'\\')}
    assert len({line.count('&') for line in text.splitlines() if line.endswith(r'\\')}) == 1
    assert text.count('{') == text.count('}') and columns
    assert r'65.0 $\pm$ 7.1' in text and r'\emph{111.8 $\pm$ 17.9}' in text


def test_the_csv_of_groups_reads_back_to_the_last_digit(groups):
    lines = list(csv.DictReader(io.StringIO(groups_as_csv(groups))))
    assert len(lines) == len(groups)
    assert float(lines[0]['time_s_mean']) == 65.0
    assert float(lines[0]['time_s_paper_mean']) == 111.81
    assert lines[2]['success_mean'] == ''


def test_the_csv_of_trials_has_a_line_for_each(groups):
    rows = [entry for group in groups for entry in group.rows]
    rows[0]['summary']['cause'] = 'a cause, with a comma and a "word"'
    lines = list(csv.DictReader(io.StringIO(trials_as_csv(rows))))
    assert [line['name'] for line in lines] == [entry['name'] for entry in rows]
    assert lines[0]['cause'] == 'a cause, with a comma and a "word"'


@pytest.mark.parametrize('study', STUDIES, ids=lambda study: study.name)
def test_a_study_lists_every_value_for_all_its_tasks_from_the_right_rows(study):
    trials = [twin_of(made) for made in ablation_trials(2, Robot.KINEMATIC)]
    rows = {made.name: {**row(task=made.task.name, strategy=made.strategy, seed=made.seed),
                        'study': made.study} for made in trials}
    found = variant_groups(study, rows, 2, Robot.KINEMATIC)
    assert set(found) == {(task.name, label) for task in study.tasks
                          for label, _ in study.variants}
    for (task, label), group in found.items():
        assert isinstance(group, Group) and len(group.rows) == 2
        changes = dict(study.variants)[label]
        assert {entry['task'] for entry in group.rows} == {task}
        assert {entry['study'] for entry in group.rows} == {study.name if changes else 'preset'}
    lines = study_table(study, found, Robot.KINEMATIC).splitlines()
    assert sum(line.startswith('| ') for line in lines) == (
        1 + len(study.tasks) * len(study.variants))
