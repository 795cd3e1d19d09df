# SPDX-License-Identifier: Apache-2.0
"""What one accepted stance said of the ground, and the same as 64 bytes that notice damage."""

import struct
import zlib
from dataclasses import dataclass, fields

import numpy as np

from psane_mapping.errors import ShapeError
from psane_mapping.grid import FloatArray

_LAYOUT = struct.Struct('<7di')
_CHECK = struct.Struct('<I')
RECORD_BYTES = _LAYOUT.size + _CHECK.size
"""Length of one record [count]."""


@dataclass(frozen=True, kw_only=True)
class TerrainSample:
    """What one accepted stance said of the ground.

    Parameters
    ----------
    time : float
        Of lift-off [s].
    point : (2,) float, map frame [m]
    leg : int
    strength : float
        Penetration resistance relative to ground of strength 1 [-].
    log_strength_deviation : float
        Standard deviation of its natural logarithm [-].
    slip, slip_deviation : float
        Slip ratio expected there and its standard deviation, as given to the map [-].
    """

    time: float
    point: FloatArray
    leg: int
    strength: float
    log_strength_deviation: float
    slip: float
    slip_deviation: float

    def __post_init__(self) -> None:
        """Refuse numbers that no stance can give."""
        point = np.array(self.point, dtype=np.float64)
        if point.shape != (2,) or not np.isfinite(point).all():
            raise ShapeError(f'point = {self.point}, expected two finite coordinates [m]')
        point.setflags(write=False)
        object.__setattr__(self, 'point', point)
        for entry in fields(self):
            if entry.name != 'point' and not np.isfinite(getattr(self, entry.name)):
                raise ShapeError(f'{entry.name} = {getattr(self, entry.name)}, '
                                 'expected a finite number')
        for name in ('strength', 'log_strength_deviation', 'slip_deviation'):
            if getattr(self, name) <= 0.0:
                raise ShapeError(f'{name} = {getattr(self, name)}, expected a number above 0')


def record_of(sample: TerrainSample) -> bytes:
    """Return a sample as a record: all its numbers, bit for bit, and their CRC-32."""
    body = _LAYOUT.pack(
        sample.time, sample.point[0], sample.point[1], sample.strength,
        sample.log_strength_deviation, sample.slip, sample.slip_deviation, sample.leg)
    return body + _CHECK.pack(zlib.crc32(body))


def sample_of(record: bytes) -> TerrainSample | None:
    """Return the sample of a record, or None for one that is torn or damaged."""
    if len(record) != RECORD_BYTES:
        return None
    body, check = record[:_LAYOUT.size], record[_LAYOUT.size:]
    if zlib.crc32(body) != _CHECK.unpack(check)[0]:
        return None
    time, x, y, strength, log_deviation, slip, deviation, leg = _LAYOUT.unpack(body)
    try:
        return TerrainSample(time=time, point=np.array([x, y]), leg=leg, strength=strength,
                             log_strength_deviation=log_deviation, slip=slip,
                             slip_deviation=deviation)
    except ShapeError:
        return None
