# SPDX-License-Identifier: Apache-2.0
"""The ground in the live view: the maps, one at a time, and what is certified of it."""

import numpy as np
import viser
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, Grid
from psane_sim.viewer.colours import CERTIFIED, Picture, bar, picture_of, tint_of

SLIP, UNCERTAINTY, NOTHING = 'slip', 'uncertainty', 'none'
LAYERS = (SLIP, UNCERTAINTY, NOTHING)
SHADES = {SLIP: ('turbo', 1.0), UNCERTAINTY: ('viridis', 0.5)}
"""Colour map of each map, and the value at its upper end [-]."""

SAND = (214, 196, 160)
MAP_HEIGHT, TINT_HEIGHT = 0.0, 0.006
"""The maps lie on the ground, and the tint of what is certified on the maps [m]."""

CERTIFIED_OPACITY = 70


class GroundView:
    """Shows the maps as pictures that lie on the ground.

    Parameters
    ----------
    scene : viser.SceneApi
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._shown = SLIP
        self._tinted = True
        self._grid: Grid | None = None
        self._pictures: dict[str, viser.ImageHandle] = {}
        self._waiting: dict[str, Picture] = {}

    def take_map(self, layer: str, grid: Grid, values: FloatArray) -> None:
        """Take a new map (rows, columns) [-]; it is drawn by the next `draw`."""
        self._lay(grid)
        name, top = SHADES[layer]
        self._waiting[layer] = picture_of(values, name, top)

    def take_certified(self, grid: Grid, mask: NDArray[np.bool_]) -> None:
        """Take which cells (rows, columns) are certified."""
        self._lay(grid)
        self._waiting['certified'] = tint_of(mask, CERTIFIED, CERTIFIED_OPACITY)

    def show(self, layer: str) -> None:
        """Show one of the maps, or none."""
        self._shown = layer
        self._apply()

    def tint(self, visible: bool) -> None:
        """Show or hide what is certified."""
        self._tinted = visible
        self._apply()

    def legend(self) -> str:
        """Return the colour bar of the map that is shown, in HTML."""
        if self._shown == NOTHING:
            return ''
        name, top = SHADES[self._shown]
        meaning = 'slip' if self._shown == SLIP else 'standard deviation of slip'
        return bar(name, '0', f'{top:g}', meaning)

    def draw(self) -> None:
        """Send the pictures that are new."""
        waiting, self._waiting = self._waiting, {}
        for name, picture in waiting.items():
            if name in self._pictures:
                self._pictures[name].image = picture
            else:
                self._pictures[name] = self._spread(name, picture)
                self._apply()

    def _apply(self) -> None:
        for name, handle in self._pictures.items():
            handle.visible = self._tinted if name == 'certified' else name == self._shown

    def _lay(self, grid: Grid) -> None:
        """Lay out the ground anew when it is another one than before."""
        if grid == self._grid:
            return
        self._grid = grid
        self._waiting.clear()
        for handle in self._pictures.values():
            handle.remove()
        self._pictures.clear()
        width, height, x, y = _extent(grid)
        self._scene.add_box('/ground/sand', color=SAND, dimensions=(width, height, 0.3),
                            position=(x, y, -0.152), cast_shadow=False)
        self._scene.add_grid('/ground/metres', width=width, height=height, plane='xy',
                             cell_size=1.0, section_size=1.0, position=(x, y, 0.004),
                             cell_color=(90, 90, 90), section_color=(90, 90, 90),
                             section_thickness=0.6, cell_thickness=0.6)

    def _spread(self, name: str, picture: Picture) -> viser.ImageHandle:
        assert self._grid is not None
        width, height, x, y = _extent(self._grid)
        z = TINT_HEIGHT if name == 'certified' else MAP_HEIGHT
        # The picture's own y axis points down; half a turn about x lays it out with y up.
        return self._scene.add_image(
            f'/ground/{name}', picture, width, height, format='png', position=(x, y, z),
            wxyz=(0.0, 1.0, 0.0, 0.0), cast_shadow=False, receive_shadow=False)


def _extent(grid: Grid) -> tuple[float, float, float, float]:
    """Return width, height and middle of a grid [m]."""
    width, height = grid.columns * grid.resolution, grid.rows * grid.resolution
    return width, height, grid.origin_x + width / 2.0, grid.origin_y + height / 2.0
