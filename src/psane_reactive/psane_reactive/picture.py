# SPDX-License-Identifier: Apache-2.0
"""Draw a recorded instant in physical and in model space, side by side, with the vector field.

`python -m psane_reactive.picture --instant 120 --map purging --output picture.png`
"""

import argparse
from pathlib import Path

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from psane_mapping.grid import FloatArray
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.errors import RegionError
from psane_reactive.map_builder import build_map
from psane_reactive.model_map import ModelMap
from psane_reactive.recorded import SHIPPED, RecordedRegion, read_recording
from psane_reactive.region import clean_region, nearest_part, point_inside, smooth_parts

_INK, _LINES, _ARROWS, _WAY, _GOAL = '#1b1b1b', '#c9d6df', '#2c6fbb', '#d7191c', '#ffd700'
# Arrows over the longer side of the region, and how far the first stretch of a way is [m].
_ARROWS_ACROSS = 34
_FIRST = 0.06
_DEPTH = 0.01


def draw_instant(instant: RecordedRegion, goal: FloatArray, settings: ReactiveConfiguration,
                 path: Path) -> None:
    """Write the picture of one instant and a goal (2,) [m]; the suffix says the format.

    Raises
    ------
    RegionError
        When the chosen map cannot be built for this region.
    """
    parts = smooth_parts(clean_region(instant.polygon), settings.smoothing_radius)
    region = parts[nearest_part(parts, instant.position)]
    chosen = build_map(region, settings)
    if chosen is None:
        raise RegionError(f'the {settings.steering_map} map of this region cannot be built; '
                          'choose another one')
    goal = point_inside(region, goal, _DEPTH)
    start = point_inside(region, instant.position, _DEPTH)
    figure = Figure(figsize=(11.0, 5.6), layout='constrained')
    FigureCanvasAgg(figure)
    physical, model = figure.subplots(1, 2)
    where = f'{instant.source}, {instant.time:.0f} s'
    physical.set(title=f'region: {where}', xlabel='x [m]', ylabel='y [m]', aspect='equal')
    model.set(title=f'model space: {settings.steering_map}', aspect='equal')
    _draw_lines(physical, model, region, chosen)
    _draw_border(physical, model, region, chosen)
    _draw_arrows(physical, model, region, chosen, goal)
    _draw_way(physical, model, chosen, start, goal)
    figure.savefig(path, dpi=90)


def _draw_lines(physical: Axes, model: Axes, region: shapely.Polygon, chosen: ModelMap) -> None:
    """Draw lines of equal x and y and their images."""
    low_x, low_y, high_x, high_y = region.bounds
    spacing = max(high_x - low_x, high_y - low_y) / 16.0
    lines = [((x, low_y), (x, high_y)) for x in np.arange(low_x, high_x, spacing)]
    lines += [((low_x, y), (high_x, y)) for y in np.arange(low_y, high_y, spacing)]
    for line in lines:
        inside = shapely.intersection(region, shapely.LineString(line))
        for piece in shapely.get_parts(inside):
            if piece.length > 0.02:
                points = _along(piece, 0.02)
                physical.plot(*points.T, color=_LINES, linewidth=0.7)
                model.plot(*chosen.to_model(points).T, color=_LINES, linewidth=0.7)


def _draw_border(physical: Axes, model: Axes, region: shapely.Polygon,
                 chosen: ModelMap) -> None:
    for ring in (region.exterior, *region.interiors):
        points = _along(ring, 0.01)
        physical.plot(*points.T, color=_INK, linewidth=1.3)
        model.plot(*chosen.to_model(points).T, color=_INK, linewidth=1.3)


def _draw_arrows(physical: Axes, model: Axes, region: shapely.Polygon, chosen: ModelMap,
                 goal: FloatArray) -> None:
    """Draw the unit direction of the way from each point of a lattice."""
    low_x, low_y, high_x, high_y = region.bounds
    spacing = max(high_x - low_x, high_y - low_y) / _ARROWS_ACROSS
    lattice = np.stack(np.meshgrid(np.arange(low_x, high_x, spacing),
                                   np.arange(low_y, high_y, spacing)), axis=-1).reshape(-1, 2)
    lattice = lattice[shapely.contains_xy(region.buffer(-_DEPTH), lattice)]
    places, directions = [], []
    for place in lattice:
        way = chosen.way(place, goal, _FIRST)
        if way is None or len(way.points) == 0:
            continue
        away = way.points[-1] - place
        if np.hypot(*away) > 1e-6:
            places.append(place)
            directions.append(away / np.hypot(*away))
    images = chosen.to_model(np.array(places))
    pushed = np.array([chosen.jacobian(place) @ direction for place, direction
                       in zip(places, directions, strict=True)])
    pushed /= np.maximum(np.hypot(*pushed.T), 1e-300)[:, None]
    style = {'color': _ARROWS, 'pivot': 'mid', 'scale': 42.0, 'width': 0.0022, 'headwidth': 4.0}
    physical.quiver(*np.array(places).T, *np.array(directions).T, **style)
    model.quiver(*images.T, *pushed.T, **style)


def _draw_way(physical: Axes, model: Axes, chosen: ModelMap, start: FloatArray,
              goal: FloatArray) -> None:
    way = chosen.way(start, goal, np.inf)
    if way is not None:
        points = _along(shapely.LineString(np.concatenate((start[None, :], way.points))), 0.01)
        physical.plot(*points.T, color=_WAY, linewidth=1.8)
        model.plot(*chosen.to_model(points).T, color=_WAY, linewidth=1.8)
    for axes, (here, there) in ((physical, (start, goal)),
                                (model, chosen.to_model(np.array((start, goal))))):
        axes.plot(*here, 'o', color=_WAY, markersize=7, markeredgecolor='white')
        axes.plot(*there, '*', color=_GOAL, markersize=14, markeredgecolor=_INK)


def _along(line: shapely.LineString, spacing: float) -> FloatArray:
    """Return points of a line, its corners included, no farther apart than `spacing` [m]."""
    return shapely.get_coordinates(shapely.segmentize(line, spacing))


def main() -> None:
    """Draw one instant of a recording."""
    parser = argparse.ArgumentParser(description='draw a recorded instant and its model space')
    parser.add_argument('--recording', type=Path, default=SHIPPED)
    parser.add_argument('--instant', type=int, default=100, help='which region, from 0 on')
    parser.add_argument('--goal', type=float, nargs=2, metavar=('X', 'Y'),
                        help='default: the subgoal of that instant')
    parser.add_argument('--map', choices=('harmonic', 'purging'), default='harmonic')
    parser.add_argument('--switch', choices=('scale_free', 'exponential'), default='scale_free')
    parser.add_argument('--output', type=Path, default=Path('steering.png'))
    options = parser.parse_args()
    instants = read_recording(options.recording)
    if not 0 <= options.instant < len(instants):
        parser.error(f'there is no instant {options.instant}; there are {len(instants)}')
    instant = instants[options.instant]
    goal = instant.subgoal if options.goal is None else np.array(options.goal)
    draw_instant(instant, goal, ReactiveConfiguration(steering_map=options.map,
                                                      purge_switch=options.switch),
                 options.output)
    print(f'{options.output}: {instant.source} at {instant.time:.0f} s, {options.map}')


if __name__ == '__main__':
    main()
