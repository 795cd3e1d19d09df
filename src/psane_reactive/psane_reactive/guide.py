# SPDX-License-Identifier: Apache-2.0
"""Find the way through the region: by the chosen map, by the field where the map cannot tell."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.aim import aim_along, is_visible
from psane_reactive.clearance import Area, Border
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.errors import ReactiveError
from psane_reactive.field import ScreenedPoissonField
from psane_reactive.harmonic import HarmonicMap
from psane_reactive.model_map import ModelMap, Way
from psane_reactive.region import nearest_part, point_inside, smooth_parts

_SUBGOAL_DEPTH = 0.01
_FINEST_DIVISOR = 4.0


@dataclass
class Counts:
    """How often each way of steering was used, for diagnostics."""

    straight: int = 0
    by_map: int = 0
    by_field: int = 0
    without_way: int = 0
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
    """

    def __init__(self, area: Area, configuration: ReactiveConfiguration, counts: Counts) -> None:
        self._configuration = configuration
        self._parts = smooth_parts(area, configuration.smoothing_radius)
        self._counts = counts
        self.border = Border(area)
        self._component: shapely.Polygon | None = None
        self._map: ModelMap | None = None
        self._map_was_tried = False
        self._field: ScreenedPoissonField | None = None
        self._divisor = 1.0
        self._goal: tuple[bytes, FloatArray] | None = None

    def goal_inside(self, subgoal: FloatArray, position: FloatArray) -> FloatArray:
        """Return the point of the robot's component that is nearest to a subgoal, (2,) [m]."""
        component = self._enter(position)
        key = subgoal.tobytes()
        if self._goal is None or self._goal[0] != key:
            border = Border(component)
            self._goal = (key, point_inside(border, component, subgoal, _SUBGOAL_DEPTH))
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
        distance = float(np.hypot(*(goal - position)))
        if distance <= settings.straight_reach and is_visible(
                self.border, position, goal, settings.edge_margin):
            self._counts.straight += 1
            return Aim(goal, distance, 'straight')
        reach = settings.look_ahead + 0.1
        use_map = settings.steering_map != 'field' and not prefer_field
        for name in ('map', 'field') if use_map else ('field',):
            way = (self._way_by_map if name == 'map' else self._way_by_field)(
                position, goal, reach)
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
        self._counts.without_way += 1
        return None

    def _enter(self, position: FloatArray) -> shapely.Polygon:
        """Return the part that holds the robot; what was built for another one is dropped."""
        number = nearest_part(self._parts, position)
        if self._component is not self._parts[number]:
            self._component = self._parts[number]
            self._map, self._map_was_tried, self._goal = None, False, None
            self._field, self._divisor = None, 1.0
        return self._component

    def _harmonic(self) -> ModelMap | None:
        """Return the map of the robot's component, None when it cannot be built."""
        if not self._map_was_tried and self._component is not None:
            self._map_was_tried = True
            settings = self._configuration
            # A hexagonal lattice has one vertex per 0.866 edge^2.
            edge = max(settings.mesh_edge, self._component.length / settings.mesh_size,
                       float(np.sqrt(self._component.area / (0.866 * settings.mesh_size))))
            try:
                self._map = HarmonicMap(self._component, edge, settings.hole_stiffness)
                self._counts.maps_built += 1
            except ReactiveError:
                self._counts.maps_failed += 1
        return self._map

    def build(self) -> None:
        """Build the map of the robot's component now, not at the first aim that needs it."""
        self._harmonic()

    def _way_by_map(self, position: FloatArray, goal: FloatArray, reach: float) -> Way | None:
        """Return the map's way, None where it cannot tell."""
        chosen = self._harmonic()
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
