# SPDX-License-Identifier: Apache-2.0
"""All four maps as they are published, and the slip maps as a planner reads them back."""

from dataclasses import dataclass

from psane_mapping import encoding
from psane_mapping.configuration import MappingConfiguration
from psane_mapping.encoding import Cells
from psane_mapping.grid import FloatArray
from psane_mapping.mapper import TerrainMaps

SLIP_MEAN, SLIP_STD = 'slip/mean', 'slip/std'
STRENGTH_MEAN, STRENGTH_STD = 'strength/mean', 'strength/std'


@dataclass(frozen=True, kw_only=True)
class MapSteps:
    """How the cells of the maps are read; published beside them.

    Parameters
    ----------
    std_scale : float
        One step of the standard deviation of slip [-].
    log_strength_std_scale : float
        One step of the standard deviation of log-strength [-].
    strength_low, strength_high : float
        Strengths at cell values 0 and 100 [-].
    """

    std_scale: float
    log_strength_std_scale: float
    strength_low: float
    strength_high: float

    @classmethod
    def of(cls, config: MappingConfiguration) -> 'MapSteps':
        """Return the steps that a configuration asks for."""
        return cls(std_scale=config.std_scale, log_strength_std_scale=config.log_std_scale,
                   strength_low=config.lowest_strength, strength_high=config.highest_strength)


def cells_of_maps(maps: TerrainMaps, steps: MapSteps) -> dict[str, Cells]:
    """Return the cells (rows, columns) of each map under its topic's name."""
    slip_mean, slip_std = cells_of_slip(maps, steps)
    return {
        SLIP_MEAN: slip_mean, SLIP_STD: slip_std,
        STRENGTH_MEAN: encoding.encode_log_strength(maps.log_strength_mean, steps.strength_low,
                                                    steps.strength_high),
        STRENGTH_STD: encoding.encode_std(maps.log_strength_std, steps.log_strength_std_scale),
    }


def cells_of_slip(maps: TerrainMaps, steps: MapSteps) -> tuple[Cells, Cells]:
    """Return the cells (rows, columns) of mean and standard deviation of slip."""
    return (encoding.encode_slip_mean(maps.slip_mean),
            encoding.encode_std(maps.slip_std, steps.std_scale))


def slip_of_cells(mean: Cells, std: Cells, std_scale: float) -> tuple[FloatArray, FloatArray]:
    """Return slip mean and standard deviation [-] from published cells; NaN where unknown.

    The arrays are read-only, so that whoever keeps one can tell it from a newer one by identity.
    """
    decoded = encoding.decode_slip_mean(mean), encoding.decode_std(std, std_scale)
    for array in decoded:
        array.setflags(write=False)
    return decoded
