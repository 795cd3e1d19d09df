# SPDX-License-Identifier: Apache-2.0
"""Robots by name or by file: sizes, masses, motors and gait."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from psane_mapping.leg import RobotModel
from psane_mapping.parameters import from_mapping
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.errors import SimulationError

FOLDER = Path(__file__).parents[1] / 'data' / 'robots'


class RobotFileError(SimulationError, ValueError):
    """A robot is not known, or its file cannot be used."""


@dataclass(frozen=True)
class Robot:
    """A robot and how it walks.

    Parameters
    ----------
    name : str
    model : RobotModel
    gait : dict
        What it sets of `SimulatorConfiguration`.
    """

    name: str
    model: RobotModel
    gait: dict[str, Any]

    def configuration(self, **changes: Any) -> SimulatorConfiguration:
        """Return the simulator's configuration for this robot."""
        plain: SimulatorConfiguration = from_mapping(SimulatorConfiguration, self.gait)
        return replace(plain, **changes)


def robot_names() -> list[str]:
    """Return the names of the robots that are shipped."""
    return sorted(path.stem for path in FOLDER.glob('*.yaml'))


def read_robot(name: str) -> Robot:
    """Read a robot by its shipped name or from the path of a YAML file.

    Raises
    ------
    RobotFileError
        Listing the names there are, or saying what is wrong with the file.
    ParameterError
        For a value outside its range.
    """
    path = FOLDER / f'{name}.yaml' if name in robot_names() else Path(name).expanduser()
    if path.suffix not in ('.yaml', '.yml') or not path.is_file():
        raise RobotFileError(f'unknown robot {name!r}; available: {robot_names()}, or the path of '
                             'a .yaml file')
    try:
        content = yaml.safe_load(path.read_text())
    except yaml.YAMLError as error:
        raise RobotFileError(f'{path}: {error}') from error
    if not isinstance(content, dict) or set(content) != {'robot', 'gait'}:
        raise RobotFileError(f"{path}: expected the two sections 'robot' and 'gait'")
    sections = [content[key] or {} for key in ('robot', 'gait')]
    if not all(isinstance(section, dict) for section in sections):
        raise RobotFileError(f'{path}: expected parameters by name in both sections')
    model: RobotModel = from_mapping(RobotModel, sections[0])
    from_mapping(SimulatorConfiguration, sections[1])
    return Robot(path.stem, model, sections[1])
