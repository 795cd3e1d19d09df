# SPDX-License-Identifier: Apache-2.0
"""The paper's experiments: three tasks, five strategies, tables, figures and one page.

`psane benchmark paper --physics --trials 3` walks the simulated hexapod; `--kinematic` its fast
stand-in. An experiment that was broken off goes on from there.
"""

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from psane_planner.presets import PRESETS
from psane_sim.errors import PaperError
from psane_sim.paper.ablations import ablation_trials, twin_of
from psane_sim.paper.report import Experiment, PaperReport
from psane_sim.paper.settings import PaperSettings
from psane_sim.paper.task import (
    PAPER_TASKS,
    STRATEGIES,
    PaperTask,
    PaperTrial,
    Robot,
    paper_trials,
    task_on,
)
from psane_sim.paper.trial import failed, row_of, run_paper_trial
from psane_sim.runs.run_data import RunData
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.terrains.terrain_sense import nonsense_of
from psane_sim.trials.steady_pool import run_steadily
from psane_sim.trials.trial_folder import Row, TrialFolder
from psane_sim.trials.trial_pool import run_on_cluster
from psane_sim.trials.work_estimate import Kind, WorkBar, WorkEstimate

HELP = "the paper's tasks and strategies: tables, figures and a report"

GUESSES = {Robot.PHYSICS: 0.15, Robot.KINEMATIC: 0.02}
"""Work for each simulated second, before any trial was run [-]."""

USUAL_SHARE = {True: {'psane_geodesic': 0.25, 'psane': 0.5, 'pgh': 0.8, 'sgh': 0.8, 'ngh': 0.25},
               False: {'psane_geodesic': 0.8, 'sgh': 0.25, 'ngh': 0.01}}
"""Share of the longest time that a trial with (True) or without a goal is expected to take [-]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what can be asked for."""
    parser.add_argument('--trials', type=int, default=3, metavar='N',
                        help='trials of each task and strategy (default 3)')
    robot = parser.add_mutually_exclusive_group()
    robot.add_argument('--physics', dest='robot', action='store_const', const=Robot.PHYSICS,
                       help='walk the simulated hexapod (default)')
    robot.add_argument('--kinematic', dest='robot', action='store_const', const=Robot.KINEMATIC,
                       help='walk the fast stand-in')
    parser.set_defaults(robot=Robot.PHYSICS)
    parser.add_argument('--preset', choices=[*PRESETS], default='default',
                        help='parameters that all strategies share (default: default)')
    names = [task.name for task in PAPER_TASKS]
    parser.add_argument('--tasks', nargs='+', choices=names, default=names,
                        help='tasks of the paper to be run (default: all)')
    parser.add_argument('--terrain', nargs='+', default=[], metavar='NAME|FILE',
                        help='further terrains whose goal is to be reached')
    parser.add_argument('--strategies', nargs='+', choices=STRATEGIES, default=[*STRATEGIES],
                        help='strategies to be run (default: all)')
    parser.add_argument('--ablations', action='store_true',
                        help='also vary beta, h, lengthscale, k_g, certification, touch, slip '
                        'model and noise')
    parser.add_argument('--report-only', action='store_true',
                        help='run nothing: write tables, figures and page of the trials there are')
    parser.add_argument('--workers', type=int, default=os.cpu_count() or 1, metavar='N',
                        help='processes on this machine (default: its cores)')
    parser.add_argument('--scheduler', metavar='ADDRESS',
                        help='a Dask scheduler, such as tcp://host:8786 (default: this machine)')
    parser.add_argument('--out', type=Path, default=Path('out/paper'), metavar='DIR',
                        help='where rows, runs, tables, figures and report go (default out/paper)')


