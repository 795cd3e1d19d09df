# SPDX-License-Identifier: Apache-2.0
"""What the trials of an audit add up to: one line for each family, and one for all."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from psane_sim.trials.audit_trial import BETAS

Row = dict[str, Any]

ALL = 'all'

MARGIN = 0.1
"""Slip by which what can be certified stays below the threshold: two deviations of the map where
many contacts were felt, one of the error that they share, and what rounding adds [-]."""


def summarise_rows(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Return figures by family, and under 'all' those of all trials."""
    families = sorted({row['family'] for row in rows})
    table = {family: _figures([row for row in rows if row['family'] == family])
             for family in families}
    table[ALL] = _figures(rows)
    return table


def _figures(rows: Sequence[Row]) -> dict[str, Any]:
    possible = [row for row in rows if row['is_possible']]
    cautious = [row for row in possible if (row['margin'] or 0.0) >= MARGIN]
    arrived = [row for row in possible if row['success'] and row['least_time_s']]
    certified = sum(row['certified_cells'] for row in rows)
    ratios = [row['time_s'] / row['least_time_s'] for row in arrived]
    lengths = [row['path_m'] / row['least_length_m'] for row in arrived]
    return {
        'trials': len(rows),
        'possible': len(possible),
        'success_share': _share(sum(row['success'] for row in possible), len(possible)),
        'possible_with_margin': len(cautious),
        'success_share_with_margin': _share(sum(row['success'] for row in cautious),
                                            len(cautious)),
        'trials_with_unsafe_time': sum(row['unsafe_time_s'] > 0.0 for row in rows),
        'unsafe_time_s': round(sum(row['unsafe_time_s'] for row in rows), 2),
        'unsafe_foot_share': _mean([row['unsafe_foot_share'] for row in rows]),
        'false_certified_share': _share(sum(row['false_certified_cells'] for row in rows),
                                        certified),
        'without_reason': sum(not row['cause'] for row in rows),
        'endings': dict(sorted(Counter(row['ending'] for row in rows).items())),
        'median_time_s': _median([row['time_s'] for row in arrived]),
        'median_time_ratio': _median(ratios),
        'median_length_ratio': _median(lengths),
        'false_share_by_beta': calibration(rows),
        'cpu_per_trial_s': _mean([row['cpu_s'] for row in rows]),
        'wall_per_trial_s': _mean([row['wall_s'] for row in rows]),
    }


def calibration(rows: Sequence[Row]) -> dict[str, float]:
    """Return, by beta, the truly unsafe share of what the trials' last maps would certify."""
    counts = np.array([row['calibration'] for row in rows], dtype=float).sum(axis=0)
    return {f'{beta:g}': float(false / max(certified, 1.0))
            for beta, (certified, false) in zip(BETAS, counts, strict=True)}


def _share(part: float, whole: float) -> float | None:
    return None if whole == 0 else round(part / whole, 6)


def _mean(values: Sequence[float]) -> float | None:
    return round(float(np.mean(values)), 6) if len(values) else None


def _median(values: Sequence[float]) -> float | None:
    return round(float(np.median(values)), 4) if len(values) else None


COLUMNS = {
    'trials': 'trials', 'possible': 'possible', 'success': 'success_share',
    'success with margin': 'success_share_with_margin',
    'unsafe [s]': 'unsafe_time_s', 'unsafe trials': 'trials_with_unsafe_time',
    'unsafe feet': 'unsafe_foot_share', 'false cells': 'false_certified_share',
    'time [s]': 'median_time_s', 'time ratio': 'median_time_ratio',
    'length ratio': 'median_length_ratio', 'processor time [s]': 'cpu_per_trial_s',
}
"""Heading and figure of each column of the printed table."""


def as_markdown(table: dict[str, dict[str, Any]]) -> str:
    """Return the table as Markdown."""
    lines = ['| terrain | ' + ' | '.join(COLUMNS) + ' |', '|---' * (len(COLUMNS) + 1) + '|']
    for family, figures in table.items():
        cells = [_text(figures[name]) for name in COLUMNS.values()]
        lines.append(f'| {family} | ' + ' | '.join(cells) + ' |')
    endings = ', '.join(f'{name} {count}' for name, count in table[ALL]['endings'].items())
    return '\n'.join([*lines, '', f'Endings: {endings}.', ''])


def _text(value: Any) -> str:
    if value is None:
        return '-'
    return f'{value:.4g}' if isinstance(value, float) else str(value)
