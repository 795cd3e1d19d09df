# SPDX-License-Identifier: Apache-2.0
"""Between ROS messages and what the planning core works with."""

import array

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Point
from numpy.typing import NDArray
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.polygon import LinearRing, orient

from psane_mapping.conversions import header, require_finite
from psane_mapping.errors import MessageError
from psane_mapping.grid import FloatArray
from psane_msgs.msg import FrontierArray, PlannerStatus, RegionPolygon, Ring, SafeRegion
from psane_planner.status import Plan

CERTIFIED, UNSAFE, UNCERTIFIED = 0, 100, -1
"""Cells of the safe map, as Nav2's static layer reads them."""


def points_of(points: FloatArray) -> list[Point]:
    """Return points (n, 2) [m] as messages."""
    return [Point(x=float(x), y=float(y)) for x, y in points]


def safe_map_cells(plan: Plan, threshold: float) -> NDArray[np.int8]:
    """Return the cells (rows, columns) of the safe map: certified, known unsafe or uncertified.

    Parameters
    ----------
    threshold : float
        Largest safe slip [-]; a cell whose lower bound exceeds it is known to be unsafe.
    """
    cells = np.full(plan.certified.shape, UNCERTIFIED, dtype=np.int8)
    cells[plan.lower > threshold] = UNSAFE
    cells[plan.certified] = CERTIFIED
    return cells


def region_message(region: Polygon | MultiPolygon | None, clearance: float, sequence: int,
                   time: float, frame: str) -> SafeRegion:
    """Return the region as rings: the outer one counter-clockwise, holes clockwise."""
    message = SafeRegion(header=header(time, frame), clearance=clearance, sequence=sequence)
    for polygon in _polygons(region):
        oriented = orient(polygon, sign=1.0)
        message.polygons.append(RegionPolygon(
            outer=_ring(oriented.exterior), holes=[_ring(hole) for hole in oriented.interiors]))
    return message


def _polygons(region: Polygon | MultiPolygon | None) -> list[Polygon]:
    if region is None or region.is_empty:
        return []
    return list(region.geoms) if isinstance(region, MultiPolygon) else [region]


def _ring(ring: LinearRing) -> Ring:
    return Ring(points=points_of(np.asarray(ring.coords)[:-1, :2]))


def frontier_message(plan: Plan, time: float, frame: str) -> FrontierArray:
    """Return the frontier with its scores; empty where none was looked for."""
    message = FrontierArray(header=header(time, frame))
    scores = plan.frontier
    if scores is None:
        return message
    rows, columns = scores.cells[:, 0], scores.cells[:, 1]
    message.points = points_of(scores.points)
    message.expansion_probability = array.array('d', scores.expansion)
    message.goal_value = array.array('d', scores.goal_value)
    message.score = array.array('d', scores.overall)
    message.pareto = [bool(value) for value in scores.pareto]
    message.lower = array.array('d', plan.lower[rows, columns])
    message.upper = array.array('d', plan.upper[rows, columns])
    return message


def status_message(plan: Plan, time: float, frame: str) -> PlannerStatus:
    """Return the state of the planner and its reason."""
    return PlannerStatus(
        header=header(time, frame), state=int(plan.state), cause=plan.cause, remedy=plan.remedy,
        strategy=plan.strategy, distance_to_goal=float(plan.distance_to_goal),
        certified_area=float(plan.certified_area), certified_cells=plan.certified_cells,
        frontier_count=plan.frontier_count, subgoal_count=plan.subgoal_count,
        interval_resets=plan.total_interval_resets, march=plan.march,
        has_subgoal=plan.subgoal is not None, subgoal_is_goal=plan.subgoal_is_goal)


def stuck_at_of(message: DiagnosticStatus) -> FloatArray | None:
    """Return the subgoal (2,) [m] at which the steering says that it is stuck, else None.

    Raises
    ------
    MessageError
        When it is stuck and does not say where.
    """
    values = {pair.key: pair.value for pair in message.values}
    if values.get('mode') != 'stuck':
        return None
    try:
        x, y = float(values['subgoal_x']), float(values['subgoal_y'])
    except (KeyError, ValueError) as error:
        raise MessageError('the steering is stuck, and its subgoal is no pair of numbers'
                           ) from error
    require_finite('subgoal', x, y)
    return np.array((x, y))


def is_other_point(before: FloatArray | None, now: FloatArray | None) -> bool:
    """Tell whether a subgoal differs from the last one."""
    if before is None or now is None:
        return before is not now
    return not np.array_equal(before, now)


def is_other_region(before: Polygon | MultiPolygon | None,
                    now: Polygon | MultiPolygon | None) -> bool:
    """Tell whether a region differs from the last one."""
    if before is None or now is None:
        return before is not now
    return not before.equals_exact(now, 0.0)
