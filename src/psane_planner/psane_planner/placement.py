# SPDX-License-Identifier: Apache-2.0
"""Put a point where the robot can be steered to."""

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.ops import nearest_points

from psane_mapping.grid import FloatArray


class Placement:
    """Moves points to the nearest place at least `inset` [m] inside a region."""

    def __init__(self, inset: float) -> None:
        """Keep `inset` [m] to the region's edge."""
        self._inset = inset
        self._region: Polygon | None = None
        self._inner: Polygon | None = None

    def place(self, region: Polygon, point: FloatArray) -> tuple[FloatArray, float]:
        """Return the nearest point inside `region` and how far it was moved [m].

        Parameters
        ----------
        region : shapely Polygon, map frame [m]
        point : (2,) float, map frame [m]
        """
        inner = self._inner_of(region)
        if shapely.contains_xy(inner, point[0], point[1]):
            return np.array((float(point[0]), float(point[1]))), 0.0
        wanted = shapely.Point(point[0], point[1])
        placed, _ = nearest_points(inner, wanted)
        return np.array((placed.x, placed.y)), float(placed.distance(wanted))

    def _inner_of(self, region: Polygon) -> Polygon:
        if region is not self._region or self._inner is None:
            inner = region.buffer(-self._inset, join_style='mitre')
            # A region thinner than twice the inset still has a middle.
            self._inner = region.representative_point() if inner.is_empty else inner
            shapely.prepare(self._inner)
            self._region = region
        return self._inner
