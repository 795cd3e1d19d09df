# SPDX-License-Identifier: Apache-2.0
"""Writes what is made from the declarations of parameters: parameter files and the README's table.

``python -m psane_sim.generated_text ROOT`` brings a checkout up to date; with ``--check`` it only
says what is not current, and ends with status 1.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.leg import RobotModel
from psane_mapping.parameter_file import file_of
from psane_mapping.parameter_table import inserted, table_of
from psane_mapping.parameters import Configuration
from psane_planner.configuration import PlannerConfiguration
from psane_planner.node_configuration import PlannerNodeConfiguration
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.node_configuration import ReactiveNodeConfiguration
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.node_configuration import (
    ContactSensorNodeConfiguration,
    SimulatorNodeConfiguration,
)
from psane_sim.touch.configuration import TouchConfiguration

PARAMETERS: dict[tuple[str, str], list[type[Configuration]]] = {
    ('psane_mapping', 'terrain_mapper'): [MappingConfiguration],
    ('psane_planner', 'safe_planner'): [PlannerNodeConfiguration, PlannerConfiguration],
    ('psane_reactive', 'reactive_controller'): [ReactiveNodeConfiguration, ReactiveConfiguration],
    ('psane_sim', 'hexapod_sim'): [SimulatorNodeConfiguration, SimulatorConfiguration, RobotModel],
    ('psane_sim', 'contact_sensor'): [ContactSensorNodeConfiguration, TouchConfiguration,
                                      RobotModel],
}
"""The configurations of each node, by package and executable."""


def tables() -> str:
    """Return the README's parameter tables, one for each node; the robot's own stand once."""
    parts = []
    for (package, node), kinds in PARAMETERS.items():
        rows = [table_of(kind) for kind in kinds if kind is not RobotModel]
        head, rule = rows[0].splitlines()[:2]
        body = [line for table in rows for line in table.splitlines()[2:]]
        parts.append('\n'.join([f'**`{node}`** ({package})', '', head, rule, *body]))
    parts.append('**The robot** (`hexapod_sim` and `contact_sensor`)\n\n' + table_of(RobotModel))
    return '\n\n'.join(parts)


def generated(root: Path) -> dict[Path, str]:
    """Return what each generated file of a checkout should hold."""
    texts = {root / 'src' / package / 'config' / f'{node}.yaml': file_of(node, kinds)
             for (package, node), kinds in PARAMETERS.items()}
    readme = root / 'README.md'
    texts[readme] = inserted(readme.read_text(), tables())
    return texts


def stale(root: Path) -> list[Path]:
    """Return the generated files of a checkout that are not current."""
    return [path for path, text in generated(root).items()
            if not path.is_file() or path.read_text() != text]


def main(arguments: Sequence[str] | None = None) -> None:
    """Write what is not current, or only say so."""
    parser = argparse.ArgumentParser(description='Bring generated text up to date.')
    parser.add_argument('root', type=Path, metavar='ROOT', help='folder of the checkout')
    parser.add_argument('--check', action='store_true', help='write nothing')
    options = parser.parse_args(arguments)
    old = stale(options.root)
    for path in old:
        print(f'not current: {path}')
        if not options.check:
            path.write_text(generated(options.root)[path])
    sys.exit(1 if old and options.check else 0)


if __name__ == '__main__':
    main()
