# SPDX-License-Identifier: Apache-2.0
"""The demo's command line, and the task that it asks for."""

import argparse
import importlib.util
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from psane_planner.configuration import STRATEGIES, PlannerConfiguration
from psane_sim.configuration import SOIL_NAMES
from psane_sim.errors import TaskError
from psane_sim.robot.chosen_robot import DEFAULT_ROBOT, DEFAULT_SOIL, ChosenRobot, choose_robot
from psane_sim.robot.robots import robot_names
from psane_sim.runs.summary import Task
from psane_sim.terrains.catalogue import load_terrain, terrain_names
from psane_sim.terrains.terrain import Terrain
from psane_sim.terrains.terrain_sense import nonsense_of

LONGEST = 36_000.0
"""Longest run that can be asked for [s]."""


@dataclass(frozen=True, kw_only=True)
class Assignment:
    """A task with its world.

    Parameters
    ----------
    task : Task
    terrain : Terrain
    start_pose : (x, y, yaw), map frame [m], [rad]
    robot : ChosenRobot
    warnings : list of str
        What makes the task hard or impossible, in words.
    """

    task: Task
    terrain: Terrain
    start_pose: tuple[float, float, float]
    robot: ChosenRobot
    warnings: list[str]


def parser() -> argparse.ArgumentParser:
    """Return the parser of the demo's command line."""
    made = argparse.ArgumentParser(
        prog='psane demo', description='Let a simulated hexapod feel its way over unknown sand to '
        'its goal: five ROS 2 nodes on this machine, or the same objects in one process.',
        epilog='Exit status: 0 success, 1 no success, 2 a bad argument, 3 a node died.')
    made.add_argument('--terrain', default='env1', metavar='NAME|FILE',
                      help=f'one of {", ".join(terrain_names())}, or a .csv, .npy or GeoTIFF file '
                      '(default env1)')
    made.add_argument('--start', nargs=2, type=float, metavar=('X', 'Y'),
                      help="where to begin, map frame [m] (default: the terrain's own)")
    made.add_argument('--robot', default=DEFAULT_ROBOT, metavar='NAME|FILE',
                      help=f'one of {", ".join(robot_names())}, or a .yaml file (default '
                      f'{DEFAULT_ROBOT}); its calibration comes with it')
    made.add_argument('--calibration', type=Path, metavar='FILE',
                      help='what `calibrate` wrote for the robot (default: the shipped one)')
    made.add_argument('--soil', default=DEFAULT_SOIL, choices=SOIL_NAMES,
                      help=f'how the ground pushes (default {DEFAULT_SOIL})')
    target = made.add_mutually_exclusive_group()
    target.add_argument('--goal', nargs=2, type=float, metavar=('X', 'Y'),
                        help="where to go, map frame [m] (default: the terrain's own)")
    target.add_argument('--explore', action='store_true',
                        help='no goal: certify as much ground as can be reached')
    made.add_argument('--strategy', default=PlannerConfiguration.strategy, choices=STRATEGIES,
                      help='how the next subgoal is chosen (default psane_geodesic)')
    made.add_argument('--threshold', type=float, default=PlannerConfiguration.slip_threshold,
                      metavar='H', help='slip ratio above which ground is unsafe (default 0.5)')
    made.add_argument('--seed', type=int, default=0, metavar='N',
                      help='seed of all noise (default 0)')
    made.add_argument('--duration', type=float, default=300.0, metavar='S',
                      help='simulated time after which the run ends [s] (default 300)')
    made.add_argument('--in-process', action='store_true',
                      help='run without ROS: repeatable from the seed, faster than real time')
    made.add_argument('--pace', type=float, default=2.0, metavar='X',
                      help='on the graph: simulated seconds for each second on the wall, where '
                      'the machine can keep up (default 2)')
    made.add_argument('--record', action='store_true',
                      help='on the graph: record all topics into a rosbag2 bag, DIR/bag')
    made.add_argument('--view', nargs='?', type=int, const=0, metavar='PORT',
                      help='on the graph: show the run in the browser, at an address that is '
                      'printed, and leave DIR/view.html (default port: any that is free)')
    made.add_argument('--robots', type=int, choices=(1, 2), default=1,
                      help='2: a second robot leaves later, and both share one map; it then walks '
                      'alone too, for comparison')
    made.add_argument('--second', nargs=4, type=float, metavar=('X', 'Y', 'GX', 'GY'),
                      help='where the second robot begins and goes, map frame [m] (env1 has its '
                      'own)')
    made.add_argument('--head-start', type=float, default=30.0, metavar='S',
                      help='simulated time by which the first robot leaves earlier [s] '
                      '(default 30)')
    made.add_argument('--gui', action='store_true', help="show the physics engine's window")
    made.add_argument('--out', type=Path, metavar='DIR',
                      help='where summary, picture and logs go (default '
                      'out/TERRAIN-STRATEGY-SEED)')
    return made


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line; a bad argument ends the program with status 2."""
    options = parser().parse_args(arguments)
    if options.out is None:
        name = Path(options.terrain).stem.replace(':', '-')
        team = '-team' if options.robots > 1 else ''
        options.out = Path('out') / f'{name}-{options.strategy}-{options.seed}{team}'
    return options


def assignment_of(options: argparse.Namespace) -> Assignment:
    """Return the task that was asked for.

    Raises
    ------
    SimulationError
        For an unknown or malformed terrain, or a task that makes no sense.
    """
    _require('--duration', options.duration, 1.0, LONGEST, 's')
    _require('--seed', options.seed, 0, 2**31 - 1, '')
    _require('--pace', options.pace, 0.01, 100.0, '')
    if options.record and options.in_process:
        raise TaskError('--record: a run in one process has no topics; leave out --in-process')
    _require('--head-start', options.head_start, 0.0, LONGEST, 's')
    _check_view(options)
    robot = choose_robot(options.robot, options.soil, options.calibration)
    terrain = robot.terrain_for(load_terrain(options.terrain))
    start = terrain.start if options.start is None else tuple(options.start)
    goal = None if options.explore else (options.goal or terrain.goal)
    _require_inside('--start', start, terrain)
    if goal is not None:
        _require_inside('--goal', goal, terrain)
    task = Task(terrain=options.terrain, start=(float(start[0]), float(start[1])),
                goal=None if goal is None else (float(goal[0]), float(goal[1])),
                strategy=options.strategy, threshold=options.threshold, seed=options.seed,
                duration=options.duration, robot=robot.name, soil=options.soil)
    ahead = task.goal or terrain.goal
    yaw = math.atan2(ahead[1] - task.start[1], ahead[0] - task.start[0])
    return Assignment(task=task, terrain=terrain, start_pose=(*task.start, yaw), robot=robot,
                      warnings=nonsense_of(terrain, task.start, task.goal,
                                           task.threshold))


def _check_view(options: argparse.Namespace) -> None:
    if options.view is None:
        return
    _require('--view', options.view, 0, 65535, '')
    if options.in_process:
        raise TaskError('--view: a run in one process has no topics to show; leave out '
                        '--in-process')
    if importlib.util.find_spec('viser') is None:
        raise TaskError("--view: the Python package 'viser' is missing; type:  pip3 install "
                        "--break-system-packages 'viser==1.1.1'")


def _require(name: str, value: float, low: float, high: float, unit: str) -> None:
    if not (math.isfinite(value) and low <= value <= high):
        expected = f'expected a value in [{low:g}, {high:g}] {unit}'.rstrip()
        raise TaskError(f'{name} {value:g}: {expected}')


def _require_inside(name: str, point: Sequence[float], terrain: Terrain) -> None:
    """Refuse a point outside the workspace, or in the border that is never certified."""
    border = PlannerConfiguration.border_width
    min_x, min_y, max_x, max_y = terrain.extent
    x, y = point
    if not (min_x + border <= x <= max_x - border and min_y + border <= y <= max_y - border):
        raise TaskError(
            f'{name} {x:g} {y:g}: expected a point in [{min_x + border:g}, {max_x - border:g}] x '
            f'[{min_y + border:g}, {max_y - border:g}] m; the border of {border:g} m along the '
            "workspace's edge is never certified")
