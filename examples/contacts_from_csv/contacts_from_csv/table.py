# SPDX-License-Identifier: Apache-2.0
"""The table of stances: one row a sample, all rows of a stance together."""

import csv
from dataclasses import dataclass, field
from pathlib import Path

CHANNELS = ('forward', 'vertical', 'moment')
STANCE_COLUMNS = ('stance', 'leg', 'touch_down', 'lift_off', 'x', 'y', 'point_deviation',
                  'has_velocity')
SAMPLE_COLUMNS = ('depth', *(f'{kind}_{channel}' for kind in ('measured', 'response', 'deviation')
                             for channel in CHANNELS))


@dataclass
class Stance:
    """One stance: what every row repeats, and the samples by the name of their column.

    Parameters
    ----------
    leg : int
    touch_down, lift_off : float [s]
    x, y, point_deviation : float, map frame [m]
    has_velocity : bool
    samples : dict of str to list of float
        Depth [m]; measured, response and deviation of each channel [N].
    """

    leg: int
    touch_down: float
    lift_off: float
    x: float
    y: float
    point_deviation: float
    has_velocity: bool
    samples: dict[str, list[float]] = field(
        default_factory=lambda: {name: [] for name in SAMPLE_COLUMNS})


def read_table(path: Path) -> list[Stance]:
    """Return the stances of a table in the order of lift-off.

    Raises
    ------
    ValueError
        For a column that is missing or a cell that is no number, with its line.
    """
    stances: dict[str, Stance] = {}
    with path.open(newline='', encoding='utf-8') as file:
        rows = csv.DictReader(line for line in file if not line.startswith('#'))
        missing = {*STANCE_COLUMNS, *SAMPLE_COLUMNS} - set(rows.fieldnames or ())
        if missing:
            raise ValueError(f'{path}: columns {sorted(missing)} are missing')
        for number, row in enumerate(rows, start=1):
            try:
                _add(stances, row)
            except (TypeError, ValueError) as error:
                raise ValueError(f'{path}, row {number}: {error}') from error
    return sorted(stances.values(), key=lambda stance: stance.lift_off)


def _add(stances: dict[str, Stance], row: dict[str, str]) -> None:
    if row['stance'] not in stances:
        stances[row['stance']] = Stance(
            leg=int(row['leg']), touch_down=float(row['touch_down']),
            lift_off=float(row['lift_off']), x=float(row['x']), y=float(row['y']),
            point_deviation=float(row['point_deviation']),
            has_velocity=row['has_velocity'] == '1')
    for name, values in stances[row['stance']].samples.items():
        values.append(float(row[name]))
