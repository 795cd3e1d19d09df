# SPDX-License-Identifier: Apache-2.0
"""The live view: takes plain data as it comes, and draws it at its own pace."""

import math
from collections import deque
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import viser
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray, Grid
from psane_mapping.leg import RobotModel
from psane_sim.viewer.board import Board, Curve
from psane_sim.viewer.camera import CLOSE, overview_of, point_camera
from psane_sim.viewer.colours import shades_of
from psane_sim.viewer.data import Click, Situation
from psane_sim.viewer.ground import GroundView
from psane_sim.viewer.panel import Panel
from psane_sim.viewer.recording import Recording
from psane_sim.viewer.robot_scene import RobotScene
from psane_sim.viewer.series import RealTimeFactor, Series
from psane_sim.viewer.shapes import ground_under
from psane_sim.viewer.words import clock

SLOW_PERIOD, PLOT_PERIOD = 0.5, 1.0
"""Time on the wall between drawings of maps, and of plots [s]; the robot is drawn each time."""

MOST_CONTACTS = 3000
CONTACT_HEIGHT = 0.01


class LiveView:
    """One world with its robots in a browser.

    Parameters
    ----------
    server : viser.ViserServer
    robots : sequence of str
        Namespaces; a single robot may have the empty one.
    model : RobotModel
    record : bool
        Keep all that is shown, for `write`.
    """

    def __init__(self, server: viser.ViserServer, robots: Sequence[str], model: RobotModel, *,
                 record: bool = False) -> None:
        self._server = server
        self._recording = Recording(server) if record else None
        self._board = Board(server.scene) if record else None
        self._ground = GroundView(server.scene)
        self._robots = {robot: RobotScene(server.scene, robot, model) for robot in robots}
        self._panel = Panel(server.gui, robots, self._ground, self._show)
        self._clicks: deque[Click] = deque()
        self._factor = RealTimeFactor()
        self._history = {robot: (Series(1), Series(1)) for robot in robots}
        self._factors = Series(1)
        self._contacts: deque[tuple[float, float, float]] = deque(maxlen=MOST_CONTACTS)
        self._contacts_shown = True
        self._new_contacts = False
        self._time = 0.0
        self._drawn = self._plotted = -math.inf
        self._grid: Grid | None = None
        server.scene.on_click()(self._take_click)
        self._panel.on_look(self._look_at_robot, self._look_at_ground)

    def robot(self, name: str) -> RobotScene:
        """Return the drawing of a robot, to be told what is new."""
        return self._robots[name]

    def take_map(self, layer: str, grid: Grid, values: FloatArray) -> None:
        """Take a new map (rows, columns) [-]: `view_ground.SLIP` or `UNCERTAINTY`."""
        self._frame(grid)
        self._ground.take_map(layer, grid, values)

    def take_certified(self, grid: Grid, mask: NDArray[np.bool_]) -> None:
        """Take which cells (rows, columns) are certified."""
        self._frame(grid)
        self._ground.take_certified(grid, mask)

    def take_contact(self, point: FloatArray, slip: float) -> None:
        """Take where a foot felt the ground (2,) [m], and the slip of it [-]."""
        self._contacts.append((float(point[0]), float(point[1]), slip))
        self._new_contacts = True

    def take_situation(self, robot: str, time: float, situation: Situation) -> None:
        """Take what a planner says at a time [s]."""
        self._robots[robot].situation = situation
        self._panel.tell(robot, situation)
        distance, area = self._history[robot]
        distance.add(time, situation.distance)
        area.add(time, situation.area)

    def take_time(self, wall: float, time: float) -> None:
        """Take the simulation's time at a time on the wall [s]."""
        self._time = time
        self._factor.add(wall, time)

    def clicks(self) -> list[Click]:
        """Return the goals that were clicked since the last call."""
        taken = []
        while self._clicks:
            taken.append(self._clicks.popleft())
        return taken

    def draw(self, wall: float) -> None:
        """Send what is new; call it some twenty times a second."""
        if self._recording is not None:
            self._recording.advance(self._time)
        slow = wall - self._drawn >= SLOW_PERIOD
        with self._server.atomic():
            for robot in self._robots.values():
                robot.draw(slow)
            if slow:
                self._drawn = wall
                self._ground.draw()
                self._draw_contacts()
                self._panel.tick(self._time, self._factor.value)
                if self._board is not None:
                    self._board.tick(clock(self._time, self._factor.value), self._grid)
        if wall - self._plotted >= PLOT_PERIOD:
            self._plotted = wall
            self._plot()

    def write(self, path: Path) -> None:
        """Write all that was shown as one page; needs `record`."""
        if self._recording is None:
            raise ValueError('nothing was recorded: build the view with record=True')
        self._recording.write(path)

    def _frame(self, grid: Grid) -> None:
        """Let new pages look at the whole of the ground."""
        if self._grid is None:
            point_camera(self._server.initial_camera, *overview_of(grid))
        self._grid = grid

    def _look_at_robot(self, client: viser.ClientHandle) -> None:
        """Bring a page's camera close to the robot whose goal a click would set."""
        place = self._robots[self._panel.robot_in_focus].place
        if place is not None:
            point_camera(client.camera, place, CLOSE)

    def _look_at_ground(self, client: viser.ClientHandle) -> None:
        if self._grid is not None:
            point_camera(client.camera, *overview_of(self._grid))

    def _plot(self) -> None:
        if math.isfinite(self._factor.value):
            self._factors.add(self._time, self._factor.value)
        histories = self._history.values()
        self._panel.plot([distance.columns() for distance, _ in histories],
                         [area.columns() for _, area in histories], self._factors.columns())
        if self._board is not None and self._grid is not None:
            self._board.draw(self._curves(), self._grid)

    def _curves(self) -> list[Curve]:
        curves = []
        for robot, (distance, area) in self._history.items():
            whose = f'{robot} ' if robot else ''
            curves += [_curve(f'{whose}to the goal [m]', distance),
                       _curve(f'{whose}certified [m²]', area)]
        return [*curves, _curve('real-time factor', self._factors)]

    def _draw_contacts(self) -> None:
        if not self._new_contacts:
            return
        self._new_contacts = False
        table = np.array(self._contacts)
        points = np.column_stack((table[:, :2], np.full(len(table), CONTACT_HEIGHT)))
        self._server.scene.add_point_cloud(
            '/contacts', points.astype(np.float32), shades_of(table[:, 2], 'turbo', 1.0),
            point_size=0.03, point_shape='circle', precision='float32', point_shading='flat',
            visible=self._contacts_shown)

    def _show(self, what: str, visible: bool) -> None:
        if what == 'forces':
            for robot in self._robots.values():
                robot.show_forces(visible)
            return
        self._contacts_shown = visible
        handle = self._server.scene.get_handle_by_name('/contacts')
        if handle is not None:
            handle.visible = visible

    def _take_click(self, event: viser.SceneClickEvent) -> None:
        robot = self._panel.robot_of_clicks
        point = ground_under(np.array(event.ray_origin), np.array(event.ray_direction))
        if robot is None or point is None:
            return
        if self._grid is None or self._grid.contains(point):
            self._clicks.append(Click(robot=robot, point=point))


def _curve(name: str, series: Series) -> Curve:
    times, values = series.columns()
    return name, times, values
