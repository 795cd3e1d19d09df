# SPDX-License-Identifier: Apache-2.0
"""Plots that stand in the scene itself, behind the ground: a recorded page has no panel."""

from collections.abc import Sequence

import numpy as np
import viser

from psane_mapping.grid import FloatArray, Grid

HEIGHT, GAP = 2.0, 0.4
"""Height of the board, and its distance behind the ground [m]."""

COLOURS = ((123, 51, 148), (224, 130, 20), (27, 120, 55), (33, 102, 172))
Curve = tuple[str, FloatArray, FloatArray]
"""What and in which unit, times (n,) [s], values (n,)."""

FRAME = (120, 120, 120)


class Board:
    """Draws values over time on a board as wide as the ground.

    Parameters
    ----------
    scene : viser.SceneApi
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._clock = scene.add_label('/board/clock', '', anchor='top-left',
                                      font_screen_scale=1.3)

    def tick(self, words: str, grid: Grid | None) -> None:
        """Write words (the time) at the near edge of the ground."""
        if grid is not None:
            self._clock.position = (grid.origin_x, grid.origin_y - GAP, 0.0)
        self._clock.text = words

    def draw(self, curves: Sequence[Curve], grid: Grid) -> None:
        """Draw curves, each from 0 to its own largest value, which is written beside it."""
        place = _Place(grid, max((float(times[-1]) for _, times, _ in curves if len(times)),
                                 default=1.0))
        self._scene.add_line_segments('/board/frame', place.frame(), FRAME, thickness=0.02)
        for index, (name, times, values) in enumerate(curves):
            known = np.isfinite(values)
            if known.sum() < 2:
                continue
            top = max(float(values[known].max()), 1e-9)
            points = place.curve(times[known], values[known] / top)
            colour = COLOURS[index % len(COLOURS)]
            self._scene.add_line_segments(
                f'/board/curve{index}', np.stack((points[:-1], points[1:]), axis=1), colour,
                thickness=0.04)
            self._scene.add_label(f'/board/value{index}',
                                  f'{name}: {values[known][-1]:.2f} (most {top:.2f})',
                                  position=place.beside(index), anchor='center-left')


class _Place:
    """Where the board stands."""

    def __init__(self, grid: Grid, longest: float) -> None:
        self._x, self._width = grid.origin_x, grid.columns * grid.resolution
        self._y = grid.origin_y + grid.rows * grid.resolution + GAP
        self._longest = max(longest, 1e-9)

    def curve(self, times: FloatArray, shares: FloatArray) -> FloatArray:
        """Return points (n, 3) [m] of values as shares of the board's height."""
        return np.column_stack((self._x + self._width * times / self._longest,
                                np.full(len(times), self._y), HEIGHT * shares))

    def beside(self, index: int) -> tuple[float, float, float]:
        """Return where the words of a curve stand, to the right of the board [m]."""
        return self._x + 1.02 * self._width, self._y, HEIGHT * (1.0 - 0.28 * index)

    def frame(self) -> FloatArray:
        """Return the segments (2, 2, 3) of the two axes [m]."""
        corner = (self._x, self._y, 0.0)
        return np.array([[corner, (self._x + self._width, self._y, 0.0)],
                         [corner, (self._x, self._y, HEIGHT)]])
