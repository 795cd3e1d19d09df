# SPDX-License-Identifier: Apache-2.0
"""Terrains by name or by file."""

from pathlib import Path

import numpy as np
from scipy.ndimage import map_coordinates

from psane_mapping.grid import FloatArray
from psane_sim.errors import TerrainFileError, UnknownTerrainError
from psane_sim.terrains import heterogeneous
from psane_sim.terrains.endpoints import choose_endpoints
from psane_sim.terrains.gaussian_mixture import mixture_slip, read_mixture
from psane_sim.terrains.random_terrain import FAMILIES, random_terrain
from psane_sim.terrains.raster import read_geotiff, read_numpy
from psane_sim.terrains.terrain import WORKSPACE, Terrain, raise_border, terrain_grid

DATA = Path(__file__).parents[1] / 'data'

SHIPPED = {
    'env1': (DATA / 'env1.csv', (2.0, 5.0), (7.0, 1.5)),
    'env2': (DATA / 'env2.npy', heterogeneous.START, heterogeneous.GOAL),
}
"""File, start and goal of each named terrain."""


def terrain_names() -> list[str]:
    """Return the names that `load_terrain` knows (random ones take a seed after a colon)."""
    return [*SHIPPED, *(f'{family}:SEED' for family in FAMILIES)]


def load_terrain(name: str) -> Terrain:
    """Load a terrain.

    Parameters
    ----------
    name : str
        A shipped name (env1, env2), a random family with a seed (`patchy:3`), or the path of a
        .csv (Gaussian mixture), .npy or GeoTIFF file.

    Raises
    ------
    UnknownTerrainError
        Listing the names there are.
    TerrainFileError
        With line and column, for a file that cannot be read.
    """
    if name in SHIPPED:
        path, start, goal = SHIPPED[name]
        return Terrain.from_slip(name, read_slip(path), start, goal)
    family, colon, seed = name.partition(':')
    if colon and family in FAMILIES and seed.isdecimal():
        return random_terrain(family, int(seed))
    path = Path(name).expanduser()
    if path.suffix.lower() not in READERS or not path.is_file():
        raise UnknownTerrainError(name, terrain_names())
    slip = read_slip(path)
    grid = terrain_grid()
    ends = choose_endpoints(raise_border(slip, grid), grid)
    if ends is None:
        raise TerrainFileError(str(path), 'holds no safe ground (slip of at most 0.5)')
    return Terrain.from_slip(path.stem, slip, *ends)


def read_slip(path: Path) -> FloatArray:
    """Read a file's slip onto `terrain_grid`, (rows, columns)."""
    return READERS[path.suffix.lower()](path)


def _from_mixture(path: Path) -> FloatArray:
    grid = terrain_grid()
    min_x, min_y, max_x, max_y = WORKSPACE
    points = (grid.points - (min_x, min_y)) / (max_x - min_x, max_y - min_y)
    return mixture_slip(read_mixture(path), points).reshape(grid.shape)


def _stretched(values: FloatArray) -> FloatArray:
    """Interpolate a raster whose outermost samples lie on the workspace's edge."""
    grid = terrain_grid()
    rows = np.linspace(0.0, values.shape[0] - 1.0, grid.rows)
    columns = np.linspace(0.0, values.shape[1] - 1.0, grid.columns)
    at = np.meshgrid(rows, columns, indexing='ij')
    return np.asarray(map_coordinates(values, at, order=1, mode='nearest'))


READERS = {
    '.csv': _from_mixture,
    '.npy': lambda path: _stretched(read_numpy(path)),
    '.tif': lambda path: _stretched(read_geotiff(path)),
    '.tiff': lambda path: _stretched(read_geotiff(path)),
}
"""How each kind of file is read."""
