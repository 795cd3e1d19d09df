# SPDX-License-Identifier: Apache-2.0
"""`psane run psane_sim viewer`: a run in the browser, live, and as a page to keep."""

import argparse
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path

from psane_mapping.errors import ParameterError
from psane_sim.errors import SimulationError
from psane_sim.robot.robots import read_robot

ENDED, BAD_ARGUMENT = 0, 2
"""Exit statuses."""

LOOPBACK = '127.0.0.1'


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(
        prog='psane run psane_sim viewer',
        description='Show a run in the browser: maps, certified ground, frontier, plan, robot, '
        'forces and plots. A click on the ground sets the goal. Nothing leaves this machine, and '
        'no other machine is listened to, unless --host says so.',
        epilog='Remap with --ros-args -r. Ends at Ctrl-C; exit status 0, or 2 for a bad argument.')
    made.add_argument('--host', default=LOOPBACK, metavar='ADDRESS',
                      help=f'address to listen on (default {LOOPBACK}; 0.0.0.0 lets everybody in '
                      'the network watch and set goals)')
    made.add_argument('--port', type=int, default=8080, metavar='N',
                      help='port to listen on, 0 for any that is free (default 8080)')
    made.add_argument('--export', type=Path, metavar='FILE.html',
                      help='record what is shown and write it, with a timeline, at the end')
    made.add_argument('--robots', nargs='+', default=[''], metavar='NAMESPACE',
                      help='namespaces of several robots on one map')
    made.add_argument('--robot', default='x_rhex', metavar='NAME|FILE',
                      help='what the robot looks like (default x_rhex)')
    made.add_argument('--frame', default='map', metavar='FRAME',
                      help='frame of maps and goals (default map)')
    return made


def main(arguments: Sequence[str] | None = None) -> None:
    """Serve the view until Ctrl-C."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    cut = given.index('--ros-args') if '--ros-args' in given else len(given)
    options = parser().parse_args(given[:cut])
    if importlib.util.find_spec('viser') is None:
        _refuse("the Python package 'viser' is missing; type:  "
                "pip3 install --break-system-packages 'viser==1.1.1'")
    if not 0 <= options.port <= 65535:
        _refuse(f'--port {options.port}: expected a value in [0, 65535]')
    if options.export is not None and not options.export.parent.is_dir():
        _refuse(f'--export {options.export}: there is no folder {options.export.parent}')
    # Only here, so that a bad argument is answered at once.
    from psane_sim.viewer.ros_viewer import serve
    try:
        serve(options, read_robot(options.robot).model, given[cut:])
    except (SimulationError, ParameterError) as error:
        _refuse(str(error))
    sys.exit(ENDED)


def _refuse(sentence: str) -> None:
    print(f'psane viewer: {sentence}', file=sys.stderr)
    sys.exit(BAD_ARGUMENT)
