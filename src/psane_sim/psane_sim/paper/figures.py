# SPDX-License-Identifier: Apache-2.0
"""The paper's figures: paths over the true slip, bars, coverage over time, certified ground."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, Grid
from psane_sim.paper.groups import Group, Quantity, quantity_named
from psane_sim.paper.published import published_for
from psane_sim.paper.task import title_of
from psane_sim.runs.picture import CERTIFIED, INK, STYLE
from psane_sim.runs.run_data import StoredRun
from psane_sim.terrains.terrain import Terrain

matplotlib.use('Agg')

COLOURS = {'psane_geodesic': '#1b9e77', 'psane': '#2166ac', 'pgh': '#e08214', 'sgh': '#7b3294',
           'ngh': '#b2182b'}
SLIP_COLOURS = 'RdYlBu_r'
UNSAFE_LINE = '#5c0011'

GOAL_BARS = ('success', 'time_s', 'path_m', 'unsafe_time_s', 'false_certified_cells')
EXPLORE_BARS = ('coverage', 'time_s', 'path_m', 'unsafe_time_s', 'false_certified_cells')
"""What is drawn of tasks with a goal, and without."""

SHARES = ('success', 'coverage')
"""Quantities that cannot exceed 1."""

Runs = Callable[[str], StoredRun | None]
"""Returns the run of a row by its name."""


def colour_of(strategy: str) -> str:
    """Return the colour that a strategy has in every figure."""
    return COLOURS.get(strategy, '#666666')


def extent_of(grid: Grid) -> tuple[float, float, float, float]:
    """Return west, east, south and north of a grid's cells [m]."""
    half = 0.5 * grid.resolution
    return (float(grid.x[0]) - half, float(grid.x[-1]) + half,
            float(grid.y[0]) - half, float(grid.y[-1]) + half)


def draw_ground(axes: Axes, terrain: Terrain, threshold: float) -> None:
    """Draw the true slip, and the line beyond which it is unsafe."""
    grid = terrain.grid
    axes.imshow(terrain.slip, origin='lower', extent=extent_of(grid), cmap=SLIP_COLOURS,
                vmin=0.0, vmax=1.0, interpolation='bilinear', alpha=0.75)
    axes.contour(grid.x, grid.y, terrain.slip, levels=[threshold], colors=UNSAFE_LINE,
                 linewidths=0.7, linestyles='dashed')
    axes.set(aspect='equal', xticks=[0, 5, 10], yticks=[0, 5, 10], xlim=(0, 10), ylim=(0, 10))


def draw_certified(axes: Axes, grid: Grid, certified: NDArray[np.bool_] | None,
                   colour: str = '#000000', width: float = 1.1) -> None:
    """Outline the certified cells."""
    if certified is not None and certified.any() and not certified.all():
        axes.contour(grid.x, grid.y, certified.astype(float), levels=[0.5], colors=colour,
                     linewidths=width)


def draw_path(axes: Axes, path: FloatArray, colour: str, width: float = 1.4) -> None:
    """Draw a way and its end."""
    if len(path):
        axes.plot(path[:, 1], path[:, 2], color=colour, linewidth=width)
        axes.plot(path[-1, 1], path[-1, 2], 'o', color='#d7191c', markersize=4,
                  markeredgecolor='white', markeredgewidth=0.5, zorder=6)


def draw_ends(axes: Axes, start: FloatArray, goal: FloatArray | None) -> None:
    """Draw start and goal."""
    axes.plot(start[0], start[1], 'o', color='#1a9641', markersize=6, markeredgecolor='white',
              zorder=7)
    if goal is not None:
        axes.plot(goal[0], goal[1], '*', color='#ffd700', markersize=12, markeredgecolor=INK,
                  markeredgewidth=0.7, zorder=7)


def draw_paths(groups: Sequence[Group], runs: Runs, terrain: Terrain, threshold: float,
               path: Path) -> None:
    """Draw all ways of each strategy of one task, and the certified ground of the first.

    The first trial is drawn strong, the others thin.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(2.35 * len(groups) + 0.6, 2.85), layout='constrained')
        axes = np.atleast_1d(figure.subplots(1, len(groups), sharey=True))
        for panel, group in zip(axes, groups, strict=True):
            draw_ground(panel, terrain, threshold)
            for index, row in reversed(list(enumerate(group.rows[:5]))):
                run = runs(row['name'])
                if run is None:
                    continue
                if index == 0:
                    draw_certified(panel, run.grid, run.certified, CERTIFIED, 1.2)
                width = 1.6 if group.has_goal else 0.8
                if index == 0 or group.has_goal:
                    draw_path(panel, run.path, INK if index == 0 else '#55555599',
                              width if index == 0 else 0.6)
            draw_ends(panel, np.array(terrain.start),
                      np.array(terrain.goal) if group.has_goal else None)
            panel.set_title(f'{group.strategy}: {_verdict(group)}')
        mappable = ScalarMappable(Normalize(0.0, 1.0), SLIP_COLOURS)
        figure.colorbar(mappable, ax=axes.tolist(), shrink=0.8, label='true slip [-]')
        figure.savefig(path, dpi=150)


def _verdict(group: Group) -> str:
    if group.has_goal:
        won = sum(bool(row['summary']['success']) for row in group.rows)
        return f'{won} of {len(group.rows)}'
    return f'{group.spread(quantity_named("coverage")).mean:.2f}'


def draw_bars(groups: Sequence[Group], path: Path) -> None:
    """Draw what counts in each task with error bars, the paper's figures beside."""
    tasks = list(dict.fromkeys(group.task for group in groups))
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(13.0, 2.0 * len(tasks) + 0.5), layout='constrained')
        axes = figure.subplots(len(tasks), len(GOAL_BARS), squeeze=False)
        for task, line in zip(tasks, axes, strict=True):
            here = [group for group in groups if group.task == task]
            for name, panel in zip(GOAL_BARS if here[0].has_goal else EXPLORE_BARS, line,
                                   strict=True):
                _draw_bar_panel(panel, here, quantity_named(name))
            line[0].set_ylabel(title_of(task).replace(' in ', '\nin ').replace(' of ', '\nof '))
        figure.savefig(path, dpi=150)


