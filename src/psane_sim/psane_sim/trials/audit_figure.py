# SPDX-License-Identifier: Apache-2.0
"""Draws an audit: success and safety by family, calibration, and time against the optimum."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from psane_sim.runs.picture import INK, STYLE
from psane_sim.trials.audit_table import ALL, Row

matplotlib.use('Agg')
COLOURS = {'smooth': '#1f77b4', 'patchy': '#d95f02', 'corridors': '#5e3c99'}


def draw_audit(rows: Sequence[Row], table: dict[str, dict[str, Any]], path: Path) -> None:
    """Write the figure of an audit to `path`."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(10.4, 3.6), layout='constrained')
        success, calibration, times = figure.subplots(1, 3)
        _draw_success(success, table)
        _draw_calibration(calibration, table)
        _draw_times(times, rows)
        figure.savefig(path, dpi=160)


def _families(table: dict[str, dict[str, Any]]) -> list[str]:
    return [family for family in table if family != ALL]


def _draw_success(axes: Axes, table: dict[str, dict[str, Any]]) -> None:
    families = _families(table)
    shares = [100.0 * (table[family]['success_share'] or 0.0) for family in families]
    bars = axes.bar(families, shares, color=[COLOURS.get(family, INK) for family in families])
    for bar, family in zip(bars, families, strict=True):
        figures = table[family]
        axes.annotate(f'{bar.get_height():.1f} %\nunsafe {figures["unsafe_time_s"]:g} s\n'
                      f'n = {figures["possible"]}',
                      (bar.get_x() + bar.get_width() / 2.0, bar.get_height()), ha='center',
                      va='top', color='white', xytext=(0, -4), textcoords='offset points')
    axes.set(ylim=(0.0, 104.0), ylabel='success where there is a way [%]', title='Success')


def _draw_calibration(axes: Axes, table: dict[str, dict[str, Any]]) -> None:
    for family in _families(table):
        shares = table[family]['false_share_by_beta']
        betas = np.array([float(beta) for beta in shares])
        # A share of nothing at all cannot stand on a logarithmic axis: it is put at its foot.
        axes.semilogy(np.sqrt(betas), np.maximum(list(shares.values()), 1e-5), 'o-',
                      markersize=3, color=COLOURS.get(family, INK), label=family)
    axes.axhline(1e-3, color=INK, linewidth=0.6, linestyle=':')
    axes.set(xlabel='half width of the interval, sqrt(beta) [deviations]',
             ylabel='truly unsafe share of certified cells', title='Calibration',
             ylim=(7e-6, 1.0))
    axes.legend(frameon=False)


def _draw_times(axes: Axes, rows: Sequence[Row]) -> None:
    for family in sorted({row['family'] for row in rows}):
        done = [row for row in rows
                if row['family'] == family and row['success'] and row['least_time_s']]
        axes.plot([row['least_time_s'] for row in done], [row['time_s'] for row in done], '.',
                  markersize=3, color=COLOURS.get(family, INK), label=family)
    top = max([row['least_time_s'] or 0.0 for row in rows], default=1.0)
    for factor in (1.0, 2.0):
        axes.plot((0.0, top), (0.0, factor * top), color=INK, linewidth=0.5, linestyle=':')
    axes.set(xlabel='least time over known ground [s]', ylabel='time taken [s]',
             title='Time against the optimum')
    axes.legend(frameon=False)
