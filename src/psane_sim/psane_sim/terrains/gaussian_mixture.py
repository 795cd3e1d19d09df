# SPDX-License-Identifier: Apache-2.0
"""Slip as a sum of Gaussians, read from a CSV file in normalised coordinates."""

import csv
import math
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from psane_mapping.grid import FloatArray
from psane_sim.errors import TerrainFileError


@dataclass(frozen=True)
class Gaussian:
    """One bump of slip; lengths are shares of the workspace's edge.

    Parameters
    ----------
    gaussian_x, gaussian_y : float
        Centre, 0..1 [-].
    std_x, std_y : float
        Standard deviations along the bump's own axes [-].
    rotation : float
        Of those axes, counter-clockwise [rad].
    amplitude : float
        Slip at the centre [-].
    """

    gaussian_x: float
    gaussian_y: float
    std_x: float
    std_y: float
    rotation: float
    amplitude: float


COLUMNS = tuple(entry.name for entry in fields(Gaussian))


def read_mixture(path: Path) -> list[Gaussian]:
    """Read a CSV file with the columns of `Gaussian` (any order, header in the first line).

    Raises
    ------
    TerrainFileError
        With the line and column of what is wrong.
    """
    try:
        text = path.read_text(encoding='utf-8-sig')
    except (OSError, UnicodeDecodeError) as error:
        raise TerrainFileError(str(path), f'cannot be read: {error}') from error
    lines = list(csv.reader(text.splitlines()))
    if not lines:
        raise TerrainFileError(str(path), 'is empty, expected a header', 1, 1)
    order = _column_order(path, [cell.strip() for cell in lines[0]])
    mixture = [_gaussian(path, number, row, order)
               for number, row in enumerate(lines[1:], start=2) if any(c.strip() for c in row)]
    if not mixture:
        raise TerrainFileError(str(path), 'holds no Gaussian', len(lines), 1)
    return mixture


def _column_order(path: Path, header: list[str]) -> dict[str, int]:
    for position, name in enumerate(header, start=1):
        if name not in COLUMNS or header.index(name) != position - 1:
            raise TerrainFileError(str(path), f'column {name!r}, expected each of '
                                   f'{list(COLUMNS)} once', 1, position)
    missing = [name for name in COLUMNS if name not in header]
    if missing:
        raise TerrainFileError(str(path), f'columns {missing} are missing', 1, len(header) + 1)
    return {name: header.index(name) for name in COLUMNS}


def _gaussian(path: Path, line: int, row: list[str], order: dict[str, int]) -> Gaussian:
    if len(row) != len(order):
        raise TerrainFileError(str(path), f'{len(row)} values, expected {len(order)}', line,
                               min(len(row), len(order)) + 1)
    values = {}
    for name, index in order.items():
        try:
            values[name] = float(row[index])
        except ValueError:
            raise TerrainFileError(str(path), f'{name} = {row[index]!r}, expected a number',
                                   line, index + 1) from None
        if not math.isfinite(values[name]) or (name in ('std_x', 'std_y') and values[name] <= 0):
            raise TerrainFileError(str(path), f'{name} = {row[index].strip()}, expected a finite '
                                   'number' + (' above 0' if name.startswith('std') else ''),
                                   line, index + 1)
    return Gaussian(**values)


def mixture_slip(mixture: list[Gaussian], points: FloatArray) -> FloatArray:
    """Return the sum of the Gaussians at normalised points (..., 2), not clipped."""
    total = np.zeros(np.shape(points)[:-1])
    for bump in mixture:
        x, y = points[..., 0] - bump.gaussian_x, points[..., 1] - bump.gaussian_y
        cosine, sine = math.cos(bump.rotation), math.sin(bump.rotation)
        along = (cosine * x + sine * y) / bump.std_x
        across = (cosine * y - sine * x) / bump.std_y
        total += bump.amplitude * np.exp(-0.5 * (along**2 + across**2))
    return total
