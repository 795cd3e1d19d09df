# SPDX-License-Identifier: Apache-2.0
"""A table and a figure for each study of the ablations."""

from collections.abc import Mapping
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from psane_sim.paper.ablations import STRATEGY, Study, ablation_trials, robot_of, twin_of
from psane_sim.paper.groups import QUANTITIES, Group, Quantity, Row
from psane_sim.paper.tables import shown
from psane_sim.paper.task import PaperTask, Robot
from psane_sim.runs.picture import STYLE

matplotlib.use('Agg')

SHOWN = ('success', 'time_s', 'path_m', 'unsafe_time_s', 'unsafe_foot_share',
         'false_certified_cells', 'coverage')
DRAWN = ('success', 'time_s', 'unsafe_time_s', 'false_certified_cells')
COLOURS = {'goal_env1': '#2166ac', 'goal_env2': '#d95f02', 'explore_env2': '#7570b3'}


def variant_groups(study: Study, rows: Mapping[str, Row], count: int, robot: Robot
                   ) -> dict[tuple[str, str], Group]:
    """Return the trials of a study by (task, label), those of the preset taken from its rows."""
    labels = [label for label, _ in study.variants]
    trials = [trial for trial in ablation_trials(count, robot) if trial.study == study.name]
    names: dict[tuple[str, str], list[str]] = {}
    for trial in trials:
        index = [changes for _, changes in study.variants].index(trial.changes)
        names.setdefault((trial.task.name, labels[index]), []).append(twin_of(trial).name)
    return {key: Group(task=key[0], strategy=STRATEGY,
                       rows=tuple(rows[name] for name in chosen if name in rows))
            for key, chosen in names.items()}


def study_table(study: Study, groups: Mapping[tuple[str, str], Group], robot: Robot) -> str:
    """Return a study's table as Markdown."""
    quantities = [quantity for quantity in QUANTITIES if quantity.name in SHOWN]
    lines = [f'### {study.title}', '',
             f'On the {robot_of(study, robot).value} robot.', '',
             '| value | task | n | ' + ' | '.join(q.heading for q in quantities) + ' | ends |',
             '|---' * (len(quantities) + 4) + '|']
    for label, _ in study.variants:
        for task in study.tasks:
            group = groups[task.name, label]
            cells = [_cell(group, quantity) for quantity in quantities]
            ends = ', '.join(f'{name} {times}' for name, times in sorted(group.endings.items()))
            lines.append(f'| {label} | {_task_name(task)} | {len(group.rows)} | '
                         + ' | '.join(cells) + f' | {ends} |')
    return '\n'.join([*lines, ''])


def _task_name(task: PaperTask) -> str:
    return task.terrain if task.has_goal else f'exploring {task.terrain}'


def _cell(group: Group, quantity: Quantity) -> str:
    spread = group.spread(quantity)
    if quantity.name == 'success' and spread.trials:
        return f'{spread.mean:.0%}'
    return shown(spread, quantity.digits)


def draw_study(study: Study, groups: Mapping[tuple[str, str], Group], path: Path) -> None:
    """Draw success, time, unsafe time and false cells over the values of a study."""
    quantities = [quantity for quantity in QUANTITIES if quantity.name in DRAWN]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(2.7 * len(quantities), 2.5), layout='constrained')
        axes = figure.subplots(1, len(quantities))
        for panel, quantity in zip(axes, quantities, strict=True):
            _draw_panel(panel, study, groups, quantity)
        axes[0].legend(frameon=False, fontsize=6.5, loc='lower left')
        figure.suptitle(study.title, fontsize=9)
        figure.savefig(path, dpi=140)


def _draw_panel(axes: Axes, study: Study, groups: Mapping[tuple[str, str], Group],
                quantity: Quantity) -> None:
    labels = [label for label, _ in study.variants]
    width = 0.66 / len(study.tasks)
    for number, task in enumerate(study.tasks):
        spreads = [groups[task.name, label].spread(quantity) for label in labels]
        means = np.array([spread.mean for spread in spreads])
        places = np.arange(len(labels)) + (number - 0.5 * (len(study.tasks) - 1)) * width
        axes.bar(places, np.nan_to_num(means), 0.95 * width, color=COLOURS[task.name],
                 yerr=[spread.deviation if spread.trials > 1 else 0.0 for spread in spreads],
                 capsize=2, error_kw={'linewidth': 0.7}, label=_task_name(task))
        for place, mean in zip(places, means, strict=True):
            if np.isnan(mean):
                axes.annotate('-', (place, 0.0), ha='center', va='bottom')
    axes.set_xticks(range(len(labels)), labels, fontsize=6.5,
                    rotation=20 if max(map(len, labels)) > 8 else 0)
    axes.set_title(quantity.heading)
    axes.set_ylim(bottom=0.0)

