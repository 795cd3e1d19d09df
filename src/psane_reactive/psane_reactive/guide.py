# SPDX-License-Identifier: Apache-2.0
"""Find the way through the region: by the chosen map, by the field where the map cannot tell."""

import math
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from typing import NamedTuple

import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.aim import aim_along, is_visible
from psane_reactive.clearance import Area, Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.errors import ReactiveError
from psane_reactive.field import ScreenedPoissonField
from psane_reactive.map_builder import AtOnce, build_map
from psane_reactive.model_map import ModelMap, Way
from psane_reactive.region import nearest_part, point_inside, smooth_parts

_SUBGOAL_DEPTH = 0.01
_FINEST_DIVISOR = 4.0
# A region that has only grown holds the old one but for this much of its edge [m].
_EDGE_TOLERANCE = 0.02


@dataclass
class Counts:
    """How often each way of steering was used, for diagnostics."""

    straight: int = 0
    by_map: int = 0
    by_field: int = 0
    without_way: int = 0
    waiting: int = 0
    maps_built: int = 0
    maps_failed: int = 0


class Aim(NamedTuple):
    """Where to drive: target (2,) [m], least way left [m], and what found it."""

    target: FloatArray
    left: float
    found_by: str


class Guide:
    """Aims through one region; map and field are built when they are first needed.

    Parameters
    ----------
    area : Polygon or MultiPolygon, map frame [m]
        A clean region.
    previous : ModelMap or None
        Map of an older region that lies within this one; leads until this one's is built.
    """

    def __init__(self, area: Area, configuration: ReactiveConfiguration, counts: Counts,
                 executor: Executor | None = None, previous: ModelMap | None = None) -> None:
        self._configuration = configuration
        self._area = area
        self._parts: list[shapely.Polygon] | None = None
        self._counts = counts
        self._executor = AtOnce() if executor is None else executor
        self._previous = previous
        self.border = Border(area)
        self._component: shapely.Polygon | None = None
        self._build: Future[ModelMap | None] | None = None
        self._map_is_known = False
        self._field: ScreenedPoissonField | None = None
        self._divisor = 1.0
        self._goal: tuple[bytes, FloatArray] | None = None

    @property
    def component(self) -> shapely.Polygon | None:
        """Part of the region that holds the robot, None before the first aim."""
        return self._component

    @property
    def is_building(self) -> bool:
        """Whether the map of this region is under way."""
        return self._build is not None and not self._build.done()

    def usable_map(self) -> ModelMap | None:
        """Return the map that leads now: this region's, or while that is built the older one."""
        if self._build is not None and self._build.done():
            return self._build.result()
        return self._previous

    def map_within(self, region: Area) -> ModelMap | None:
        """Return the map in use if a new region holds its own, to lead while another is built."""
        if isinstance(self._executor, AtOnce) or self._component is None:
            return None
        core = self._component.buffer(-_EDGE_TOLERANCE)
        return self.usable_map() if not core.is_empty and region.covers(core) else None

    def goal_inside(self, subgoal: FloatArray, position: FloatArray) -> FloatArray:
        """Return the point of the robot's component that is nearest to a subgoal, (2,) [m]."""
        component = self._enter(position)
        key = subgoal.tobytes()
        if self._goal is None or self._goal[0] != key:
            self._goal = (key, point_inside(component, subgoal, _SUBGOAL_DEPTH))
        return self._goal[1]

    def aim(self, position: FloatArray, goal: FloatArray, prefer_field: bool) -> Aim | None:
        """Return what to drive at on the way to a goal inside the region, None without a way.

        Parameters
        ----------
        position, goal : (2,) float, map frame [m]
        prefer_field : bool
            True when the map has led nowhere.
        """
        settings = self._configuration
        distance = math.dist(goal, position)
        if distance <= settings.straight_reach and is_visible(
                self.border, position, goal, settings.edge_margin):
            self._counts.straight += 1
            return Aim(goal, distance, 'straight')
        for name in self._ways_to_ask(prefer_field):
            way = (self._way_by_map if name == 'map' else self._way_by_field)(
                position, goal, settings.look_ahead + 0.1)
            if way is None or len(way.points) == 0:
                continue
            if name == 'map':
                self._counts.by_map += 1
            else:
                self._counts.by_field += 1
            target = aim_along(self.border, position, way, settings.look_ahead,
                               settings.edge_margin)
            left = max(distance, settings.look_ahead if not way.ends_at_goal else 0.0)
            return Aim(target, left, settings.steering_map if name == 'map' else 'field')
        if self.is_building:
            self._counts.waiting += 1
        else:
            self._counts.without_way += 1
        return None

    def _ways_to_ask(self, prefer_field: bool) -> tuple[str, ...]:
        """Return what is asked for a way, in order; the field never while a map is built."""
        if self._configuration.steering_map == 'field' or prefer_field:
            return ('field',)
        self.build()
        return ('map',) if self.is_building else ('map', 'field')

    def _enter(self, position: FloatArray) -> shapely.Polygon:
        """Return the part that holds the robot; what was built for another one is dropped."""
        if self._parts is None:
            # Not before it is steered in: a robot that marches needs no more than the border.
            self._parts = smooth_parts(self._area, self._configuration.smoothing_radius)
        number = nearest_part(self._parts, position)
        if self._component is not self._parts[number]:
            self._component = self._parts[number]
            self._build, self._map_is_known, self._goal = None, False, None
            self._field, self._divisor = None, 1.0
        return self._component

    def build(self) -> None:
        """Have the map of the robot's component built, if that was not done yet."""
        if self._build is None and self._component is not None:
            self._build = self._executor.submit(build_map, self._component,
                                                self._configuration)
        if self._build is not None and self._build.done() and not self._map_is_known:
            self._map_is_known = True
            if self._build.result() is None:
                self._counts.maps_failed += 1
            else:
                self._counts.maps_built += 1

    def _way_by_map(self, position: FloatArray, goal: FloatArray, reach: float) -> Way | None:
        """Return the map's way, None where it cannot tell."""
        chosen = self.usable_map()
        return None if chosen is None else chosen.way(position, goal, reach)

    def _way_by_field(self, position: FloatArray, goal: FloatArray, reach: float) -> Way | None:
        """Return the field's way; with finer cells where the region is thinner than a cell."""
        settings = self._configuration
        while self._component is not None and self._divisor <= _FINEST_DIVISOR:
            try:
                if self._field is None:
                    self._field = ScreenedPoissonField(
                        self._component, settings.field_cell / self._divisor,
                        settings.field_length)
                way = self._field.way(position, goal, reach)
                if way is not None:
                    return way
            except ReactiveError:
                pass
            self._field = None
            self._divisor *= 2.0
        return None
