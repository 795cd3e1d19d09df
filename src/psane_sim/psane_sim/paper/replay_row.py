# SPDX-License-Identifier: Apache-2.0
"""Run one row of the paper's experiments again, and compare what comes out byte for byte.

`psane benchmark replay DIR ROW --at SECONDS` also draws the planning cycle at that time.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from psane_sim.errors import PaperError
from psane_sim.paper.pipeline_picture import draw_pipeline
from psane_sim.paper.settings import THRESHOLD, PaperSettings, document_of, fingerprint_of
from psane_sim.paper.task import PaperTask, PaperTrial, Robot
from psane_sim.paper.trial import row_of, run_to_summary
from psane_sim.runs.run_data import read_run
from psane_sim.runs.run_watch import RunWatch
from psane_sim.trials.steady_pool import run_steadily
from psane_sim.trials.trial_folder import Row, TrialFolder

HELP = 'run a row of the paper again and compare its summary byte for byte'

SAME, OTHER = 0, 1
"""Exit statuses."""

Replayed = tuple[Row, bytes | None]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what can be asked for."""
    parser.add_argument('folder', type=Path, metavar='DIR', help="the experiment's folder")
    parser.add_argument('row', metavar='ROW', help='name of the row, such as '
                        'goal_env1-psane_geodesic-0')
    parser.add_argument('--at', type=float, metavar='S',
                        help='draw the planning cycle after this simulated time [s]')
    parser.add_argument('--out', type=Path, metavar='PNG',
                        help='where to draw it (default DIR/pipeline_ROW_S.png)')


def run(options: argparse.Namespace) -> int:
    """Replay a row; return 0 when its summary is the same, 1 when it is another."""
    if not options.folder.is_dir():
        raise PaperError(f'{options.folder} is no folder; expected one that psane benchmark '
                         'paper has written')
    row = TrialFolder(options.folder).row(options.row)
    trial, shared = trial_of(row)
    results = run_steadily(_replay, [(trial, options.at)], shared, 1, _given_up)
    again, arrays = next(iter(results))
    same = _report(row, again)
    if options.at is not None and arrays is not None:
        _draw(row, arrays, options)
    return SAME if same else OTHER


def trial_of(row: Row) -> tuple[PaperTrial, PaperSettings]:
    """Return the trial that a row was made from.

    Raises
    ------
    PaperError
        When this version of the program would run it with another configuration.
    """
    stored: dict[str, Any] = row['configuration']
    plain = stored['trial']
    trial = PaperTrial(
        task=PaperTask(**plain['task']), strategy=plain['strategy'], seed=plain['seed'],
        robot=Robot(plain['robot']), study=plain['study'], variant=plain['variant'],
        changes=tuple((name, value) for name, value in plain['changes']))
    shared = PaperSettings(preset=stored['preset'])
    if fingerprint_of(document_of(trial, shared)) != fingerprint_of(stored):
        raise PaperError(f'{row["name"]} was run with parameters that are not those of this '
                         f'version ({row["versions"]["source"]} was its source)')
    return trial, shared


def summary_bytes(row: Row) -> bytes:
    """Return a row's summary as it is compared."""
    return json.dumps(row['summary'], indent=1, sort_keys=True).encode()


def _replay(asked: tuple[PaperTrial, float | None], shared: PaperSettings) -> Replayed:
    trial, moment = asked
    summary, data, _ = run_to_summary(trial, shared, RunWatch(moment))
    return row_of(trial, shared, summary), data.arrays


def _given_up(asked: tuple[PaperTrial, float | None], shared: PaperSettings) -> Replayed:
    raise PaperError(f'the process that replayed {asked[0].name} died')


def _report(row: Row, again: Row) -> bool:
    """Say whether two rows have the same summary, and what differs if not."""
    changed = {name: (value, again['versions'].get(name))
               for name, value in row['versions'].items()
               if again['versions'].get(name) != value}
    for name, (old, new) in changed.items():
        print(f'{name} was {old} and is {new}', file=sys.stderr)
    if summary_bytes(row) == summary_bytes(again):
        print(f'{row["name"]}: the same summary, byte for byte')
        return True
    print(f'{row["name"]}: another summary')
    for name in sorted({*row['summary'], *again['summary']}):
        old, new = row['summary'].get(name), again['summary'].get(name)
        if old != new:
            print(f'  {name}: {old} -> {new}')
    return False


def _draw(row: Row, arrays: bytes, options: argparse.Namespace) -> None:
    stored = read_run(arrays)
    if not stored.moments:
        raise PaperError(f'{row["name"]} has no planning cycle with a frontier after '
                         f'{options.at:g} s')
    moment = stored.moments[0]
    path = options.out or options.folder / f'pipeline_{row["name"]}_{options.at:g}.png'
    planner = row['configuration']['settings']['planner']
    draw_pipeline(stored, moment, planner[THRESHOLD.partition('.')[2]],
                  f'{row["name"]} after {float(moment["time"]):.1f} s', path)
    print(f'drawn: {path}')
