# SPDX-License-Identifier: Apache-2.0
"""The folder of an experiment: one row and one run for each trial, written whole or not at all."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from psane_mapping.sample_file import write_whole
from psane_sim.errors import PaperError
from psane_sim.paper.settings import PaperSettings, document_of, fingerprint_of
from psane_sim.paper.task import PaperTrial
from psane_sim.runs.run_data import RunData, StoredRun, read_run

Row = dict[str, Any]


class TrialFolder:
    """Rows in `rows/NAME.json`, runs in `runs/NAME.npz`, contacts in `runs/NAME.map`.

    Parameters
    ----------
    path : Path
        Made if it is not there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        for name in ('rows', 'runs'):
            (path / name).mkdir(parents=True, exist_ok=True)

    def write(self, row: Row, data: RunData | None) -> None:
        """Keep a trial; its row is written last, so that a row always has its run."""
        runs, name = self.path / 'runs', row['name']
        if data is not None:
            write_whole(runs / f'{name}.npz', data.arrays)
            write_whole(runs / f'{name}.map', data.contacts)
        text = json.dumps(row, indent=1, sort_keys=True) + '\n'
        write_whole(self._row_file(name), text.encode())

    def row(self, name: str) -> Row:
        """Return a row by its name.

        Raises
        ------
        PaperError
            Listing the rows there are.
        """
        path = self._row_file(name)
        if not path.is_file():
            raise PaperError(f'no row {name!r} in {self.path}; available: {self.names()}')
        row: Row = json.loads(path.read_text())
        return row

    def names(self) -> list[str]:
        """Return the names of all rows."""
        return sorted(path.stem for path in (self.path / 'rows').glob('*.json'))

    def run(self, name: str) -> StoredRun | None:
        """Return what is kept of a run; None for a trial that failed."""
        path = self.path / 'runs' / f'{name}.npz'
        return read_run(path.read_bytes()) if path.is_file() else None

    def known(self, trials: Sequence[PaperTrial], shared: PaperSettings) -> dict[str, Row]:
        """Return, by name, the rows that are there of some trials.

        Raises
        ------
        PaperError
            When one was run with another configuration.
        """
        rows: dict[str, Row] = {}
        for trial in trials:
            if not self._row_file(trial.name).is_file():
                continue
            row = self.row(trial.name)
            asked = document_of(trial, shared)
            if fingerprint_of(row['configuration']) != fingerprint_of(asked):
                raise PaperError(f'{self._row_file(trial.name)} was run with another '
                                 'configuration; take another --out, or remove the folder')
            rows[trial.name] = row
        return rows

    def _row_file(self, name: str) -> Path:
        return self.path / 'rows' / f'{name}.json'
