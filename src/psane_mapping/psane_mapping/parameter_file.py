# SPDX-License-Identifier: Apache-2.0
"""Render configuration dataclasses as a ROS parameter file, with meaning, unit and range beside.

``python -m psane_mapping.parameter_file NODE MODULE...`` prints the file of a node whose
parameters are all configurations that the modules define.
"""

import argparse
import importlib
from collections.abc import Sequence
from dataclasses import Field, fields
from typing import Any

from psane_mapping.parameter_table import configurations_in
from psane_mapping.parameters import Configuration, declaration_of


def file_of(node: str, configurations: Sequence[type[Configuration]]) -> str:
    """Return the text of a parameter file that sets every parameter of a node to its default."""
    lines = ['# SPDX-License-Identifier: Apache-2.0',
             f'# Every parameter of {node} with its default (made from the declarations).',
             f'/**/{node}:', '  ros__parameters:']
    for kind in configurations:
        for entry in fields(kind):
            lines += [f'    # {_explained(entry)}', f'    {entry.name}: {_shown(entry.default)}']
    return '\n'.join(lines) + '\n'


def _explained(entry: 'Field[Any]') -> str:
    declared = declaration_of(entry)
    parts = [declared.meaning, f'[{declared.unit}]']
    if declared.choices:
        parts.append(f'one of {", ".join(declared.choices)}')
    elif declared.low is not None or declared.high is not None:
        low = '-inf' if declared.low is None else f'{declared.low:g}'
        high = 'inf' if declared.high is None else f'{declared.high:g}'
        parts.append(f'{low} to {high}')
    return ' '.join(parts)


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f"'{value}'"
    if isinstance(value, float):
        # YAML reads 1e-08 as text, and ROS refuses 1 for a floating-point number.
        text = f'{value:.12f}'.rstrip('0')
        return text + '0' if text.endswith('.') else text
    return str(value)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the parameter file of a node."""
    parser = argparse.ArgumentParser(description='Render the parameter file of a node.')
    parser.add_argument('node', metavar='NODE')
    parser.add_argument('modules', nargs='+', metavar='MODULE')
    options = parser.parse_args(arguments)
    kinds = [kind for name in options.modules
             for kind in configurations_in(importlib.import_module(name))]
    print(file_of(options.node, kinds), end='')


if __name__ == '__main__':
    main()
