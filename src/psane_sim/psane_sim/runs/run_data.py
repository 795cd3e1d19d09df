# SPDX-License-Identifier: Apache-2.0
"""What is kept of a run beside its row: contacts, path, coverage, moments, the last maps."""

import io
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.sample import record_of
from psane_mapping.sample_file import header_of
from psane_sim.runs.closed_loop import ClosedLoop
from psane_sim.runs.kinematic_loop import KinematicLoop
from psane_sim.runs.run_watch import Moment, RunWatch, packed, unpacked

PATH_PERIOD = 0.2
"""Least time between the points of a path that is kept [s]."""

SCORES = ('points', 'expansion', 'goal_value', 'overall', 'eligible', 'pareto')
"""What is kept of a frontier."""


@dataclass(frozen=True)
class RunData:
    """Two files' worth of a run.

    Parameters
    ----------
    arrays : bytes
        A compressed numpy archive; `read_run` reads it.
    contacts : bytes
        Every sample that the map was told, as a map file that the mapper can load.
    """

    arrays: bytes
    contacts: bytes


def data_of(loop: ClosedLoop | KinematicLoop, watch: RunWatch) -> RunData:
    """Return what is to be kept of a finished run."""
    record = loop.record
    path = np.array(record.path).reshape(-1, 3)
    arrays: dict[str, Any] = {
        'path': _thinned(path, PATH_PERIOD).astype(np.float32),
        'contacts': np.array(record.contacts).reshape(-1, 4).astype(np.float32),
        'postures': np.array(record.postures, dtype=np.float32).reshape(-1, 14),
        'subgoals': np.array(record.subgoals).reshape(-1, 3).astype(np.float32),
        'coverage': np.array(watch.coverage).reshape(-1, 2),
        'moments': np.array([moment.time for moment in watch.moments]),
    }
    if record.certified is not None:
        arrays['certified'] = packed(record.certified)
    for index, moment in enumerate(watch.moments):
        arrays |= {f'm{index}_{name}': value for name, value in _of_moment(moment).items()}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    contacts = header_of(asdict(loop.settings.mapping)) + b''.join(map(record_of, record.samples))
    return RunData(buffer.getvalue(), contacts)


def _thinned(path: FloatArray, period: float) -> FloatArray:
    """Return the first point of each period, and the last point."""
    if len(path) < 2:
        return path
    _, first = np.unique(np.floor(path[:, 0] / period + 1e-9), return_index=True)
    return np.vstack((path[first], path[-1:]))


def _of_moment(moment: Moment) -> dict[str, NDArray[Any]]:
    plan = moment.plan
    nothing = np.full(2, np.nan)
    made: dict[str, NDArray[Any]] = {
        'slip_mean': moment.slip_mean.astype(np.float32),
        'slip_std': moment.slip_std.astype(np.float32),
        'lower': plan.lower.astype(np.float32), 'certified': packed(plan.certified),
        'position': moment.position,
        'goal': nothing if plan.goal is None else plan.goal,
        'subgoal': nothing if plan.focus is None else plan.focus,
    }
    if plan.frontier is not None:
        made |= {name: getattr(plan.frontier, name) for name in SCORES}
    return made


@dataclass(frozen=True, kw_only=True)
class StoredRun:
    """A run as read back; see `RunRecord` and `Moment` for what the arrays hold."""

    grid: Grid
    path: FloatArray
    contacts: FloatArray
    postures: FloatArray
    subgoals: FloatArray
    coverage: FloatArray
    certified: NDArray[np.bool_] | None
    moments: tuple[Mapping[str, NDArray[Any]], ...]


def read_run(arrays: bytes) -> StoredRun:
    """Return the run that `data_of` kept."""
    default = MappingConfiguration()
    grid = Grid.over_workspace(default.min_x, default.min_y, default.max_x, default.max_y,
                               default.resolution)
    with np.load(io.BytesIO(arrays)) as stored:
        held = {name: stored[name] for name in stored.files}
    moments = []
    for index, time in enumerate(held['moments']):
        prefix = f'm{index}_'
        moment = {name.removeprefix(prefix): value for name, value in held.items()
                  if name.startswith(prefix)}
        moment['certified'] = unpacked(moment['certified'], grid.shape)
        moments.append({**moment, 'time': np.array(time)})
    certified = held.get('certified')
    return StoredRun(
        grid=grid, path=held['path'], contacts=held['contacts'], postures=held['postures'],
        subgoals=held['subgoals'], coverage=held['coverage'], moments=tuple(moments),
        certified=None if certified is None else unpacked(certified, grid.shape))
