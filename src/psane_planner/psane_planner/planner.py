# SPDX-License-Identifier: Apache-2.0
"""The planner: certify, find the region, decide. One call per cycle."""

import math
from dataclasses import replace

import numpy as np
import shapely

from psane_mapping.grid import FloatArray, Grid
from psane_planner import verdicts
from psane_planner.component import Component, Components
from psane_planner.confidence import Bounds, ConfidenceIntervals
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import Mask
from psane_planner.errors import MapError, PoseError
from psane_planner.mission import Mission
from psane_planner.region import Region, RegionBuilder
from psane_planner.safe_set import SafeSet, admissible_cells
from psane_planner.scene import Scene
from psane_planner.scores import FrontierScores
from psane_planner.status import Decision, Plan
from psane_planner.strategies import make_strategy
from psane_planner.stride_monitor import StrideMonitor
from psane_planner.transfer import transfer_between

_RING = tuple((math.cos(turn), math.sin(turn)) for turn in (k * math.pi / 3.0 for k in range(6)))
"""Where six feet stand around the centre, as far as their mean is concerned, radius 1 [-]."""


class SafePlanner:
    """Plans over a slip map; keeps intervals, certificates and the memory of frontiers.

    Time enters as `now`; nothing here asks a clock.
    """

    def __init__(self, configuration: PlannerConfiguration, grid: Grid) -> None:
        """Plan on `grid`; see `PlannerConfiguration` for what can be set."""
        self.configuration = configuration
        self.grid = grid
        self._strategy = make_strategy(configuration.strategy)
        self.reset()

    def reset(self) -> None:
        """Forget everything, as after the map was reset."""
        self._intervals = self._wide_open(self.configuration)
        self._safe_set = SafeSet(self.configuration, self.grid)
        self._felt: FloatArray | None = None
        self.strides = StrideMonitor(self.configuration)
        self._was_certified = False
        self._had_region = False
        self._is_lost = False
        self._make_parts()

    def reconfigure(self, configuration: PlannerConfiguration) -> None:
        """Go on with another configuration.

        Intervals and certificates are kept, unless the width of the intervals is another one;
        the memory of frontiers starts over.
        """
        old = self.configuration
        is_other_width = ((configuration.confidence_scale, configuration.revocation_scale)
                          != (old.confidence_scale, old.revocation_scale))
        if configuration.strategy != old.strategy:
            self._strategy = make_strategy(configuration.strategy)
        self.configuration = configuration
        if is_other_width:
            self._intervals = self._wide_open(configuration)
        self._safe_set = SafeSet(configuration, self.grid, self._safe_set.mask)
        self._make_parts()

    def move(self, grid: Grid) -> bool:
        """Go on on a grid of another extent, as when the map has grown.

        Intervals, certificates, the way to the goal so far and what strides told are kept where
        the cells coincide.

        Returns
        -------
        bool
            False when the cells of the grids do not coincide: nothing is done.
        """
        transfer = transfer_between(self.grid, grid)
        if transfer is None:
            return False
        self.grid = grid
        self._intervals.move(transfer)
        self._safe_set = SafeSet(self.configuration, grid, transfer.of(self._safe_set.mask, False))
        self._felt = None
        self._make_ground_parts()
        self._mission.move(grid, transfer)
        return True

    def _wide_open(self, configuration: PlannerConfiguration) -> ConfidenceIntervals:
        return ConfidenceIntervals(self.grid.shape, configuration.confidence_scale,
                                   configuration.revocation_scale)

    def _make_parts(self) -> None:
        """Make what holds no knowledge of the ground."""
        self._make_ground_parts()
        self._mission = Mission(self.configuration, self.grid, self._strategy)

    def _make_ground_parts(self) -> None:
        """Make what depends on the grid alone."""
        config = self.configuration
        self._inner: Mask | None = None
        self._components: Components | None = None
        self._builder = RegionBuilder(self.grid, config.region_clearance,
                                      config.contour_tolerance)

    def warm_up(self) -> None:
        """Compile what runs compiled, so that no cycle of a mission has to wait for it."""
        grid = Grid(origin_x=0.0, origin_y=0.0, resolution=0.1, rows=30, columns=30)
        throwaway = SafePlanner(
            replace(self.configuration, border_width=0.0, certification='lipschitz',
                    strategy='psane_geodesic'), grid)
        away = np.hypot(*(grid.points - 1.5).T).reshape(grid.shape)
        pose = np.array((1.5, 1.5, 0.0))
        for tick in range(2):
            throwaway.update(np.zeros(grid.shape), np.where(away < 0.8, 0.02, 0.5), pose,
                             np.array((2.8, 2.8)), float(tick))

    def idle(self, now: float) -> Plan:
        """Return a plan that asks for nothing, for a robot without a task."""
        return self._pack(verdicts.IDLE, None, self._empty_scene(None, now), None)

    def note_motion(self, pose: FloatArray, linear: float, angular: float, now: float) -> None:
        """Tell how the robot moves, so that felt and measured slip can be compared.

        Parameters
        ----------
        pose : (3,) float, map frame [m, m, rad]
        linear, angular : float
            Velocities that are asked of the robot [m/s], [rad/s].
        now : float [s]
        """
        self.strides.note(now, pose, linear, angular, self._felt_under(pose))

    def _felt_under(self, pose: FloatArray) -> float:
        """Return the mean slip that the map has under the feet of a robot, NaN where unknown [-].

        Ground that is soft to both sides slows a robot whose centre is on firm ground.
        """
        if self._felt is None:
            return math.nan
        grid, radius, total = self.grid, self.configuration.footprint_radius, 0.0
        x, y = float(pose[0]), float(pose[1])
        for ahead, aside in _RING:
            row = math.floor((y + radius * aside - grid.origin_y) / grid.resolution)
            column = math.floor((x + radius * ahead - grid.origin_x) / grid.resolution)
            if not (0 <= row < grid.rows and 0 <= column < grid.columns):
                return math.nan
            total += self._felt.item(row, column)
        return total / len(_RING)

    def note_stuck(self, subgoal: FloatArray, now: float) -> bool:
        """Take note that the steering gets nowhere on its way to a subgoal (2,) [m].

        Returns
        -------
        Whether that is a frontier that is sought now; it rests for a while.
        """
        return self._mission.give_up(subgoal, now)

    def update(self, slip_mean: FloatArray | None, slip_std: FloatArray | None,
               pose: FloatArray | None, goal: FloatArray | None, now: float,
               keep_out: Mask | None = None, known_safe: Mask | None = None) -> Plan:
        """Plan one cycle.

        Parameters
        ----------
        slip_mean, slip_std : (rows, columns) float [-], slip ratio
            Posterior on the grid, NaN where there is no estimate; None before the first map.
        pose : (3,) float, map frame [m, m, rad]
            x, y and heading of the robot; None before the first one.
        goal : (2,) float, map frame [m]
            None explores.
        now : float [s]
        keep_out : (rows, columns) bool
            Ground that is never certified.
        known_safe : (rows, columns) bool
            Ground that is certified without having been felt.

        Raises
        ------
        MapError, PoseError
            When an argument has the wrong shape or holds a number that means nothing.
        """
        goal = None if goal is None else _vector('goal', goal, 2)
        pose = None if pose is None else _vector('pose', pose, 3)
        position = None if pose is None else pose[:2]
        if not math.isfinite(now):
            raise PoseError('now', now, 'a finite time [s]')
        if slip_mean is None or slip_std is None or pose is None or position is None:
            return self._pack(verdicts.WAITING, None, self._empty_scene(goal, now), position)
        admissible = self._admissible(keep_out, known_safe)
        self._felt = np.asarray(slip_mean, dtype=np.float64)
        std = np.asarray(slip_std, dtype=np.float64)
        bounds = self._intervals.update(self.strides.pessimistic(self._felt), std)
        certified = self._safe_set.update(bounds, std, admissible, position, known_safe)
        if self._components is None or self._components.certified is not certified:
            self._components = Components(certified, self.grid)
        component = self._components.around(position)
        self._note_lost(component)
        region = self._region(certified, component, position)
        scene = Scene(now=now, position=position, heading=float(pose[2]), goal=goal, bounds=bounds,
                      admissible=admissible, certified=certified, component=component.mask,
                      outside_distance=component.outside_distance, is_lost=self._is_lost,
                      region=region)
        if self.strides.is_too_weak and self._strategy.traits.is_certified:
            return self._pack(verdicts.too_weak(self.strides.weakening), None, scene, position)
        decision, scores = self._mission.decide(scene)
        return self._pack(decision, scores, scene, position)

    def _admissible(self, keep_out: Mask | None, known_safe: Mask | None) -> Mask:
        for name, mask in (('keep_out', keep_out), ('known_safe', known_safe)):
            if mask is not None and mask.shape != self.grid.shape:
                raise MapError(f'{name} has shape {mask.shape}, expected {self.grid.shape}')
        if keep_out is not None:
            return admissible_cells(self.grid, self.configuration.border_width, keep_out)
        if self._inner is None:
            self._inner = admissible_cells(self.grid, self.configuration.border_width)
            self._inner.setflags(write=False)
        return self._inner

    def _note_lost(self, component: Component) -> None:
        """Call a robot lost once it is well outside, and found once it is as good as back."""
        config = self.configuration
        if not self._strategy.traits.is_certified:
            return
        limit = config.found_distance if self._is_lost else config.lost_distance
        self._was_certified |= component.outside_distance <= limit
        self._is_lost = self._was_certified and component.outside_distance > limit

    def _region(self, certified: Mask, component: Component,
                position: FloatArray) -> Region | None:
        if not self._strategy.traits.is_certified:
            return self._open_region()
        # Once there was a region, one that is left stays worth going back to, however far.
        within = math.inf if self._had_region else self.configuration.lost_distance
        region = self._builder.build(certified, component.mask, position, within)
        self._had_region |= region is not None
        return region

    def _open_region(self) -> Region:
        """Return the whole workspace less its border, for a strategy that certifies nothing."""
        border = self.configuration.border_width
        x, y = self.grid.x, self.grid.y
        box = shapely.box(x[0] + border, y[0] + border, x[-1] - border, y[-1] - border)
        return Region(box, np.ones(self.grid.shape, dtype=np.bool_))

    def _empty_scene(self, goal: FloatArray | None, now: float) -> Scene:
        nothing = np.zeros(self.grid.shape, dtype=np.bool_)
        high = np.full(self.grid.shape, np.inf)
        unknown = Bounds(-high, high, high, 0)
        return Scene(now=now, position=np.full(2, np.nan), heading=math.nan, goal=goal,
                     bounds=unknown, admissible=nothing, certified=nothing, component=nothing,
                     outside_distance=math.inf, is_lost=False, region=None)

    def _pack(self, decision: Decision, scores: FrontierScores | None, scene: Scene,
              position: FloatArray | None) -> Plan:
        away = math.nan
        if scene.goal is not None and position is not None:
            away = float(np.hypot(*(scene.goal - position)))
        return Plan(
            **vars(decision), now=scene.now, strategy=self._strategy.name, goal=scene.goal,
            distance_to_goal=away, region=None if scene.region is None else scene.region.polygon,
            certified=scene.certified, component=scene.component, frontier=scores,
            lower=scene.bounds.lower, upper=scene.bounds.upper,
            interval_resets=scene.bounds.resets,
            total_interval_resets=self._intervals.total_resets,
            certified_area=float(scene.component.sum()) * self.grid.cell_area,
            subgoal_count=self._mission.subgoal_count)


def _vector(name: str, value: FloatArray, size: int) -> FloatArray:
    vector = np.array(value, dtype=np.float64)
    if vector.shape != (size,) or not np.isfinite(vector).all():
        raise PoseError(name, value, f'{size} finite numbers')
    vector.setflags(write=False)
    return vector
