# SPDX-License-Identifier: Apache-2.0
"""What a run leaves behind: enough to score it, draw it and compare it with another."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from shapely.geometry import Polygon

from psane_mapping.grid import FloatArray, Grid
from psane_mapping.sample import TerrainSample
from psane_planner.status import Plan
from psane_sim.runs.truth_log import TruthEntry


@dataclass(kw_only=True)
class RunRecord:
    """Gathers a run while it happens; points in the map frame [m], times of the simulation [s].

    Parameters
    ----------
    grid : Grid
        Cells of every map below.
    start, goal : (2,) float or None
        Where the run began, and where it should end (`None` when exploring).
    path : list of (time, x, y)
        True way of the body's centre.
    contacts : list of (time, x, y, slip)
        Accepted contacts, with the slip that was felt [-].
    samples : list of TerrainSample
        The same contacts with all that the map was told.
    postures : list of (time, position (3), quaternion (4), joint angles (6))
        True attitudes of body and legs, where the robot has them [m], x y z w [-], [rad].
    subgoals : list of (time, x, y)
    progress : list of (time, distance to the goal [m], certified area [m^2])
    certified, slip_mean, slip_std : (rows, columns) arrays or None
        The last maps.
    frontier : (n, 2) float
        The last frontier.
    region : Polygon or None
        The last region that was handed to the controller.
    truth : list of TruthEntry
        Where the robot truly was, 20 times a second.
    refused : dict of int
        Stances that were not used, by reason.
    """

    grid: Grid
    start: FloatArray
    goal: FloatArray | None
    path: list[tuple[float, float, float]] = field(default_factory=list)
    contacts: list[tuple[float, float, float, float]] = field(default_factory=list)
    samples: list[TerrainSample] = field(default_factory=list)
    postures: list[tuple[float, ...]] = field(default_factory=list)
    subgoals: list[tuple[float, float, float]] = field(default_factory=list)
    progress: list[tuple[float, float, float]] = field(default_factory=list)
    certified: NDArray[np.bool_] | None = None
    slip_mean: FloatArray | None = None
    slip_std: FloatArray | None = None
    frontier: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    region: Polygon | None = None
    truth: list[TruthEntry] = field(default_factory=list)
    refused: dict[str, int] = field(default_factory=dict)

    def note_subgoal(self, now: float, point: FloatArray) -> None:
        """Add a subgoal if it differs from the last one by more than a centimetre."""
        x, y = float(point[0]), float(point[1])
        if self.subgoals:
            _, last_x, last_y = self.subgoals[-1]
            if np.hypot(x - last_x, y - last_y) <= 0.01:
                return
        self.subgoals.append((now, x, y))

    def note_sample(self, sample: TerrainSample) -> None:
        """Add an accepted contact."""
        self.samples.append(sample)
        self.contacts.append((sample.time, float(sample.point[0]), float(sample.point[1]),
                              sample.slip))

    def note_plan(self, plan: Plan, now: float, maps: tuple[FloatArray, FloatArray]) -> None:
        """Keep what a picture needs of a plan and of the maps (mean, std of slip) it rests on."""
        if plan.subgoal is not None:
            self.note_subgoal(now, plan.subgoal)
        self.progress.append((now, plan.distance_to_goal, plan.certified_area))
        self.certified, self.region = plan.certified, plan.region
        self.slip_mean, self.slip_std = maps
        if plan.frontier is not None:
            self.frontier = plan.frontier.points
