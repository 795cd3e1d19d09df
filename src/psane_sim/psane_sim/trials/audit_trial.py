# SPDX-License-Identifier: Apache-2.0
"""One trial of the audit: a random terrain, the kinematic stand-in, and the truth beside it."""

import hashlib
import time
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from psane_mapping.grid import FloatArray
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import Mask
from psane_planner.safe_set import admissible_cells
from psane_sim.runs.kinematic_loop import KinematicLoop, KinematicSettings
from psane_sim.runs.scoring import Score
from psane_sim.runs.simulated_touch import SimulatedTouchConfiguration
from psane_sim.runs.summary import Ending, Outcome, Task, is_success
from psane_sim.terrains.omniscient import least_length, least_time
from psane_sim.terrains.random_terrain import random_terrain
from psane_sim.terrains.terrain import Terrain

BETAS = (0.0, 0.25, 1.0, 2.0, 3.0, 4.0, 6.0, 9.0)
"""Confidence scales at which the last map of each trial is judged [-]."""


MARGINS = (0.0, 0.05, 0.1, 0.15)
"""How far below the threshold slip stays along the best way is told in these steps [-]."""


@dataclass(frozen=True, kw_only=True)
class AuditSettings:
    """What all trials of an audit share.

    Parameters
    ----------
    duration : float
        Simulated time after which a trial ends [s].
    weaker : float
        Share by which the ground is weaker than touch says, 0..1 [-].
    noise : float
        What every noise and bias of the touch is multiplied by [-].
    planner : PlannerConfiguration
    """

    duration: float = 900.0
    weaker: float = 0.0
    noise: float = 1.0
    planner: PlannerConfiguration = field(default_factory=PlannerConfiguration)

    @property
    def fingerprint(self) -> str:
        """Short text that is the same for the same settings of all parts only."""
        return hashlib.sha256(repr((self, self.of_loop)).encode()).hexdigest()[:16]

    @property
    def of_loop(self) -> KinematicSettings:
        """Configurations of robot, touch, map, planner and steering."""
        touch = SimulatedTouchConfiguration(strength_factor=1.0 - self.weaker)
        return KinematicSettings(touch=touch.times(self.noise), planner=self.planner)


@dataclass(frozen=True, order=True)
class Trial:
    """One terrain: a family and a seed, which is that of the noise too."""

    family: str
    seed: int


def run_trial(trial: Trial, settings: AuditSettings) -> dict[str, Any]:
    """Run one trial; return its row of the table, made of numbers and words only."""
    began = time.process_time()
    terrain = random_terrain(trial.family, trial.seed)
    planner = settings.planner
    task = Task(terrain=terrain.name, start=terrain.start, goal=terrain.goal,
                strategy=planner.strategy, threshold=planner.slip_threshold, seed=trial.seed,
                duration=settings.duration)
    loop = KinematicLoop(task, terrain, terrain.start_pose, settings.of_loop)
    outcome, score = loop.run()
    return {'family': trial.family, 'seed': trial.seed,
            **_result(task, outcome, score), **_yardstick(terrain, planner),
            'calibration': _calibration(loop, terrain, planner),
            'cpu_s': round(time.process_time() - began, 2)}


def _result(task: Task, outcome: Outcome, score: Score) -> dict[str, Any]:
    return {'success': is_success(task, outcome, score), 'ending': outcome.ending.name,
            'cause': outcome.cause or Ending[outcome.ending.name].value,
            'time_s': round(outcome.time, 2), 'subgoals': outcome.subgoals,
            'contacts': outcome.contacts, 'wall_s': round(outcome.wall, 2),
            **{name: round(value, 5) for name, value in asdict(score).items()}}


def _yardstick(terrain: Terrain, planner: PlannerConfiguration) -> dict[str, Any]:
    """Return what a robot that knows the ground would need; None where it has no way either."""
    clearance = planner.clearance + planner.contour_tolerance
    details: dict[str, Any] = {'clearance': clearance,
               'border_width': planner.border_width, 'goal_tolerance': planner.goal_tolerance}
    ends, threshold = (terrain.start, terrain.goal), planner.slip_threshold
    length = least_length(terrain, *ends, threshold=threshold, **details)
    fastest = least_time(terrain, *ends, threshold=threshold, speed=0.3, **details)
    is_possible = bool(np.isfinite(length))
    possible = [margin for margin in MARGINS if np.isfinite(least_length(
        terrain, *ends, threshold=threshold - margin, **details))]
    return {'is_possible': is_possible, 'margin': max(possible, default=None),
            'least_length_m': round(length, 3) if is_possible else None,
            'least_time_s': round(fastest, 3) if np.isfinite(fastest) else None}


def _calibration(loop: KinematicLoop, terrain: Terrain, planner: PlannerConfiguration
                 ) -> list[tuple[int, int]]:
    """Return, for each of `BETAS`, what the last map alone would certify, and wrongly [cells].

    Ground that was not felt is left out: at a small beta the prior's mean would certify it all.
    """
    mean, std = loop.maps
    grid = loop.grid
    inner = admissible_cells(grid, planner.border_width) & (std < 0.6 * float(std.max()))
    unsafe = terrain.true_slip(grid.points).reshape(grid.shape) > planner.slip_threshold
    return [_count(mean + np.sqrt(beta) * std, planner.slip_threshold, inner, unsafe)
            for beta in BETAS]


def _count(upper: FloatArray, threshold: float, inner: Mask, unsafe: Mask
           ) -> tuple[int, int]:
    certified = (upper <= threshold) & inner
    return int(certified.sum()), int((certified & unsafe).sum())
