# SPDX-License-Identifier: Apache-2.0
"""Draws a run: the true ground, what was certified of it, and the way the robot took."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from psane_mapping.grid import FloatArray, Grid
from psane_sim.runs.run_record import RunRecord
from psane_sim.terrains.terrain import Terrain

matplotlib.use('Agg')
INK = '#1b1b1b'
CERTIFIED = '#00d5a0'
PATH = '#1b1b1b'
STYLE = {'font.size': 8, 'axes.titlesize': 9, 'axes.titleweight': 'bold', 'axes.edgecolor': INK,
         'axes.linewidth': 0.6, 'xtick.major.width': 0.6, 'ytick.major.width': 0.6}


def draw_run(record: RunRecord, terrain: Terrain, threshold: float, title: str,
             path: Path) -> None:
    """Write the picture of a run to `path` (the suffix says the format: png, pdf, svg).

    Parameters
    ----------
    threshold : float
        Largest safe slip [-]; drawn as a contour of the true field.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(10.4, 6.6), layout='constrained')
        axes: dict[str, Axes] = figure.subplot_mosaic(
            [['truth', 'truth', 'mean'], ['truth', 'truth', 'std'], ['truth', 'truth', 'time']],
            width_ratios=[1.0, 1.0, 0.9], height_ratios=[1.0, 1.0, 0.75])
        _draw_truth(axes['truth'], figure, record, terrain, threshold, title)
        _draw_map(axes['mean'], figure, record, record.slip_mean, 'Slip, posterior mean', 'turbo')
        _draw_map(axes['std'], figure, record, record.slip_std, 'Slip, posterior std', 'viridis')
        _draw_progress(axes['time'], record)
        figure.savefig(path, dpi=160)


def _extent(grid: Grid) -> tuple[float, float, float, float]:
    return (grid.origin_x, grid.origin_x + grid.columns * grid.resolution,
            grid.origin_y, grid.origin_y + grid.rows * grid.resolution)


def _draw_truth(axes: Axes, figure: Figure, record: RunRecord, terrain: Terrain,
                threshold: float, title: str) -> None:
    grid = record.grid
    slip = terrain.true_slip(grid.points).reshape(grid.shape)
    image = axes.imshow(slip, origin='lower', extent=_extent(grid), cmap='turbo', vmin=0.0,
                        vmax=1.0, alpha=0.62, interpolation='bilinear')
    figure.colorbar(image, ax=axes, shrink=0.75, pad=0.01, label='true slip [-]')
    axes.contour(grid.x, grid.y, slip, levels=[threshold], colors='#b00020', linewidths=1.1,
                 linestyles='dashed')
    _outline_certified(axes, record, 1.6)
    _draw_path(axes, record)
    axes.set(title=title, xlabel='x [m]', ylabel='y [m]', aspect='equal')
    axes.legend(handles=_legend(threshold), loc='upper center', bbox_to_anchor=(0.5, -0.075),
                ncols=5, frameon=False, fontsize=7.5, handletextpad=0.4, columnspacing=1.4)


def _outline_certified(axes: Axes, record: RunRecord, width: float) -> None:
    if record.certified is None or not record.certified.any():
        return
    grid = record.grid
    axes.contour(grid.x, grid.y, record.certified.astype(float), levels=[0.5],
                 colors=CERTIFIED, linewidths=width)


def _draw_path(axes: Axes, record: RunRecord) -> None:
    if record.contacts:
        contacts = np.array(record.contacts)
        axes.scatter(contacts[:, 1], contacts[:, 2], c=contacts[:, 3], cmap='turbo', vmin=0.0,
                     vmax=1.0, s=7, linewidths=0.25, edgecolors='white', zorder=3)
    if len(record.frontier):
        axes.scatter(record.frontier[:, 0], record.frontier[:, 1], s=5, marker='s',
                     color='#ffffff', linewidths=0.3, edgecolors=INK, zorder=3)
    if record.path:
        path = np.array(record.path)
        axes.plot(path[:, 1], path[:, 2], color=PATH, linewidth=1.5, zorder=4)
        axes.plot(path[-1, 1], path[-1, 2], 'o', color='#d7191c', markersize=7, zorder=6,
                  markeredgecolor='white')
    for count, (_, x, y) in enumerate(record.subgoals, start=1):
        axes.plot(x, y, 'D', color='#7b3294', markersize=4, markeredgecolor='white',
                  markeredgewidth=0.5, zorder=5)
        if len(record.subgoals) <= 40:
            axes.annotate(str(count), (x, y), xytext=(3, 3), textcoords='offset points',
                          fontsize=5.5, color='#7b3294', zorder=5)
    _draw_ends(axes, record.start, record.goal)


def _draw_ends(axes: Axes, start: FloatArray, goal: FloatArray | None) -> None:
    axes.plot(start[0], start[1], 'o', color='#1a9641', markersize=8, markeredgecolor='white',
              zorder=6)
    if goal is not None:
        axes.plot(goal[0], goal[1], '*', color='#ffd700', markersize=15, markeredgecolor=INK,
                  zorder=6)


def _legend(threshold: float) -> list[Line2D]:
    def marker(symbol: str, colour: str, label: str, edge: str = 'white') -> Line2D:
        return Line2D([], [], marker=symbol, color='none', markerfacecolor=colour,
                      markeredgecolor=edge, markersize=7, label=label)
    return [
        marker('o', '#1a9641', 'start'), marker('o', '#d7191c', 'end'),
        marker('*', '#ffd700', 'goal', INK),
        Line2D([], [], color=PATH, linewidth=1.5, label='path'),
        marker('D', '#7b3294', 'subgoals, in order'),
        marker('o', '#888888', 'contacts, by felt slip'),
        marker('s', '#ffffff', 'frontier', INK),
        Line2D([], [], color=CERTIFIED, linewidth=1.6, label='certified'),
        Line2D([], [], color='#b00020', linestyle='dashed', label=f'true slip = {threshold:g}'),
    ]


def _draw_map(axes: Axes, figure: Figure, record: RunRecord, values: FloatArray | None,
              title: str, colours: str) -> None:
    axes.set(title=title, aspect='equal', xticks=[0, 5, 10], yticks=[0, 5, 10])
    if values is None:
        return
    top = 1.0 if colours == 'turbo' else float(np.nanmax(values))
    image = axes.imshow(values, origin='lower', extent=_extent(record.grid), cmap=colours,
                        vmin=0.0, vmax=top)
    figure.colorbar(image, ax=axes, shrink=0.9, pad=0.02, label='[-]')
    _outline_certified(axes, record, 1.0)


def _draw_progress(axes: Axes, record: RunRecord) -> None:
    axes.set(title='Progress', xlabel='time [s]')
    if not record.progress:
        return
    time, distance, area = np.array(record.progress).T
    axes.plot(time, area, color='#008a68', linewidth=1.3)
    axes.set_ylabel('certified [m²]', color='#008a68')
    axes.set_ylim(bottom=0.0)
    if record.goal is not None:
        twin = axes.twinx()
        twin.plot(time, distance, color='#7b3294', linewidth=1.3)
        twin.set_ylabel('to the goal [m]', color='#7b3294')
        twin.set_ylim(bottom=0.0)
