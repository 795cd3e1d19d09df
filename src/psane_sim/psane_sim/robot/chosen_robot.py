# SPDX-License-Identifier: Apache-2.0
"""A robot that was chosen by name, with the calibration that belongs to it, ready to be run."""

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.leg import RobotModel
from psane_mapping.parameters import from_mapping
from psane_mapping.propagation import slip_model_of
from psane_sim.calibration.calibration import read_calibration
from psane_sim.calibration.steered_walks import SteeredWalks, read_walks
from psane_sim.configuration import SOIL_NAMES, SimulatorConfiguration
from psane_sim.errors import TaskError
from psane_sim.robot.robots import read_robot, robot_names
from psane_sim.terrains.terrain import Terrain
from psane_sim.touch.configuration import TouchConfiguration

CALIBRATIONS = Path(__file__).parents[1] / 'data' / 'calibration'
DEFAULT_ROBOT, DEFAULT_SOIL = 'x_rhex', 'granular'


@dataclass(frozen=True)
class ChosenRobot:
    """A robot, its gait and calibration, and the ground that it walks on.

    Parameters
    ----------
    name : str
    model : RobotModel
    simulator, mapping, touch : dict
        Parameters that are not the defaults, by name, for `hexapod_sim`, `terrain_mapper` and
        `contact_sensor`.
    strength_factor : float
        By how much ground must be firmer than for the default robot [-].
    walks : SteeredWalks, optional
        What strides are compared with; None where they were not calibrated.
    """

    name: str
    model: RobotModel
    simulator: dict[str, Any]
    mapping: dict[str, Any]
    touch: dict[str, Any]
    strength_factor: float
    walks: SteeredWalks | None

    @property
    def model_parameters(self) -> dict[str, Any]:
        """The model's parameters that are not the default ones, by name."""
        plain = asdict(RobotModel())
        return {name: value for name, value in asdict(self.model).items() if value != plain[name]}

    def simulator_configuration(self, **changes: Any) -> SimulatorConfiguration:
        """Return the simulator's configuration."""
        made: SimulatorConfiguration = from_mapping(SimulatorConfiguration, self.simulator)
        return replace(made, **changes)

    def mapping_configuration(self) -> MappingConfiguration:
        """Return the mapper's configuration."""
        made: MappingConfiguration = from_mapping(MappingConfiguration, self.mapping)
        return made

    def touch_configuration(self) -> TouchConfiguration:
        """Return the contact sensor's configuration."""
        made: TouchConfiguration = from_mapping(TouchConfiguration, self.touch)
        return made

    def terrain_for(self, terrain: Terrain) -> Terrain:
        """Return a terrain as firm for this robot as it is for the default one.

        Its slip is that of this robot's calibrated curve at the strength that results.
        """
        if self.name == DEFAULT_ROBOT:
            return terrain
        firmer = terrain.scaled(self.strength_factor)
        strength = np.exp(firmer.strength_field.log_strength)
        slip = np.asarray(slip_model_of(self.mapping_configuration()).slip(strength))
        return replace(firmer, slip=slip)


def strength_scale(model: RobotModel) -> float:
    """Return how much firmer than for the default robot the ground must be to carry this one.

    A leg of width w and radius R that is loaded with m g sinks by m g / (strength w R) or so; what
    counts is that depth as a share of R.
    """
    default = RobotModel()

    def load(robot: RobotModel) -> float:
        return robot.mass / (robot.leg_width * robot.leg_radius**2)

    return load(model) / load(default)


def choose_robot(name: str = DEFAULT_ROBOT, soil: str = DEFAULT_SOIL,
                 calibration: Path | None = None) -> ChosenRobot:
    """Return a robot by its shipped name or from its YAML file, on a soil by name.

    The shipped calibration is loaded with a shipped robot; that of the default robot is what the
    parameters' defaults are, so that nothing is changed for it.

    Raises
    ------
    TaskError
        For a soil that there is not.
    RobotFileError, ParameterError
        For a robot or a calibration that cannot be used.
    """
    if soil not in SOIL_NAMES:
        raise TaskError(f'unknown soil {soil!r}; available: {list(SOIL_NAMES)}')
    robot = read_robot(name)
    if calibration is None and name in robot_names() and name != DEFAULT_ROBOT:
        calibration = CALIBRATIONS / f'{name}.yaml'
    mapping, feed_forward = ({}, {}) if calibration is None else read_calibration(calibration)
    simulator = {**robot.gait, **feed_forward}
    if soil != DEFAULT_SOIL:
        simulator['soil'] = soil
    beside = CALIBRATIONS / f'{name}_walks.csv' if calibration is None else \
        calibration.with_name(f'{calibration.stem}_walks.csv')
    light = robot.model.mass / RobotModel().mass
    plain = TouchConfiguration()
    touch = {} if light == 1.0 else {
        'touch_down_force': light * plain.touch_down_force,
        'lift_off_force': light * plain.lift_off_force}
    return ChosenRobot(robot.name, robot.model, simulator, mapping, touch,
                       strength_scale(robot.model),
                       read_walks(beside) if beside.is_file() else None)