def _draw_bar_panel(axes: Axes, groups: Sequence[Group], quantity: Quantity) -> None:
    axes.set_title(quantity.heading)
    top = 0.0
    for place, group in enumerate(groups):
        ours = group.spread(quantity)
        if ours.trials:
            axes.bar(place, ours.mean, 0.62, color=colour_of(group.strategy),
                     yerr=_error(ours.mean, ours.deviation, quantity) if ours.trials > 1 else None,
                     capsize=3, error_kw={'linewidth': 0.8})
            top = max(top, ours.mean + _error(ours.mean, ours.deviation, quantity)[1][0])
        else:
            axes.annotate('-', (place, 0.0), ha='center', va='bottom')
        theirs = published_for(group.task, group.strategy, quantity.name)
        if theirs is not None and group.strategy != 'psane_geodesic':
            axes.errorbar(place, theirs.mean, theirs.deviation or 0.0, fmt='D', color=INK,
                          markersize=4, markerfacecolor='white', capsize=2, linewidth=0.8)
            top = max(top, theirs.mean + (theirs.deviation or 0.0))
    axes.set_xticks(range(len(groups)),
                    [group.strategy.replace('psane_', 'psane\n') for group in groups],
                    fontsize=6.5)
    axes.set_xlim(-0.6, len(groups) - 0.4)
    axes.set_ylim(0.0, 1.08 * top if top > 0.0 else 1.0)


def _error(mean: float, deviation: float, quantity: Quantity) -> list[list[float]]:
    """Return an error bar down and up that stays among values that are possible."""
    most = 1.0 if quantity.name in SHARES else math.inf
    return [[min(deviation, mean)], [min(deviation, most - mean)]]


def draw_coverage(groups: Sequence[Group], runs: Runs, path: Path) -> None:
    """Draw coverage over time: mean and, as a band, one standard deviation to either side."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(6.0, 3.6), layout='constrained')
        axes = figure.subplots()
        for group in groups:
            curves = [run.coverage for row in group.rows
                      if (run := runs(row['name'])) is not None and len(run.coverage) > 1]
            if not curves or max(curve[-1, 0] for curve in curves) < 1.0:
                continue
            _draw_band(axes, curves, colour_of(group.strategy), group.strategy)
            theirs = published_for(group.task, group.strategy, 'coverage')
            if theirs is not None and group.strategy != 'psane_geodesic':
                axes.errorbar(1000.0, theirs.mean, theirs.deviation, fmt='D', markersize=5,
                              color=colour_of(group.strategy), markerfacecolor='white',
                              capsize=3, label=f'{group.strategy}, paper')
        axes.set(xlabel='time [s]', ylabel='certified share of the safe ground in reach',
                 ylim=(0.0, 1.0), xlim=(0.0, 1030.0))
        if axes.get_legend_handles_labels()[0]:
            axes.legend(frameon=False, loc='upper left')
        figure.savefig(path, dpi=150)


def _draw_band(axes: Axes, curves: Sequence[FloatArray], colour: str, label: str) -> None:
    end = max(float(curve[-1, 0]) for curve in curves)
    time = np.linspace(0.0, end, 200)
    # A run that ended early keeps what it had certified.
    values = np.array([np.interp(time, curve[:, 0], curve[:, 1]) for curve in curves])
    mean = values.mean(axis=0)
    spread = values.std(axis=0, ddof=1) if len(curves) > 1 else np.zeros_like(mean)
    axes.plot(time, mean, color=colour, linewidth=1.5, label=label)
    axes.fill_between(time, mean - spread, mean + spread, color=colour, alpha=0.18, linewidth=0)


def draw_certified_over_truth(groups: Sequence[Group], runs: Runs, terrain: Terrain,
                              threshold: float, path: Path) -> None:
    """Draw, for each strategy, what its first trial certified at its end, over the truth."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(2.35 * len(groups) + 0.6, 2.95), layout='constrained')
        axes = np.atleast_1d(figure.subplots(1, len(groups), sharey=True))
        for panel, group in zip(axes, groups, strict=True):
            run = runs(group.rows[0]['name'])
            draw_ground(panel, terrain, threshold)
            if run is None:
                panel.set_title(f'{group.strategy}: failed')
                continue
            draw_certified(panel, run.grid, run.certified, '#000000', 1.3)
            truth = terrain.true_slip(run.grid.points).reshape(run.grid.shape)
            if run.certified is not None:
                wrong = run.grid.point_of(np.argwhere(run.certified & (truth > threshold)))
                panel.plot(*wrong.T, 's', color='#ff00c8', markersize=1.4, markeredgewidth=0.0)
            summary = group.rows[0]['summary']
            panel.set_title(f'{group.strategy}: {summary["coverage"]:.2f}')
            draw_ends(panel, np.array(terrain.start), None)
            if len(run.path):
                panel.plot(run.path[-1, 1], run.path[-1, 2], 'o', color='#d7191c', markersize=4)
        figure.savefig(path, dpi=150)
