# SPDX-License-Identifier: Apache-2.0
"""Slip from a raster: a numpy file or a GeoTIFF, stretched over the workspace."""

from pathlib import Path

import numpy as np

from psane_mapping.grid import FloatArray
from psane_sim.errors import TerrainFileError


def read_numpy(path: Path) -> FloatArray:
    """Read slip (rows, columns) from a .npy file; row = y upwards, column = x."""
    try:
        values = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise TerrainFileError(str(path), f'cannot be read as a numpy array: {error}') from error
    if not isinstance(values, np.ndarray):
        raise TerrainFileError(str(path), 'holds several arrays, expected one')
    return _checked(path, values)


def read_geotiff(path: Path) -> FloatArray:
    """Read slip from the first band of a GeoTIFF, turned so that row 0 is the south."""
    try:
        import rasterio  # noqa: PLC0415 - an optional dependency, wanted only here
    except ImportError:
        raise TerrainFileError(str(path), 'GeoTIFF needs the Python package rasterio, which is '
                               'not installed: pip install rasterio, or save the slip as .npy'
                               ) from None
    try:
        with rasterio.open(path) as source:
            values = source.read(1, masked=True).astype(np.float64).filled(np.nan)
    except rasterio.errors.RasterioError as error:
        raise TerrainFileError(str(path), f'cannot be read as a GeoTIFF: {error}') from error
    return _checked(path, values)[::-1].copy()


def _checked(path: Path, values: FloatArray) -> FloatArray:
    """Refuse what is not a 2-D array of finite slips in 0..1, naming the first bad row."""
    if values.ndim != 2 or min(values.shape) < 2:
        raise TerrainFileError(str(path), f'has shape {values.shape}, expected (rows, columns) '
                               'with at least 2 of each')
    if not (np.issubdtype(values.dtype, np.floating) or np.issubdtype(values.dtype, np.integer)):
        raise TerrainFileError(str(path), f'holds {values.dtype}, expected numbers')
    slip = values.astype(np.float64)
    bad = np.argwhere(~(np.isfinite(slip) & (slip >= 0.0) & (slip <= 1.0)))
    if len(bad):
        row, column = (int(index) for index in bad[0])
        raise TerrainFileError(str(path), f'slip {slip[row, column]:g}, expected 0 to 1',
                               row + 1, column + 1)
    return slip
