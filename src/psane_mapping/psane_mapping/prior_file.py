# SPDX-License-Identifier: Apache-2.0
"""Prior maps from files: an image with its YAML (as map_server reads them) or a numpy array."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from psane_mapping.encoding import Cells, decode_log_strength, decode_slip_mean
from psane_mapping.errors import MapFileError, MappingError
from psane_mapping.grid import FloatArray, Grid
from psane_mapping.prior_map import PriorMap
from psane_mapping.slip import SlipModel

STRENGTH = 'strength'


def prior_of_cells(grid: Grid, cells: Cells, quantity: str, ends: tuple[float, float],
                   model: SlipModel) -> PriorMap:
    """Return the prior of the cells of an OccupancyGrid, 0..100, or -1 where unknown.

    Parameters
    ----------
    quantity : str
        'slip' in per cent, or 'strength', logarithmic from 0 to 100 between two `ends` [-].
    """
    if quantity == STRENGTH:
        return PriorMap.of_strength(grid, np.exp(decode_log_strength(cells, *ends)), model)
    return PriorMap.of_slip(grid, decode_slip_mean(cells), model)


def read_prior(path: Path, grid: Grid, quantity: str, ends: tuple[float, float],
               model: SlipModel) -> PriorMap:
    """Return the prior map of a file; `grid` is what a .npy file lies over.

    Raises
    ------
    MapFileError
        When there is no such file, or it does not hold a map.
    """
    try:
        if path.suffix == '.npy':
            return _of_array(np.load(path, allow_pickle=False), grid, quantity, model)
        if path.suffix in ('.yaml', '.yml'):
            place, cells = _read_image(path)
            return prior_of_cells(place, cells, quantity, ends, model)
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError) as error:
        raise MapFileError(f'cannot read the prior map {path}: {error}') from error
    raise MapFileError(f'prior map {path}, expected a name that ends in .yaml, .npy or .map')


def _of_array(values: FloatArray, grid: Grid, quantity: str, model: SlipModel) -> PriorMap:
    if values.shape != grid.shape:
        raise ValueError(f"it has shape {values.shape}, expected {grid.shape}, that of the map's "
                         'cells; a map elsewhere needs a .yaml that says where')
    make = PriorMap.of_strength if quantity == STRENGTH else PriorMap.of_slip
    return make(grid, np.asarray(values, dtype=np.float64), model)


def _read_image(path: Path) -> tuple[Grid, Cells]:
    """Return grid and cells of an image as nav2_map_server would load it.

    The first row of an image is its northern end. Mode `scale` maps black to 100 and white to 0
    (`negate` the other way round), `raw` takes the pixel for the cell; 101 and more is unknown.
    """
    with path.open(encoding='utf-8') as file:
        described: dict[str, Any] = yaml.safe_load(file)
    pixels = _read_pgm(path.parent / str(described['image']))
    x, y, yaw = (float(value) for value in described['origin'])
    if yaw != 0.0:
        raise ValueError(f'the map is rotated by {yaw} rad, expected 0')
    mode = described.get('mode', 'scale')
    if mode == 'raw':
        cells = np.where(pixels <= 100, pixels, -1.0)
    elif mode == 'scale':
        share = pixels / 255.0
        cells = np.round(100.0 * (share if described.get('negate', 0) else 1.0 - share))
    else:
        raise ValueError(f"mode = '{mode}', expected raw or scale")
    cells = cells[::-1].astype(np.int8)
    try:
        grid = Grid(origin_x=x, origin_y=y, resolution=float(described['resolution']),
                    rows=cells.shape[0], columns=cells.shape[1])
    except MappingError as error:
        raise ValueError(str(error)) from error
    return grid, cells


def _read_pgm(path: Path) -> FloatArray:
    """Return the pixels (rows, columns) of a binary PGM image (P5) as 0..255."""
    content = path.read_bytes()
    fields: list[bytes] = []
    position = 0
    while len(fields) < 4 and position < len(content):
        end = position
        if content[position:position + 1] == b'#':
            position = content.index(b'\n', position) + 1
            continue
        while end < len(content) and not content[end:end + 1].isspace():
            end += 1
        if end > position:
            fields.append(content[position:end])
        position = end + 1
    if len(fields) < 4 or fields[0] != b'P5':
        raise ValueError(f'{path} is not a binary PGM image (P5)')
    width, height, largest = (int(field) for field in fields[1:])
    if not 0 < largest < 256 or len(content) - position < width * height:
        raise ValueError(f'{path} holds fewer pixels than {width} x {height}, or wide ones')
    pixels = np.frombuffer(content, np.uint8, width * height, position).reshape(height, width)
    return np.asarray(pixels * (255.0 / largest), dtype=np.float64)
