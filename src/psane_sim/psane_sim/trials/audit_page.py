# SPDX-License-Identifier: Apache-2.0
"""Fills the page of the audit: what the words around it explain is measured, not typed."""

import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from psane_sim.errors import AuditError
from psane_sim.trials.audit_table import Row, as_markdown

PAGE, FIGURE = 'audit.md', 'audit.png'


def write_page(folder: Path, weaker: float, command: str, rows: Sequence[Row],
               table: dict[str, dict[str, Any]], figure: Path) -> None:
    """Replace the part of `audit.md` that tells of ground weaker by a share, and the figure.

    The figure of the page is that of ground as calibrated.

    Raises
    ------
    AuditError
        When the page has no such part.
    """
    page = folder / PAGE
    name = f'weaker {weaker:g}'
    part = re.compile(rf'(<!-- {re.escape(name)}:begin -->\n).*?(<!-- {re.escape(name)}:end -->)',
                      re.DOTALL)
    text = page.read_text() if page.exists() else ''
    if part.search(text) is None:
        raise AuditError(f'{page} has no part `<!-- {name}:begin -->` to write into')
    body = '\n'.join(['', f'`{command}`', '', as_markdown(table), _failures(rows), ''])
    page.write_text(part.sub(lambda found: found[1] + body + found[2], text))
    if weaker == 0.0:
        shutil.copyfile(figure, folder / FIGURE)


def command_of(trials: int, first_seed: int, weaker: float) -> str:
    """Return what is to be typed for the same audit."""
    words = ['./psane benchmark audit', f'--trials {trials}']
    words += [f'--first-seed {first_seed}'] if first_seed else []
    words += [f'--weaker {weaker:g}'] if weaker else []
    return ' '.join(words)


def _failures(rows: Sequence[Row]) -> str:
    """Return one line for each trial that could have gone well and did not."""
    failed = [row for row in rows if row['is_possible'] and not row['success']]
    if not failed:
        return 'Every trial with a way to the goal was a success.\n'
    lines = [f'- {row["family"]} {row["seed"]}: {row["ending"]} after {row["time_s"]:.0f} s '
             f'({row["cause"]}); coverage {row["coverage"]:.2f}, unsafe {row["unsafe_time_s"]:g} s'
             for row in failed]
    return 'Without success:\n\n' + '\n'.join(lines) + '\n'
