# SPDX-License-Identifier: Apache-2.0
"""Regions that were handed to the steering during runs on the physics, in one small file."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from psane_mapping.grid import FloatArray, IndexArray
from psane_reactive.errors import RecordingError

SHIPPED = Path(__file__).parent / 'data' / 'recorded_regions.npz'
"""The recording that comes with the package; `psane_sim.runs.record_regions` makes it anew."""

_FIELDS = ('points', 'ring_sizes', 'ring_counts', 'positions', 'subgoals', 'times', 'sources')


@dataclass(frozen=True, kw_only=True)
class RecordedRegion:
    """One moment of a run.

    Parameters
    ----------
    polygon : Polygon, map frame [m]
    position, subgoal : (2,) float, map frame [m]
        Where the robot was, and where it was sent.
    time : float
        Since the run began [s].
    source : str
        Terrain and seed of the run.
    """

    polygon: shapely.Polygon
    position: FloatArray
    subgoal: FloatArray
    time: float
    source: str


def write_recording(regions: Sequence[RecordedRegion], path: Path) -> None:
    """Write regions to a compressed numpy file; coordinates are kept to a micrometre."""
    rings = [(region.polygon.exterior, *region.polygon.interiors) for region in regions]
    corners = [np.asarray(ring.coords)[:-1, :2] for one in rings for ring in one]
    np.savez_compressed(
        path,
        points=np.concatenate(corners).astype(np.float32),
        ring_sizes=np.array([len(ring) for ring in corners], dtype=np.int32),
        ring_counts=np.array([len(one) for one in rings], dtype=np.int32),
        positions=np.array([region.position for region in regions]),
        subgoals=np.array([region.subgoal for region in regions]),
        times=np.array([region.time for region in regions]),
        sources=np.array([region.source for region in regions]))


def read_recording(path: Path = SHIPPED) -> list[RecordedRegion]:
    """Read regions from a file that `write_recording` has written.

    Raises
    ------
    RecordingError
        When the file cannot be read or its parts do not fit together.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            parts = {name: file[name] for name in _FIELDS}
    except (OSError, ValueError, KeyError) as error:
        raise RecordingError(path, str(error)) from error
    if (parts['ring_sizes'].sum() != len(parts['points'])
            or parts['ring_counts'].sum() != len(parts['ring_sizes'])
            or any(len(parts[name]) != len(parts['ring_counts']) for name in _FIELDS[3:])):
        raise RecordingError(path, 'its parts differ in length')
    polygons = _polygons(parts['points'].astype(np.float64), parts['ring_sizes'],
                         parts['ring_counts'])
    return [RecordedRegion(polygon=polygon, position=position, subgoal=subgoal, time=float(time),
                           source=str(source))
            for polygon, position, subgoal, time, source in zip(
                polygons, *(parts[name] for name in _FIELDS[3:]), strict=True)]


def _polygons(points: FloatArray, ring_sizes: IndexArray,
              ring_counts: IndexArray) -> list[shapely.Polygon]:
    """Put points together to rings and rings to polygons."""
    rings = np.split(points, np.cumsum(ring_sizes)[:-1])
    ends = np.cumsum(ring_counts)
    return [shapely.Polygon(rings[end - count], rings[end - count + 1:end])
            for end, count in zip(ends, ring_counts, strict=True)]
