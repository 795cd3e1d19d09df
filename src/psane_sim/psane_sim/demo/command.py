# SPDX-License-Identifier: Apache-2.0
"""The demo: one run from start to goal, on a ROS 2 graph or in one process."""

import argparse
import signal
import sys
from collections.abc import Sequence
from types import FrameType

from psane_mapping.errors import ParameterError
from psane_planner.configuration import PlannerConfiguration
from psane_sim.bags.summary import BAG, in_short
from psane_sim.demo.node_parameters import settings_of
from psane_sim.demo.options import Assignment, assignment_of, parse
from psane_sim.demo.team_demo import run_team
from psane_sim.errors import SimulationError
from psane_sim.progress import ProgressLine
from psane_sim.runs.closed_loop import ClosedLoop
from psane_sim.runs.picture import draw_run
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.scoring import Score
from psane_sim.runs.summary import Ending, Outcome, in_words, summarise, write_summary
from psane_sim.touch.summary import touch_summary, write_strides

SUCCESS, NO_SUCCESS, BAD_ARGUMENT, NODE_DIED = 0, 1, 2, 3
"""Exit statuses."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the demo and end the program with its exit status."""
    options = parse(arguments)
    signal.signal(signal.SIGTERM, _interrupt)
    signal.signal(signal.SIGHUP, _interrupt)
    try:
        sys.exit(run(options))
    except (SimulationError, ParameterError) as error:
        print(f'psane demo: {error}', file=sys.stderr)
        sys.exit(BAD_ARGUMENT)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """End like Ctrl-C: stop what was started, and leave a summary."""
    raise KeyboardInterrupt


def run(options: argparse.Namespace) -> int:
    """Run what the options ask for; return the exit status."""
    if options.robots > 1:
        return run_team(options)
    assignment = assignment_of(options)
    for warning in assignment.warnings:
        print(f'psane demo: warning: {warning}', file=sys.stderr)
    options.out.mkdir(parents=True, exist_ok=True)
    line = ProgressLine()
    if options.in_process:
        record, outcome, score = _run_in_process(assignment, options, line)
    else:
        record, outcome, score = _run_on_graph(assignment, options, line)
    line.close()
    return _report(assignment, record, outcome, score, options)


def _run_in_process(assignment: Assignment, options: argparse.Namespace,
                    line: ProgressLine) -> tuple[RunRecord, Outcome, Score]:
    loop = ClosedLoop(assignment.task, assignment.terrain, assignment.start_pose,
                      settings_of(assignment, gui=options.gui))
    outcome, score = loop.run(line.show)
    return loop.record, outcome, score


def _run_on_graph(assignment: Assignment, options: argparse.Namespace,
                  line: ProgressLine) -> tuple[RunRecord, Outcome, Score]:
    # Only here, so that a run in one process needs no ROS.
    from psane_sim.demo.graph_run import GraphRun, GraphSettings
    from psane_sim.viewer.ros_view_process import live_view
    PlannerConfiguration(slip_threshold=assignment.task.threshold)
    graph = GraphRun(assignment, GraphSettings(out=options.out, pace=options.pace,
                                               gui=options.gui, record=options.record))
    with live_view(options.view, options.out, options.robot):
        outcome, score = graph.run(line.show)
        line.close()
    return graph.record, outcome, score


def _report(assignment: Assignment, record: RunRecord, outcome: Outcome, score: Score,
            options: argparse.Namespace) -> int:
    """Write summary and picture, print the summary, return the exit status."""
    task = assignment.task
    touch = touch_summary(record, assignment.robot)
    summary = summarise(task, outcome, score, touch)
    write_strides(record, assignment.robot, options.out / 'strides.csv')
    write_summary(summary, options.out / 'summary.json')
    print(in_words(summary))
    title = f'{task.strategy} on {task.terrain}, seed {task.seed}: {outcome.ending.value}'
    draw_run(record, assignment.terrain, task.threshold, title, options.out / 'run.png')
    print(f'  summary and picture   {options.out}/summary.json, {options.out}/run.png')
    if options.record:
        print(f'  bag                   {in_short(options.out / BAG)}')
    if outcome.ending is Ending.NODE_DIED:
        return NODE_DIED
    return SUCCESS if summary['success'] else NO_SUCCESS
