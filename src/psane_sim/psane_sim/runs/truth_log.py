# SPDX-License-Identifier: Apache-2.0
"""The truth of a run in a file, for scoring alone: it never travels on a topic."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from psane_mapping.grid import FloatArray
from psane_sim.errors import SimulationError
from psane_sim.robot.feed_forward import Sweep
from psane_sim.robot.truth import Truth

FEET = 6
COLUMNS = ['time_s', 'x_m', 'y_m', 'yaw_rad', 'speed_m_s',
           'sweep_left_rad', 'sweep_right_rad', 'swing_left', 'swing_right',
           *[f'foot{leg}_{axis}_m' for leg in range(FEET) for axis in 'xy']]


class TruthLogError(SimulationError):
    """A truth log cannot be read."""


@dataclass(frozen=True)
class TruthEntry:
    """Where the robot truly was; a foot that does not press on the ground is not a number.

    Parameters
    ----------
    time : float [s]
    pose : (3,) float
        x [m], y [m] and yaw [rad], map frame.
    speed : float
        Of the body's centre along the ground [m/s].
    feet : (6, 2) float, map frame [m]
    sweep : Sweep
        Stance sweeps that are in force.
    """

    time: float
    pose: FloatArray
    speed: float
    feet: FloatArray
    sweep: Sweep

    @classmethod
    def of(cls, truth: Truth) -> 'TruthEntry':
        """Return the part of a simulator's truth that scoring needs."""
        feet = np.array(truth.foot[:, :2])
        feet[truth.foot_depth <= 0.0] = np.nan
        return cls(time=truth.time, pose=np.array(truth.pose),
                   speed=float(np.hypot(truth.velocity[0], truth.velocity[1])), feet=feet,
                   sweep=truth.sweep)

    @property
    def grounded_feet(self) -> FloatArray:
        """Feet (n, 2) that press on the ground, map frame [m]."""
        return self.feet[np.isfinite(self.feet).all(axis=1)]


class TruthLog:
    """Writes entries as lines of a CSV file, each complete on disk before the next.

    Parameters
    ----------
    path : Path
    """

    def __init__(self, path: Path) -> None:
        self._file: TextIO = path.open('w', newline='')
        self._writer = csv.writer(self._file)
        self._writer.writerow(COLUMNS)
        self._file.flush()

    def write(self, entry: TruthEntry) -> None:
        """Add one entry."""
        row = [entry.time, *entry.pose, entry.speed, *entry.sweep, *entry.feet.ravel()]
        self._writer.writerow([f'{value:.6g}' for value in row])
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def read_truth(path: Path) -> list[TruthEntry]:
    """Return the entries of a truth log; a last line that was cut off is left out.

    A file that is still empty has no entries.

    Raises
    ------
    TruthLogError
        When the file is not a truth log.
    """
    with path.open(newline='') as file:
        rows = list(csv.reader(file))
    if not rows:
        return []
    if rows[0] != COLUMNS:
        raise TruthLogError(f'{path} is not a truth log: expected a first line that begins with '
                            f'{COLUMNS[:3]}')
    entries = []
    for row in rows[1:]:
        if len(row) != len(COLUMNS):
            continue
        values = np.array(row, dtype=np.float64)
        entries.append(TruthEntry(time=float(values[0]), pose=values[1:4], speed=float(values[4]),
                                  sweep=Sweep(*(float(value) for value in values[5:9])),
                                  feet=values[9:].reshape(FEET, 2)))
    return entries
