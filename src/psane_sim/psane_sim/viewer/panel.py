# SPDX-License-Identifier: Apache-2.0
"""The panel beside the live view: words, plots, and what is shown."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser
from viser import uplot

from psane_mapping.grid import FloatArray
from psane_sim.viewer.data import Situation
from psane_sim.viewer.ground import LAYERS, GroundView
from psane_sim.viewer.words import clock, paragraph

COLOURS = ('#7b3294', '#e08214', '#1b7837', '#2166ac')
"""Of the robots' lines in the plots."""

PLOT_HEIGHT = 130
"""Height of a plot [pixel]."""


class Panel:
    """The controls and read-outs of the page.

    Parameters
    ----------
    gui : viser.GuiApi
    robots : sequence of str
        Namespaces; a single robot may have the empty one.
    ground : GroundView
        Whose layers are switched.
    show : callable
        Called with the name of what is shown or hidden (`contacts`, `forces`), and whether.
    """

    def __init__(self, gui: viser.GuiApi, robots: Sequence[str], ground: GroundView,
                 show: Callable[[str, bool], None]) -> None:
        gui.configure_theme(show_logo=False, show_share_button=False, control_width='medium')
        self._robots = tuple(robots)
        self._clock = gui.add_markdown('waiting for the first message')
        self._words = {robot: gui.add_markdown('') for robot in robots}
        self._layer = gui.add_dropdown('layer', LAYERS, initial_value=LAYERS[0])
        self._legend = gui.add_html(ground.legend())
        certified = gui.add_checkbox('certified ground', True)
        self._toggle(gui, 'contacts', show)
        self._toggle(gui, 'forces', show)
        self._click = gui.add_checkbox('a click sets the goal', True)
        self._whose = (gui.add_dropdown('robot', self._robots, initial_value=self._robots[0])
                       if len(self._robots) > 1 else None)
        self._near, self._far = gui.add_button('look at the robot'), gui.add_button('look at all')
        names = [robot or 'robot' for robot in robots]
        self._distance = _plot(gui, 'distance to the goal [m]', names)
        self._area = _plot(gui, 'certified area [m²]', names)
        self._factor = _plot(gui, 'real-time factor [-]', ['factor'])

        @self._layer.on_update
        def _switch(_: object) -> None:
            ground.show(self._layer.value)
            self._legend.content = ground.legend()

        @certified.on_update
        def _tint(_: object) -> None:
            ground.tint(certified.value)

    @staticmethod
    def _toggle(gui: viser.GuiApi, name: str, show: Callable[[str, bool], None]) -> None:
        box = gui.add_checkbox(name, True)

        @box.on_update
        def _change(_: object) -> None:
            show(name, box.value)

    @property
    def robot_of_clicks(self) -> str | None:
        """Whose goal a click sets; None when clicks set none."""
        return self.robot_in_focus if self._click.value else None

    @property
    def robot_in_focus(self) -> str:
        """The robot that goals and the close camera are for."""
        return self._robots[0] if self._whose is None else self._whose.value

    def on_look(self, near: Callable[[viser.ClientHandle], None],
                far: Callable[[viser.ClientHandle], None]) -> None:
        """Say what the two buttons do with the page on which they were pressed."""
        for button, act in ((self._near, near), (self._far, far)):
            button.on_click(_for_client(act))

    def tell(self, robot: str, situation: Situation) -> None:
        """Say what a planner says."""
        self._words[robot].content = paragraph(robot, situation)

    def tick(self, time: float, factor: float) -> None:
        """Say the time [s] and the real-time factor [-]."""
        self._clock.content = clock(time, factor)

    def plot(self, distance: Sequence[tuple[FloatArray, ...]],
             area: Sequence[tuple[FloatArray, ...]], factor: tuple[FloatArray, ...]) -> None:
        """Draw the plots anew: (times, values) of each robot, and of the real-time factor."""
        for handle, columns in ((self._distance, distance), (self._area, area),
                                (self._factor, [factor])):
            data = _on_one_axis(columns)
            if len(data[0]) > 1:
                handle.data = data


def _for_client(act: Callable[[viser.ClientHandle], None]
                ) -> Callable[[viser.GuiEvent[Any]], None]:
    def pressed(event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            act(event.client)
    return pressed


def _plot(gui: viser.GuiApi, title: str, names: Sequence[str]) -> viser.GuiUplotHandle:
    empty = tuple(np.zeros(0) for _ in range(1 + len(names)))
    lines = [uplot.Series(label=name, stroke=COLOURS[index % len(COLOURS)], width=2)
             for index, name in enumerate(names)]
    return gui.add_uplot(
        empty, (uplot.Series(label='t [s]'), *lines), title=title, height=PLOT_HEIGHT,
        scales={'x': uplot.Scale(time=False, auto=True), 'y': uplot.Scale(auto=True)},
        legend=uplot.Legend(show=len(names) > 1))


def _on_one_axis(columns: Sequence[tuple[FloatArray, ...]]) -> tuple[FloatArray, ...]:
    """Bring (times, values) pairs to the times of the longest one; a plot has one axis of time."""
    times = max((pair[0] for pair in columns), key=len)
    values = [np.interp(times, pair[0], pair[1], left=np.nan, right=np.nan)
              if len(pair[0]) else np.full(len(times), np.nan) for pair in columns]
    return (times, *values)
