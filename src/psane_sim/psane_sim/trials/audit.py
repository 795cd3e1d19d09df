# SPDX-License-Identifier: Apache-2.0
"""Many random terrains: how often it works, and whether it is ever unsafe.

`psane benchmark audit --trials 1000` runs the kinematic stand-in on terrains of three families.
Each finished trial is a line of `trials.jsonl`; an audit that was broken off goes on from there.
"""

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from psane_planner.configuration import STRATEGIES, PlannerConfiguration
from psane_sim.errors import AuditError
from psane_sim.terrains.random_terrain import FAMILIES
from psane_sim.trials.audit_figure import draw_audit
from psane_sim.trials.audit_page import command_of, write_page
from psane_sim.trials.audit_table import Row, as_markdown, summarise_rows
from psane_sim.trials.audit_trial import AuditSettings, Trial, run_trial
from psane_sim.trials.trial_pool import run_locally, run_on_cluster

HELP = 'random terrains with the kinematic robot: success, safety, calibration, time'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what an audit can be asked for."""
    parser.add_argument('--trials', type=int, default=1000, metavar='N',
                        help='number of terrains, shared by the families (default 1000)')
    parser.add_argument('--families', nargs='+', choices=[*FAMILIES], default=[*FAMILIES],
                        help='kinds of terrain (default: all)')
    parser.add_argument('--first-seed', type=int, default=0, metavar='N',
                        help='seed of the first terrain of each family (default 0)')
    parser.add_argument('--strategy', choices=STRATEGIES, default=PlannerConfiguration.strategy,
                        help='how subgoals are chosen (default psane_geodesic)')
    parser.add_argument('--weaker', type=float, default=0.0, metavar='SHARE',
                        help='ground that is weaker than touch says, by this share (default 0)')
    parser.add_argument('--noise', type=float, default=1.0, metavar='FACTOR',
                        help='what all noise and bias of the touch is multiplied by (default 1)')
    parser.add_argument('--duration', type=float, default=900.0, metavar='S',
                        help='simulated time after which a trial ends [s] (default 900)')
    parser.add_argument('--workers', type=int, default=os.cpu_count() or 1, metavar='N',
                        help='processes on this machine (default: its cores)')
    parser.add_argument('--scheduler', metavar='ADDRESS',
                        help='a Dask scheduler, such as tcp://host:8786 (default: this machine)')
    parser.add_argument('--out', type=Path, default=Path('out/audit'), metavar='DIR',
                        help='where trials, table and figure go (default out/audit)')
    parser.add_argument('--page', type=Path, metavar='FOLDER',
                        help="also fill this audit's part of FOLDER/audit.md, with its figure")
    parser.add_argument('--json', action='store_true',
                        help='the table as one JSON object on standard output')


def run(options: argparse.Namespace) -> int:
    """Run what is missing of the audit, and write table and figure; return the exit status."""
    if options.trials < 1 or options.workers < 1 or not 0.0 <= options.weaker < 1.0:
        raise AuditError(f'--trials {options.trials} --workers {options.workers} --weaker '
                         f'{options.weaker:g}, expected at least 1, at least 1, and [0, 1)')
    if not 0.0 <= options.noise <= 20.0:
        raise AuditError(f'--noise {options.noise:g}, expected 0 to 20')
    if options.page is not None and options.noise != 1.0:
        raise AuditError(f'--page with --noise {options.noise:g}, expected --noise 1')
    settings = AuditSettings(duration=options.duration, weaker=options.weaker, noise=options.noise,
                             planner=PlannerConfiguration(strategy=options.strategy))
    trials = trials_of(options.families, options.trials, options.first_seed)
    options.out.mkdir(parents=True, exist_ok=True)
    rows = _run_missing(trials, settings, options)
    table = summarise_rows(rows)
    (options.out / 'table.md').write_text(as_markdown(table))
    (options.out / 'table.json').write_text(json.dumps(table, indent=2) + '\n')
    draw_audit(rows, table, options.out / 'audit.png')
    if options.page is not None:
        command = command_of(options.trials, options.first_seed, options.weaker)
        write_page(options.page, options.weaker, command, rows, table, options.out / 'audit.png')
    print(json.dumps(table, indent=2) if options.json else as_markdown(table))
    print(f'written to {options.out}', file=sys.stderr)
    return 0


def trials_of(families: list[str], count: int, first_seed: int) -> list[Trial]:
    """Return `count` trials, the families in turn."""
    return [Trial(families[k % len(families)], first_seed + k // len(families))
            for k in range(count)]


def _run_missing(trials: list[Trial], settings: AuditSettings, options: argparse.Namespace
                 ) -> list[Row]:
    """Return the rows of all trials, having run those that the folder does not hold yet."""
    path = options.out / 'trials.jsonl'
    known = read_rows(path, settings.fingerprint)
    missing = [trial for trial in trials if trial not in known]
    if len(missing) < len(trials):
        print(f'{len(trials) - len(missing)} of {len(trials)} trials are there already',
              file=sys.stderr)
    bar = ProgressBar(len(missing))
    with path.open('a') as file:
        for row in _rows_of(missing, settings, options):
            file.write(json.dumps({'settings': settings.fingerprint, **row}) + '\n')
            file.flush()
            known[Trial(row['family'], row['seed'])] = row
            bar.advance()
    bar.close()
    return [known[trial] for trial in trials]


def _rows_of(missing: list[Trial], settings: AuditSettings, options: argparse.Namespace
             ) -> Iterator[Row]:
    if not missing:
        return iter(())
    if options.scheduler is not None:
        return run_on_cluster(run_trial, missing, settings, options.scheduler)
    return run_locally(run_trial, missing, settings, options.workers)


def read_rows(path: Path, fingerprint: str) -> dict[Trial, Row]:
    """Return the trials that a file holds.

    Raises
    ------
    AuditError
        When they were run with other settings.
    """
    rows: dict[Trial, Row] = {}
    if not path.exists():
        return rows
    for line in path.read_text().splitlines():
        try:
            row: dict[str, Any] = json.loads(line)
        except ValueError:
            # The line that was being written when the audit was broken off.
            continue
        if row.pop('settings') != fingerprint:
            raise AuditError(f'{path} holds trials with other settings; take another --out, or '
                             'remove the file')
        rows[Trial(row['family'], row['seed'])] = row
    return rows


class ProgressBar:
    """A bar on a terminal; elsewhere a line for every twentieth of the work."""

    def __init__(self, total: int) -> None:
        self._total = total
        self._done = 0
        self._began = time.monotonic()
        self._is_terminal = sys.stderr.isatty()

    def advance(self) -> None:
        """Count one more trial."""
        self._done += 1
        passed = time.monotonic() - self._began
        left = passed / self._done * (self._total - self._done)
        filled = 30 * self._done // self._total
        line = (f'[{"#" * filled}{"." * (30 - filled)}] {self._done}/{self._total}  '
                f'{passed:.0f} s, about {left:.0f} s left')
        step = max(1, self._total // 20)
        if self._is_terminal:
            print(f'\r{line}  ', end='', file=sys.stderr, flush=True)
        elif self._done % step == 0 or self._done == self._total:
            print(line, file=sys.stderr, flush=True)

    def close(self) -> None:
        """End the line."""
        if self._is_terminal and self._done:
            print(file=sys.stderr)
