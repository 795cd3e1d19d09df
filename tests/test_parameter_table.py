# SPDX-License-Identifier: Apache-2.0
"""The parameter tables of the README."""

import sys
from dataclasses import dataclass

import pytest

from psane_mapping.parameter_table import (
    BEGIN,
    END,
    MarkerError,
    configurations_in,
    document_of,
    inserted,
    main,
    table_of,
)
from psane_mapping.parameters import Configuration, parameter


@dataclass(frozen=True, kw_only=True)
class Sample(Configuration):
    """One field of each look."""

    reach: float = parameter(0.6, 'distance | range', unit='m', low=0.01, high=100.0)
    above: int = parameter(2, 'no upper limit', low=0)
    free: float = parameter(-3.5, 'no limit', unit='N')
    active: bool = parameter(True, 'whether it runs')
    rule: str = parameter('plain', 'how it works', choices=('plain', 'fancy'))
    frame: str = parameter('', 'name of the frame', read_only=True)


def test_a_row_shows_default_unit_range_and_meaning():
    assert table_of(Sample).splitlines()[2:] == [
        r'| `reach` | 0.6 | m | 0.01 .. 100 | distance \| range |',
        '| `above` | 2 | - | 0 .. inf | no upper limit |',
        '| `free` | -3.5 | N |  | no limit |',
        '| `active` | true | - |  | whether it runs |',
        '| `rule` | `plain` | - | `plain`, `fancy` | how it works |',
        '| `frame` | (empty) | - |  | name of the frame (read-only) |',
    ]


def test_only_configurations_that_a_module_defines_itself_are_found():
    assert configurations_in(sys.modules[__name__]) == [Sample]


def test_tables_stand_between_the_markers_and_nothing_else_changes():
    once = inserted(f'before\n{BEGIN}\nold\n{END}\nafter\n', 'TABLE')
    assert once == f'before\n{BEGIN}\n\nTABLE\n\n{END}\nafter\n'
    assert inserted(once, 'TABLE') == once


@pytest.mark.parametrize('text', ['', BEGIN, END, f'{END}{BEGIN}', f'{BEGIN}{BEGIN}{END}'])
def test_a_document_without_the_two_markers_in_order_is_refused(text):
    with pytest.raises(MarkerError, match='parameters:begin'):
        inserted(text, 'TABLE')


def test_the_command_writes_what_it_otherwise_prints(tmp_path, capsys):
    readme = tmp_path / 'README.md'
    readme.write_text(f'{BEGIN}\n{END}\n')
    main([__name__])
    printed = capsys.readouterr().out.strip()
    main([__name__, '--write', str(readme)])
    assert readme.read_text() == f'{BEGIN}\n\n{printed}\n\n{END}\n'
    assert printed == document_of([__name__]) and '`reach`' in printed