def run(options: argparse.Namespace) -> int:
    """Run what is missing, and write tables, figures and page; return the exit status."""
    if options.trials < 1 or options.workers < 1:
        raise PaperError(f'--trials {options.trials} --workers {options.workers}, expected at '
                         'least 1 of each')
    shared = PaperSettings(preset=options.preset)
    tasks = _tasks_of(options)
    for warning in _nonsense(tasks, shared):
        print(f'psane benchmark paper: warning: {warning}', file=sys.stderr)
    folder = TrialFolder(options.out)
    trials = paper_trials(tasks, options.strategies, options.trials, options.robot)
    rows = _run_missing(trials, shared, folder, options)
    ablations: dict[str, Row] = {}
    if options.ablations:
        varied = {twin_of(trial).name: twin_of(trial)
                  for trial in ablation_trials(options.trials, options.robot)}
        ablations = _run_missing([*varied.values()], PaperSettings(), folder, options)
    if not rows:
        raise PaperError(f'{options.out} holds no trial yet')
    experiment = Experiment(robot=options.robot, preset=options.preset, tasks=tasks,
                            trials=options.trials)
    PaperReport(folder, experiment, rows, ablations).write()
    print((options.out / 'table.md').read_text())
    work = sum(row['timing']['work_s'] for row in [*rows.values(), *ablations.values()])
    print(f'{work / 60.0:.1f} minutes of work for one core', file=sys.stderr)
    print(f'written to {options.out}; the page is {options.out / "report.html"}',
          file=sys.stderr)
    return 0


def _tasks_of(options: argparse.Namespace) -> list[PaperTask]:
    tasks = [task for task in PAPER_TASKS if task.name in options.tasks]
    known = {task.name for task in tasks}
    return tasks + [task_on(name) for name in options.terrain if task_on(name).name not in known]


def _nonsense(tasks: Sequence[PaperTask], shared: PaperSettings) -> list[str]:
    threshold = PRESETS[shared.preset].planner.slip_threshold
    found = []
    for task in tasks:
        terrain = load_terrain(task.terrain)
        start, goal = task.ends(terrain)
        found += [f'{task.name}: {text}' for text in nonsense_of(terrain, start, goal, threshold)]
    return found


def _run_missing(trials: Sequence[PaperTrial], shared: PaperSettings, folder: TrialFolder,
                 options: argparse.Namespace) -> dict[str, Row]:
    """Return the rows of all trials by name, having run those that the folder does not hold."""
    rows = folder.known(trials, shared)
    missing = [trial for trial in trials if trial.name not in rows]
    if rows:
        print(f'{len(rows)} of {len(trials)} trials are there already', file=sys.stderr)
    if options.report_only:
        missing = []
    guesses = {_kind_of(trial): _guess(trial) for trial in trials}
    bar = WorkBar(WorkEstimate(guesses, [_kind_of(trial) for trial in missing]), options.workers)
    by_name = {trial.name: trial for trial in missing}
    for row, data in _results(missing, shared, options):
        folder.write(row, data)
        rows[row['name']] = row
        summary = row['summary']
        bar.advance(_kind_of(by_name[row['name']]), row['timing']['wall_s'],
                    f'{row["name"]}: {summary["reason"]}')
    bar.close()
    return {trial.name: rows[trial.name] for trial in trials if trial.name in rows}


def _results(missing: Sequence[PaperTrial], shared: PaperSettings, options: argparse.Namespace
             ) -> Iterator[tuple[Row, RunData | None]]:
    if not missing:
        return iter(())
    if options.scheduler is not None:
        return run_on_cluster(run_paper_trial, missing, shared, options.scheduler)
    return run_steadily(run_paper_trial, missing, shared, options.workers, _given_up)


def _given_up(trial: PaperTrial, shared: PaperSettings) -> tuple[Row, RunData | None]:
    return row_of(trial, shared, failed('its process died twice')), None


def _guess(trial: PaperTrial) -> float:
    """Return the work expected of a trial before any of its like was run [s]."""
    share = USUAL_SHARE[trial.task.has_goal].get(trial.strategy, 1.0)
    return GUESSES[trial.robot] * trial.task.duration * share


def _kind_of(trial: PaperTrial) -> Kind:
    return trial.task.name, trial.strategy, trial.robot.value
