# SPDX-License-Identifier: Apache-2.0
"""The tables: every group with the paper's figure beside it, and every single trial."""

import csv
import io
import math
from collections.abc import Sequence
from typing import Any

from psane_sim.paper.groups import QUANTITIES, Group, Quantity, Row, Spread
from psane_sim.paper.published import WHOLE_DIFFERENCES, Published, published_for
from psane_sim.paper.remarks import remark_on
from psane_sim.paper.task import title_of

TRIAL_COLUMNS = ('name', 'task', 'strategy', 'seed', 'robot', 'study', 'variant')
SUMMARY_COLUMNS = (
    'success', 'reason', 'cause', 'time_s', 'path_m', 'unsafe_time_s', 'unsafe_foot_share',
    'false_certified_cells', 'certified_cells', 'coverage', 'subgoals', 'contacts',
    'least_time_s', 'least_length_m', 'time_ratio', 'length_ratio')


def shown(spread: Spread, digits: int) -> str:
    """Return mean and deviation; a dash without a trial that has the figure."""
    if spread.trials == 0 or math.isnan(spread.mean):
        return '-'
    mean = f'{spread.mean:.{digits}f}'
    return mean if spread.trials == 1 else f'{mean} ± {spread.deviation:.{digits}f}'


def paper_shown(figure: Published | None, digits: int) -> str:
    """Return the paper's figure; empty where there is none."""
    if figure is None:
        return ''
    mean = f'{figure.mean:.{digits}f}'
    return mean if figure.deviation is None else f'{mean} ± {figure.deviation:.{digits}f}'


def _cell(group: Group, quantity: Quantity) -> tuple[str, str]:
    """Return our figure and the paper's."""
    ours = group.spread(quantity)
    is_share = quantity.name == 'success' and ours.trials > 0
    text = f'{ours.mean:.0%}' if is_share else shown(ours, quantity.digits)
    theirs = published_for(group.task, group.strategy, quantity.name)
    if quantity.name == 'success':
        return text, '' if theirs is None else f'{theirs.mean:.0%}'
    return text, paper_shown(theirs, quantity.digits)


def as_markdown(groups: Sequence[Group]) -> str:
    """Return one table for each task, the paper's figures in brackets, and the remarks."""
    lines: list[str] = []
    for task in dict.fromkeys(group.task for group in groups):
        lines += [f'### {title_of(task)}', '',
                  '| strategy | n | ' + ' | '.join(q.heading for q in QUANTITIES) + ' |',
                  '|---' * (len(QUANTITIES) + 2) + '|']
        here = [group for group in groups if group.task == task]
        for group in here:
            cells = [' '.join((ours, f'[{theirs}]' if theirs else '')).strip()
                     for ours, theirs in (_cell(group, q) for q in QUANTITIES)]
            lines.append(f'| {group.strategy} | {len(group.rows)} | ' + ' | '.join(cells) + ' |')
        lines += ['', *(f'- {group.strategy}: {remark_on(group)}' for group in here
                        if remark_on(group)), '']
    notes = ['In brackets: the paper. Time, path and their ratios are those of the trials that '
             'arrived; ± is the standard deviation of the trials.', *WHOLE_DIFFERENCES]
    return '\n'.join([*lines, *(f'- {note}' for note in notes), ''])


def as_latex(groups: Sequence[Group]) -> str:
    """Return a booktabs table of all groups; a second line in each holds the paper's figures."""
    chosen = [q for q in QUANTITIES if q.name not in ('unsafe_foot_share', 'length_ratio')]
    lines = ['% Needs the package booktabs.', r'\begin{tabular}{ll' + 'r' * len(chosen) + '}',
             r'\toprule',
             'task & strategy & ' + ' & '.join(_escaped(q.heading) for q in chosen) + r' \\']
    last = None
    for group in groups:
        lines += [r'\midrule'] if group.task != last else []
        first = _escaped(title_of(group.task)) if group.task != last else ''
        last = group.task
        pairs = [_cell(group, q) for q in chosen]
        lines.append(f'{first} & {_escaped(group.strategy)} & '
                     + ' & '.join(_escaped(ours) for ours, _ in pairs) + r' \\')
        if any(theirs for _, theirs in pairs):
            lines.append(r' & \emph{paper} & ' + ' & '.join(
                rf'\emph{{{_escaped(theirs)}}}' if theirs else '' for _, theirs in pairs)
                + r' \\')
    return '\n'.join([*lines, r'\bottomrule', r'\end{tabular}', ''])


def _escaped(text: str) -> str:
    for found, put in (('%', r'\%'), ('_', r'\_'), ('±', r'$\pm$')):
        text = text.replace(found, put)
    return text


def groups_as_csv(groups: Sequence[Group]) -> str:
    """Return one line for each group: means, deviations and the paper's figures."""
    header = ['task', 'strategy', 'trials']
    header += [f'{q.name}_{what}' for q in QUANTITIES
               for what in ('mean', 'deviation', 'count', 'paper_mean', 'paper_deviation')]
    return _csv([header, *(_group_line(group) for group in groups)])


def _group_line(group: Group) -> list[Any]:
    line: list[Any] = [group.task, group.strategy, len(group.rows)]
    for quantity in QUANTITIES:
        ours = group.spread(quantity)
        theirs = published_for(group.task, group.strategy, quantity.name)
        line += [_number(ours.mean), _number(ours.deviation), ours.trials]
        line += ['', ''] if theirs is None else [theirs.mean, theirs.deviation or '']
    return line


def _number(value: float) -> str:
    return '' if math.isnan(value) else f'{value:.6g}'


def trials_as_csv(rows: Sequence[Row]) -> str:
    """Return one line for each trial."""
    lines = [[*TRIAL_COLUMNS, *SUMMARY_COLUMNS]]
    for row in rows:
        values = [row['summary'].get(name) for name in SUMMARY_COLUMNS]
        lines.append([*(row[name] for name in TRIAL_COLUMNS),
                      *('' if value is None else value for value in values)])
    return _csv(lines)


def _csv(lines: Sequence[Sequence[Any]]) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator='\n').writerows(lines)
    return buffer.getvalue()
