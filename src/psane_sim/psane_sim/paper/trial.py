# SPDX-License-Identifier: Apache-2.0
"""Run one trial of the paper's experiments: a row, and the run that it came from."""

import json
import math
import platform
import time
from typing import Any

from psane_sim.paper.settings import PaperSettings, document_of, loop_settings, threshold_of
from psane_sim.paper.task import PaperTask, PaperTrial
from psane_sim.runs.closed_loop import ClosedLoop, Settings
from psane_sim.runs.kinematic_loop import KinematicLoop
from psane_sim.runs.run_data import RunData, data_of
from psane_sim.runs.run_watch import RunWatch
from psane_sim.runs.summary import Ending, Task, summarise, versions
from psane_sim.source_digest import source_digest
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.terrains.omniscient import least_length, least_time
from psane_sim.terrains.terrain import Terrain

FAILED = 'FAILED'
"""Reason of a trial that ended with an error instead of a result."""

LIMIT = 0.3
"""Speed limit of the robot [m/s]."""

Row = dict[str, Any]


def run_paper_trial(trial: PaperTrial, shared: PaperSettings) -> tuple[Row, RunData | None]:
    """Run a trial; whatever goes wrong in it becomes the reason of its row."""
    began, worked = time.monotonic(), time.process_time()
    try:
        summary, data, _ = run_to_summary(trial, shared, RunWatch())
    except Exception as problem:  # noqa: BLE001 - one bad trial must not end the experiment
        summary, data = failed(f'{type(problem).__name__}: {problem}'), None
    return row_of(trial, shared, summary, time.monotonic() - began,
                  time.process_time() - worked), data


def run_to_summary(trial: PaperTrial, shared: PaperSettings, watch: RunWatch
                   ) -> tuple[Row, RunData, ClosedLoop | KinematicLoop]:
    """Run a trial; return its summary (the same whenever it is run), its data and its loop."""
    settings = loop_settings(trial, shared)
    terrain = load_terrain(trial.task.terrain)
    start, goal = trial.task.ends(terrain)
    task = Task(terrain=trial.task.terrain, start=start, goal=goal, strategy=trial.strategy,
                threshold=threshold_of(settings), seed=trial.seed, duration=trial.task.duration)
    loop: ClosedLoop | KinematicLoop
    if isinstance(settings, Settings):
        loop = ClosedLoop(task, terrain, terrain.start_pose, settings)
    else:
        loop = KinematicLoop(task, terrain, terrain.start_pose, settings)
    outcome, score = loop.run(watch=watch)
    if outcome.ending is Ending.INTERRUPTED:
        raise KeyboardInterrupt
    watch.finish(loop)
    summary = summarise(task, outcome, score)
    del summary['timing'], summary['versions']
    optimum = optimum_of(trial.task, terrain, trial, shared)
    whole: Row = json.loads(json.dumps({**summary, **optimum, **_ratios(summary, optimum)}))
    return whole, data_of(loop, watch), loop


def optimum_of(task: PaperTask, terrain: Terrain, trial: PaperTrial, shared: PaperSettings
               ) -> dict[str, float | None]:
    """Return what a robot that knows the ground would need; None without a goal or a way."""
    names = ('least_length_m', 'least_time_s')
    start, goal = task.ends(terrain)
    if goal is None:
        return dict.fromkeys(names)
    planner = loop_settings(trial, shared).planner
    details: dict[str, Any] = {
        'threshold': planner.slip_threshold, 'border_width': planner.border_width,
        'clearance': planner.clearance + planner.contour_tolerance,
        'goal_tolerance': planner.goal_tolerance}
    found = (least_length(terrain, start, goal, **details),
             least_time(terrain, start, goal, speed=LIMIT, **details))
    return {name: round(value, 3) if math.isfinite(value) else None
            for name, value in zip(names, found, strict=True)}


def _ratios(summary: Row, optimum: dict[str, float | None]) -> dict[str, float | None]:
    """Return time and path over the optimum's, for a trial that reached its goal."""
    made: dict[str, float | None] = {}
    for name, taken, best in (('time_ratio', 'time_s', 'least_time_s'),
                              ('length_ratio', 'path_m', 'least_length_m')):
        least = optimum[best]
        has_arrived = summary['reason'] == Ending.REACHED.name
        made[name] = round(summary[taken] / least, 4) if has_arrived and least else None
    return made


def failed(cause: str) -> Row:
    """Return the summary of a trial without a result."""
    return {'success': False, 'reason': FAILED, 'cause': cause}


def row_of(trial: PaperTrial, shared: PaperSettings, summary: Row, wall: float = 0.0,
           work: float = 0.0) -> Row:
    """Return a trial's row: what it was, what it was run with, what came out.

    `wall` is the time that it took on the clock on the wall, `work` that of its core [s].
    """
    return {'name': trial.name, 'task': trial.task.name, 'strategy': trial.strategy,
            'seed': trial.seed, 'robot': trial.robot.value, 'study': trial.study,
            'variant': trial.variant, 'summary': summary,
            'configuration': document_of(trial, shared),
            'versions': {**versions(), 'source': source_digest(),
                         'machine': platform.machine()},
            'timing': {'wall_s': round(wall, 2), 'work_s': round(work, 2)}}
