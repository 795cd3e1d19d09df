# SPDX-License-Identifier: Apache-2.0
"""The soil that a configuration asks for, with a terrain's strength and heights."""

from psane_mapping.leg import RobotModel
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.soils.element_soil import ElementSoil
from psane_sim.soils.family import SOILS, granular_law
from psane_sim.soils.ground_surface import fresh_prints
from psane_sim.terrains.terrain import Terrain


def soil_of(config: SimulatorConfiguration, robot: RobotModel, terrain: Terrain) -> ElementSoil:
    """Return fresh ground without a footprint in it."""
    field = terrain.strength_field
    if config.soil == 'granular':
        law = granular_law(field, displacement=config.soil_displacement,
                           damping=config.soil_damping)
    else:
        law = SOILS[config.soil](field)
    prints = None
    if config.footprints:
        prints = fresh_prints(config.footprint_cell, config.footprint_share,
                              config.footprint_refill_time, config.footprint_compaction)
    relief = None if terrain.height_field is None else terrain.height_field.relief
    return ElementSoil(robot, field, law, relief=relief, prints=prints)
