# SPDX-License-Identifier: Apache-2.0
"""What can go wrong in the simulator package; every error says what was got and expected."""

from collections.abc import Iterable


class SimulationError(Exception):
    """Root of the simulator package's errors."""


class UnknownTerrainError(SimulationError, LookupError):
    """A terrain's name is neither built in nor a file."""

    def __init__(self, name: str, available: Iterable[str]) -> None:
        self.name = name
        self.available = sorted(available)
        super().__init__(f'unknown terrain {name!r}; available: {self.available}, or the path of '
                         'a .csv, .npy, .tif or .tiff file')


class TerrainFileError(SimulationError, ValueError):
    """A terrain file cannot be read; the message names the line (or row) and column."""

    def __init__(self, path: str, problem: str, line: int | None = None,
                 column: int | None = None) -> None:
        self.path = path
        self.line = line
        self.column = column
        place = '' if line is None else f', line {line}'
        place += '' if column is None else f', column {column}'
        super().__init__(f'{path}{place}: {problem}')


class StartError(SimulationError, ValueError):
    """The robot cannot be put where it was asked for."""


class FallenError(SimulationError, RuntimeError):
    """The simulated state is not finite any more."""


class TaskError(SimulationError, ValueError):
    """A task makes no sense: a point outside the workspace, a duration out of range."""


class GraphError(SimulationError, RuntimeError):
    """The ROS graph does not come up, or a node of it is not installed."""


class AuditError(SimulationError, RuntimeError):
    """An audit cannot run as it was asked for: other settings in the folder, no scheduler."""


class PaperError(SimulationError, RuntimeError):
    """The paper's experiments cannot run, or a row cannot be replayed, as it was asked for."""
