# SPDX-License-Identifier: Apache-2.0
"""The plan as markers for RViz and Foxglove."""

import numpy as np
from geometry_msgs.msg import Point
from shapely.geometry import Polygon
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from psane_mapping.conversions import header
from psane_mapping.grid import FloatArray
from psane_planner.conversions import points_of
from psane_planner.status import Plan

REGION, FRONTIER, SUBGOAL, GOAL = range(4)
GREEN = ColorRGBA(r=0.0, g=0.84, b=0.63, a=1.0)
VIOLET = ColorRGBA(r=0.48, g=0.20, b=0.58, a=1.0)
GOLD = ColorRGBA(r=1.0, g=0.84, b=0.0, a=1.0)
HEIGHT = 0.02
"""Markers float this far above the ground [m], so that maps do not hide them."""


def plan_markers(plan: Plan, time: float, frame: str) -> MarkerArray:
    """Return region, frontier (coloured by score), subgoal and goal."""
    markers = [_region(plan.region, time, frame), _frontier(plan, time, frame),
               _disc(SUBGOAL, plan.subgoal, VIOLET, 0.12, time, frame),
               _disc(GOAL, plan.goal, GOLD, 0.25, time, frame)]
    return MarkerArray(markers=markers)


def _marker(kind: int, identity: int, time: float, frame: str) -> Marker:
    marker = Marker(header=header(time, frame), ns='psane', id=identity, type=kind,
                    action=Marker.ADD)
    marker.pose.orientation.w = 1.0
    return marker


def _region(region: Polygon | None, time: float, frame: str) -> Marker:
    marker = _marker(Marker.LINE_LIST, REGION, time, frame)
    marker.scale.x = 0.03
    marker.color = GREEN
    if region is None or region.is_empty:
        marker.action = Marker.DELETE
        return marker
    for ring in (region.exterior, *region.interiors):
        corners = points_of(np.asarray(ring.coords)[:, :2])
        for begin, end in zip(corners[:-1], corners[1:], strict=True):
            marker.points.extend((begin, end))
    marker.pose.position.z = HEIGHT
    return marker


def _frontier(plan: Plan, time: float, frame: str) -> Marker:
    marker = _marker(Marker.CUBE_LIST, FRONTIER, time, frame)
    marker.scale.x = marker.scale.y = 0.06
    marker.scale.z = 0.01
    scores = plan.frontier
    if scores is None or scores.count == 0:
        marker.action = Marker.DELETE
        return marker
    best = max(float(scores.overall.max()), 1e-12)
    marker.points = points_of(scores.points)
    marker.colors = [ColorRGBA(r=float(share), g=0.2, b=1.0 - float(share), a=0.9)
                     for share in scores.overall / best]
    marker.pose.position.z = HEIGHT
    return marker


def _disc(identity: int, point: FloatArray | None, colour: ColorRGBA, size: float, time: float,
          frame: str) -> Marker:
    marker = _marker(Marker.CYLINDER, identity, time, frame)
    if point is None:
        marker.action = Marker.DELETE
        return marker
    marker.pose.position = Point(x=float(point[0]), y=float(point[1]), z=HEIGHT)
    marker.scale.x = marker.scale.y = size
    marker.scale.z = 0.02
    marker.color = colour
    return marker
