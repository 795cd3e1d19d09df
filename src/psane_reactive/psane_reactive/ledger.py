# SPDX-License-Identifier: Apache-2.0
"""Results of a long measurement, kept as they come, so that it can be broken off and resumed."""

import hashlib
import json
from pathlib import Path
from typing import Any

Row = dict[str, Any]


def fingerprint() -> str:
    """Return a hash of the package's source: results of other code are not resumed."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob('*.py')):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


class Ledger:
    """Rows by part and trial, one JSON object a line.

    Parameters
    ----------
    path : Path or None
        None keeps rows in memory only. A file that other code has written is begun anew.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._rows: dict[tuple[str, str], Row] = {}
        if path is None:
            return
        lines = path.read_text().splitlines() if path.exists() else []
        head = json.dumps({'code': fingerprint()})
        if not lines or lines[0] != head:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(head + '\n')
            return
        for line in lines[1:]:
            try:
                row = json.loads(line)
            except ValueError:
                # The line that was being written when the run was broken off.
                continue
            self._rows[row['part'], row['trial']] = row

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self._rows)

    def row(self, part: str, trial: str) -> Row | None:
        """Return what was found for a trial, None when it was not made yet."""
        return self._rows.get((part, trial))

    def add(self, part: str, trial: str, row: Row) -> None:
        """Keep what was found for a trial."""
        row = {'part': part, 'trial': trial, **row}
        self._rows[part, trial] = row
        if self._path is not None:
            with self._path.open('a') as file:
                file.write(json.dumps(row) + '\n')
