# SPDX-License-Identifier: Apache-2.0
"""`psane demo --robots 2`: two robots share a map, and the second one also walks alone."""

import argparse
import sys
from pathlib import Path
from typing import Any

from psane_sim.demo.node_parameters import settings_of
from psane_sim.demo.options import Assignment, assignment_of
from psane_sim.errors import TaskError
from psane_sim.progress import ProgressLine
from psane_sim.runs.closed_loop import ClosedLoop
from psane_sim.runs.neighbours import least_distance
from psane_sim.runs.picture import draw_run
from psane_sim.runs.summary import Ending, summarise, write_summary
from psane_sim.runs.team_loop import Member, MemberRun, TeamLoop

SUCCESS, NO_SUCCESS, NODE_DIED = 0, 1, 3
"""Exit statuses."""

SECOND_ON_ENV1 = (1.5, 6.3, 5.0, 1.5)
"""Start and goal (x, y) of the second robot on env1, map frame [m]: it comes from beyond the
first one's start and stops before the first one's goal."""


def members_of(options: argparse.Namespace) -> list[Member]:
    """Return the two robots that the options ask for.

    Raises
    ------
    TaskError
        When it is not said where the second one begins and goes, or a goal is missing.
    """
    if options.record:
        raise TaskError('--record: a bag of two robots is made by `psane run psane_sim record` '
                        'beside the demo; leave it out')
    if options.explore:
        raise TaskError('--robots 2: each robot needs a goal; leave out --explore')
    places = options.second
    if places is None and options.terrain != 'env1':
        raise TaskError(f'--robots 2 on {options.terrain}: say where the second robot begins and '
                        'goes, --second X Y X Y')
    *start, goal_x, goal_y = SECOND_ON_ENV1 if places is None else places
    second = argparse.Namespace(**{
        **vars(options), 'start': start, 'goal': [goal_x, goal_y], 'seed': options.seed + 1})
    return [Member(assignment=assignment_of(options), departure=0.0),
            Member(assignment=assignment_of(second), departure=options.head_start)]


def run_team(options: argparse.Namespace) -> int:
    """Run both robots, then the second one alone; return the exit status."""
    members = members_of(options)
    for number, member in enumerate(members, start=1):
        for warning in member.assignment.warnings:
            print(f'psane demo: warning: robot {number}: {warning}', file=sys.stderr)
    options.out.mkdir(parents=True, exist_ok=True)
    line = ProgressLine()
    run = _in_process if options.in_process else _on_graph
    together, alone = run(members, options, line)
    line.close()
    return _report(members, together, alone, options.out)


def _in_process(members: list[Member], options: argparse.Namespace,
                line: ProgressLine) -> tuple[list[MemberRun], MemberRun | None]:
    settings = settings_of(members[0].assignment)
    together = TeamLoop(members, settings).run(line.show)
    if _is_over(together):
        return together, None
    second = members[-1].assignment
    loop = ClosedLoop(second.task, second.terrain, second.start_pose, settings)
    outcome, score = loop.run(ProgressLine().show)
    return together, MemberRun(record=loop.record, outcome=outcome, score=score)


def _on_graph(members: list[Member], options: argparse.Namespace,
              line: ProgressLine) -> tuple[list[MemberRun], MemberRun | None]:
    # Only here, so that a run in one process needs no ROS.
    from psane_sim.demo.graph_run import GraphRun, GraphSettings
    from psane_sim.demo.ros_team_run import TeamRun, namespace_of
    from psane_sim.viewer.ros_view_process import live_view
    robots = [namespace_of(index) for index in range(len(members))]
    with live_view(options.view, options.out, options.robot, robots):
        together = TeamRun(members, options.out, options.pace).run(line.show)
        line.close()
    if _is_over(together):
        return together, None
    folder = options.out / 'alone'
    folder.mkdir(exist_ok=True)
    graph = GraphRun(members[-1].assignment, GraphSettings(out=folder, pace=options.pace,
                                                           gui=False))
    outcome, score = graph.run(ProgressLine().show)
    return together, MemberRun(record=graph.record, outcome=outcome, score=score)


def _is_over(together: list[MemberRun]) -> bool:
    """Tell whether the user or a death ended it all, so that nothing else is to be started."""
    return any(run.outcome.ending in (Ending.INTERRUPTED, Ending.NODE_DIED) for run in together)


def _report(members: list[Member], together: list[MemberRun], alone: MemberRun | None,
            out: Path) -> int:
    """Write summary and pictures, print what came out, return the exit status."""
    summary = _summary(members, together, alone)
    write_summary(summary, out / 'summary.json')
    for number, (member, run) in enumerate(zip(members, together, strict=True), start=1):
        _draw(member.assignment, run, f'robot {number} of 2', out / f'run{number}.png')
    if alone is not None:
        _draw(members[-1].assignment, alone, 'robot 2 alone', out / 'run2_alone.png')
    print(_words(summary))
    print(f'  summary and pictures  {out}/summary.json, {out}/run1.png ...')
    died = any(run.outcome.ending is Ending.NODE_DIED for run in together)
    return NODE_DIED if died else SUCCESS if summary['success'] else NO_SUCCESS


def _summary(members: list[Member], together: list[MemberRun],
             alone: MemberRun | None) -> dict[str, Any]:
    robots = [summarise(member.assignment.task, run.outcome, run.score)
              for member, run in zip(members, together, strict=True)]
    single = None if alone is None else summarise(members[-1].assignment.task, alone.outcome,
                                                  alone.score)
    gain = None if single is None else round(single['time_s'] - robots[-1]['time_s'], 3)
    return {
        'success': all(robot['success'] for robot in robots) and gain is not None and gain > 0.0,
        'robots': robots, 'second_alone': single, 'second_gain_s': gain,
        'head_start_s': members[-1].departure,
        'least_distance_m': round(least_distance([run.record.path for run in together]), 3)}


def _draw(assignment: Assignment, run: MemberRun, who: str, path: Path) -> None:
    task = assignment.task
    draw_run(run.record, assignment.terrain, task.threshold,
             f'{who}: {run.outcome.ending.value}', path)


def _words(summary: dict[str, Any]) -> str:
    verdict = 'success' if summary['success'] else 'no success'
    lines = [f'{verdict}: two robots on one map']
    named = [(f'robot {number}', robot)
             for number, robot in enumerate(summary['robots'], start=1)]
    if summary['second_alone'] is not None:
        named.append(('robot 2 alone', summary['second_alone']))
    lines += [f'  {name:20s}  {robot["reason"]}, {robot["time_s"]:.1f} s from its departure, '
              f'{robot["path_m"]:.2f} m, {robot["unsafe_time_s"]:.1f} s on unsafe ground, '
              f'{robot["subgoals"]} subgoals' + (f' ({robot["cause"]})' if robot['cause'] else '')
              for name, robot in named]
    lines.append(f'  nearest to each other {summary["least_distance_m"]:.2f} m')
    if summary['second_gain_s'] is not None:
        lines.append(f'  gained by sharing     {summary["second_gain_s"]:.1f} s for robot 2')
    return '\n'.join(lines)
