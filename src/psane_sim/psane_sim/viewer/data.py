# SPDX-License-Identifier: Apache-2.0
"""What the live view is told, as plain data."""

from dataclasses import dataclass

from psane_mapping.grid import FloatArray


@dataclass(frozen=True, kw_only=True)
class Situation:
    """What a planner says of itself.

    Parameters
    ----------
    state, cause, remedy, strategy : str
        In words; cause and remedy may be empty.
    distance : float
        To the goal [m]; not a number without one.
    area : float
        Certified around the robot [m^2].
    subgoals : int
        Chosen since the goal was set.
    march : bool
        The robot feels the ground on the spot.
    """

    state: str
    cause: str
    remedy: str
    strategy: str
    distance: float
    area: float
    subgoals: int
    march: bool


@dataclass(frozen=True, kw_only=True)
class Click:
    """A goal that somebody chose on the page.

    Parameters
    ----------
    robot : str
        Whose goal it is.
    point : (2,) float, map frame [m]
    """

    robot: str
    point: FloatArray
