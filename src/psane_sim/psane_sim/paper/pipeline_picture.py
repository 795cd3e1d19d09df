# SPDX-License-Identifier: Apache-2.0
"""One planning cycle in six pictures, as the paper draws it.

Slip and its uncertainty, the safety map with the frontier, then what speaks for each frontier
cell: expansion probability, goal value and both together.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, Grid
from psane_sim.paper.figures import draw_certified, extent_of
from psane_sim.runs.picture import INK, STYLE
from psane_sim.runs.run_data import StoredRun

matplotlib.use('Agg')

Moment = Mapping[str, NDArray[Any]]
UNKNOWN, UNSAFE, SAFE = 0, 1, 2
SAFETY_COLOURS = ListedColormap(['#e3e3e3', '#d6604d', '#a6d96a'])


def draw_pipeline(run: StoredRun, moment: Moment, threshold: float, title: str,
                  path: Path) -> None:
    """Write the picture of one moment of a run (as in `StoredRun.moments`)."""
    grid = run.grid
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(10.2, 6.5), layout='constrained')
        axes = figure.subplots(2, 3).ravel()
        _draw_field(figure, axes[0], grid, moment['slip_mean'], 'A  slip, posterior mean',
                    'turbo', 1.0)
        _draw_field(figure, axes[1], grid, moment['slip_std'], 'B  its standard deviation',
                    'viridis', None)
        _draw_safety(axes[2], grid, moment, threshold)
        for panel, name, heading in (
                (axes[3], 'expansion', 'D  expansion probability $P_e$'),
                (axes[4], 'goal_value', 'E  goal value $V_{goal}$'),
                (axes[5], 'overall', 'F  overall score $V_{goal} P_e$')):
            _draw_scores(figure, panel, grid, moment, name, heading)
        for panel in axes:
            _draw_robot(panel, run, moment)
        figure.suptitle(title)
        figure.savefig(path, dpi=140)


def _frame(axes: Axes, title: str) -> None:
    axes.set(title=title, aspect='equal', xlim=(0, 10), ylim=(0, 10), xticks=[0, 5, 10],
             yticks=[0, 5, 10])


def _draw_field(figure: Figure, axes: Axes, grid: Grid, values: FloatArray, title: str,
                colours: str, top: float | None) -> None:
    image = axes.imshow(values, origin='lower', extent=extent_of(grid), cmap=colours, vmin=0.0,
                        vmax=float(np.nanmax(values)) if top is None else top)
    figure.colorbar(image, ax=axes, shrink=0.85, label='[-]')
    _frame(axes, title)


def _draw_safety(axes: Axes, grid: Grid, moment: Moment, threshold: float) -> None:
    """Draw certified, known unsafe and unknown ground, the frontier and its Pareto front."""
    state = np.full(grid.shape, UNKNOWN)
    state[moment['lower'] > threshold] = UNSAFE
    state[moment['certified']] = SAFE
    axes.imshow(state, origin='lower', extent=extent_of(grid), cmap=SAFETY_COLOURS, vmin=0,
                vmax=2, interpolation='nearest')
    if 'points' in moment:
        points, front = moment['points'], moment['pareto']
        axes.plot(*points.T, 's', color='#2b5c8a', markersize=1.8, label='frontier')
        axes.plot(*points[front].T, 'o', color='#ff7f00', markersize=3.6, markeredgecolor=INK,
                  markeredgewidth=0.3, label='Pareto front')
    for colour, label in (('#a6d96a', 'certified'), ('#d6604d', 'known unsafe'),
                          ('#e3e3e3', 'unknown')):
        axes.plot([], [], 's', color=colour, label=label)
    # Beside the map: nowhere on it is there a place where no run ever goes.
    axes.legend(loc='upper center', bbox_to_anchor=(0.5, -0.09), ncols=3, fontsize=6,
                frameon=False, columnspacing=1.0, handletextpad=0.3)
    _frame(axes, 'C  safety map and frontier')


def _draw_scores(figure: Figure, axes: Axes, grid: Grid, moment: Moment, name: str,
                 title: str) -> None:
    draw_certified(axes, grid, moment['certified'], '#cccccc', 0.5)
    if 'points' in moment:
        points, values = moment['points'], moment[name]
        eligible = moment['eligible']
        axes.plot(*points[~eligible].T, '.', color='#bbbbbb', markersize=2)
        if eligible.any():
            # A single scale from 0, so that a flat score looks flat.
            image = axes.scatter(points[eligible, 0], points[eligible, 1], c=values[eligible],
                                 cmap='plasma', s=6, vmin=0.0,
                                 vmax=max(float(values[eligible].max()), 1e-6))
            figure.colorbar(image, ax=axes, shrink=0.85, label='[-]')
    _frame(axes, title)


def _draw_robot(axes: Axes, run: StoredRun, moment: Moment) -> None:
    walked = run.path[run.path[:, 0] <= float(moment['time'])]
    axes.plot(walked[:, 1], walked[:, 2], color=INK, linewidth=0.8)
    axes.plot(*moment['position'], 'o', color='#d7191c', markersize=5, markeredgecolor='white')
    if np.isfinite(moment['goal']).all():
        axes.plot(*moment['goal'], '*', color='#ffd700', markersize=11, markeredgecolor=INK,
                  markeredgewidth=0.6)
    if np.isfinite(moment['subgoal']).all():
        axes.plot(*moment['subgoal'], 'X', color='#7b3294', markersize=7,
                  markeredgecolor='white', markeredgewidth=0.6)
