# SPDX-License-Identifier: Apache-2.0
"""What comes out of one planning cycle."""

from dataclasses import dataclass
from enum import IntEnum

from shapely.geometry import Polygon

from psane_mapping.grid import FloatArray
from psane_planner.discs import Mask
from psane_planner.scores import FrontierScores


class PlannerState(IntEnum):
    """What the planner is doing; the numbers are those of `psane_msgs/PlannerStatus`."""

    WAITING = 0
    SEEKING = 1
    TO_GOAL = 2
    REACHED = 3
    EXPLORED = 4
    STALLED = 5
    LOST = 6


@dataclass(frozen=True, kw_only=True)
class Decision:
    """Where to go and why.

    Parameters
    ----------
    state : PlannerState
    cause : str
        Why, in words; empty where the state says it all.
    remedy : str
        What would help; empty where nothing is wrong.
    subgoal : (2,) float, map frame [m], or None
        Point to steer to, inside the region.
    subgoal_is_goal : bool
        True when the robot is to stop there for good.
    subgoal_note : str
        Why the subgoal is not the point that was chosen; empty when it is.
    focus : (2,) float, map frame [m], or None
        The ground that is to be felt from the subgoal.
    march : bool
        The legs are to keep feeling on the spot.
    is_refused : bool
        The goal is not taken; the cause says why, the remedy names the nearest that would be.
    """

    state: PlannerState
    cause: str = ''
    remedy: str = ''
    subgoal: FloatArray | None = None
    subgoal_is_goal: bool = False
    subgoal_note: str = ''
    focus: FloatArray | None = None
    march: bool = False
    is_refused: bool = False


@dataclass(frozen=True, kw_only=True)
class Plan(Decision):
    """One planning cycle: the decision and all it rests on.

    Parameters
    ----------
    now : float [s]
    strategy : str
    goal : (2,) float, map frame [m], or None
        None when exploring.
    distance_to_goal : float [m]
        Straight; NaN without a goal or pose.
    region : shapely Polygon, map frame [m], or None
        Where the robot may be steered.
    certified, component : (rows, columns) bool
        S_t, and its piece around the robot.
    frontier : FrontierScores or None
        None where no frontier was looked for.
    lower, upper : (rows, columns) float [-], slip ratio
        Ends of C_t.
    interval_resets, total_interval_resets : int
        Cells whose interval was started over, in this cycle and since the start.
    certified_area : float [m^2]
        Of the robot's component.
    subgoal_count : int
        Frontiers chosen since the goal was set.
    """

    now: float
    strategy: str
    goal: FloatArray | None
    distance_to_goal: float
    region: Polygon | None
    certified: Mask
    component: Mask
    frontier: FrontierScores | None
    lower: FloatArray
    upper: FloatArray
    interval_resets: int
    total_interval_resets: int
    certified_area: float
    subgoal_count: int

    @property
    def certified_cells(self) -> int:
        """Number of certified cells in the robot's component."""
        return int(self.component.sum())

    @property
    def frontier_count(self) -> int:
        """Number of frontier cells."""
        return 0 if self.frontier is None else self.frontier.count
