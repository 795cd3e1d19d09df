# SPDX-License-Identifier: Apache-2.0
"""Experiments with numbers at the end: `psane benchmark NAME`.

A new one is a module with `HELP`, `add_arguments(parser)` and `run(options) -> exit status`, and
one line here.
"""

import argparse
import importlib
import signal
import sys
from collections.abc import Sequence
from types import FrameType

from psane_sim.errors import SimulationError

EXPERIMENTS = {'audit': 'psane_sim.trials.audit', 'paper': 'psane_sim.paper.command',
               'replay': 'psane_sim.paper.replay_row'}
"""Module of each experiment."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the experiment that was asked for; a bad argument ends with status 2."""
    parser = argparse.ArgumentParser(prog='psane benchmark', description=(
        'Run an experiment and write its table and figures.'))
    commands = parser.add_subparsers(dest='experiment', required=True, metavar='NAME')
    modules = {name: importlib.import_module(module) for name, module in EXPERIMENTS.items()}
    for name, module in modules.items():
        module.add_arguments(commands.add_parser(name, help=module.HELP,
                                                 description=module.__doc__))
    options = parser.parse_args(arguments)
    previous = signal.signal(signal.SIGTERM, _interrupt)
    try:
        status: int = modules[options.experiment].run(options)
    except SimulationError as problem:
        print(f'psane benchmark {options.experiment}: {problem}', file=sys.stderr)
        status = 2
    except KeyboardInterrupt:
        print('broken off; the same command goes on from here', file=sys.stderr)
        status = 130
    finally:
        signal.signal(signal.SIGTERM, previous)
    sys.exit(status)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """End like Ctrl-C, so that no worker is left behind."""
    raise KeyboardInterrupt


if __name__ == '__main__':
    main()
