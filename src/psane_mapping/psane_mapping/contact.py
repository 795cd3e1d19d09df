# SPDX-License-Identifier: Apache-2.0
"""One stance of one leg, as felt: what the robot hands to the mapper.

The record holds what was measured and, beside it, what the same motion would have met in ground of
strength 1. So the mapper needs to know nothing of the robot's legs, and any robot that can fill in
this record can be mapped with.
"""

import math
from dataclasses import dataclass

import numpy as np

from psane_mapping.errors import ShapeError
from psane_mapping.grid import FloatArray


@dataclass(frozen=True, kw_only=True)
class LegContact:
    """Force-depth record of one stance, from touch-down to lift-off.

    Parameters
    ----------
    leg : int
        Index of the leg.
    touch_down, lift_off : float
        Times of first and last sample [s].
    point : (2,) float, map frame [m]
        Where the ground was felt: centre of the loaded part of the foot, weighted by load.
    point_deviation : float
        Standard deviation of `point` along each axis [m].
    depth : (n,) float [m]
        Deepest point of the foot below the undisturbed surface.
    measured : (n, 3) float [N]
        Force of the ground on the leg: forward (body heading), up, and hip moment / moment arm.
    response : (n, 3) float [N]
        The same three channels predicted for ground of strength 1 under the observed motion.
    deviation : (n, 3) float [N]
        Standard deviation of the noise of `measured`.
    has_velocity : bool
        True when `response` was computed with a trusted body velocity; without one only the
        vertical channel means anything.
    """

    leg: int
    touch_down: float
    lift_off: float
    point: FloatArray
    point_deviation: float
    depth: FloatArray
    measured: FloatArray
    response: FloatArray
    deviation: FloatArray
    has_velocity: bool = True

    def __post_init__(self) -> None:
        """Check shapes and finiteness and freeze the arrays."""
        count = np.asarray(self.depth).shape[0] if np.ndim(self.depth) == 1 else -1
        shapes = {'point': (2,), 'depth': (count,), 'measured': (count, 3),
                  'response': (count, 3), 'deviation': (count, 3)}
        for name, shape in shapes.items():
            array = np.array(getattr(self, name), dtype=np.float64)
            if array.shape != shape:
                raise ShapeError(f'{name} has shape {array.shape}, expected {shape}')
            if not np.isfinite(array).all():
                raise ShapeError(f'{name} holds a number that is not finite')
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        for name, value in vars(self).items():
            if isinstance(value, float) and not math.isfinite(value):
                raise ShapeError(f'{name} = {value}, expected a finite number')
