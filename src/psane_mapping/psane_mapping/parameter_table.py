# SPDX-License-Identifier: Apache-2.0
"""Render configuration dataclasses as Markdown tables, for the README.

``python -m psane_mapping.parameter_table MODULE... [--write README.md]`` prints the tables of all
configurations that the modules define, or writes them between the markers of a file.
"""

import argparse
import importlib
import inspect
from collections.abc import Sequence
from dataclasses import Field, fields
from pathlib import Path
from types import ModuleType
from typing import Any

from psane_mapping.errors import MappingError
from psane_mapping.parameters import Configuration, Declaration, declaration_of

BEGIN = '<!-- parameters:begin -->'
END = '<!-- parameters:end -->'


class MarkerError(MappingError):
    """A document does not hold the two markers, once each and in order."""


def configurations_in(module: ModuleType) -> list[type[Configuration]]:
    """Return the configurations that a module defines itself, in the order of its source."""
    return [kind for kind in vars(module).values()
            if inspect.isclass(kind) and issubclass(kind, Configuration)
            and kind.__module__ == module.__name__]


def table_of(configuration: type[Configuration]) -> str:
    """Return one configuration as a Markdown table."""
    rows = ['| parameter | default | unit | range | meaning |', '|---|---|---|---|---|']
    rows += [_row(entry) for entry in fields(configuration)]
    return '\n'.join(rows)


def _row(entry: 'Field[Any]') -> str:
    declared = declaration_of(entry)
    meaning = declared.meaning + (' (read-only)' if declared.read_only else '')
    cells = (f'`{entry.name}`', _shown(entry.default), declared.unit, _range(declared), meaning)
    return '| ' + ' | '.join(cell.replace('|', r'\|') for cell in cells) + ' |'


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'`{value}`' if value else '(empty)'
    return str(value)


def _range(declared: Declaration) -> str:
    if declared.choices:
        return ', '.join(f'`{choice}`' for choice in declared.choices)
    if declared.low is None and declared.high is None:
        return ''
    low = '-inf' if declared.low is None else f'{declared.low:g}'
    high = 'inf' if declared.high is None else f'{declared.high:g}'
    return f'{low} .. {high}'


def document_of(module_names: Sequence[str]) -> str:
    """Return the tables of all configurations in modules, each below a heading.

    A heading reads ``package``, or ``package: Class`` where a package has several.
    """
    parts = []
    for name in module_names:
        kinds = configurations_in(importlib.import_module(name))
        package = name.split('.')[0]
        for kind in kinds:
            heading = package if len(kinds) == 1 else f'{package}: {kind.__name__}'
            parts.append(f'**{heading}**\n\n{table_of(kind)}')
    return '\n\n'.join(parts)


def inserted(text: str, tables: str) -> str:
    """Return a document with what stands between its markers replaced.

    Raises
    ------
    MarkerError
        When the markers are not there once each, in order.
    """
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(BEGIN) > text.index(END):
        raise MarkerError(f'expected one {BEGIN!r} and after it one {END!r}')
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    return f'{before}{BEGIN}\n\n{tables}\n\n{END}{after}'


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables, or write them into a file."""
    parser = argparse.ArgumentParser(description='Render parameters as Markdown tables.')
    parser.add_argument('modules', nargs='+', metavar='MODULE')
    parser.add_argument('--write', type=Path, metavar='FILE')
    options = parser.parse_args(arguments)
    tables = document_of(options.modules)
    if options.write is None:
        print(tables)
    else:
        options.write.write_text(inserted(options.write.read_text(), tables))


if __name__ == '__main__':
    main()
