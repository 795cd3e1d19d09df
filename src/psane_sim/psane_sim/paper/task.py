# SPDX-License-Identifier: Apache-2.0
"""The tasks of the paper, and the trials that they are made of."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

from psane_sim.terrains.terrain import Terrain

STRATEGIES = ('psane_geodesic', 'psane', 'pgh', 'sgh', 'ngh')
"""This project's strategy, then those of the paper, in the order of all tables."""


class Robot(Enum):
    """Which robot walks."""

    PHYSICS = 'physics'
    KINEMATIC = 'kinematic'


@dataclass(frozen=True, kw_only=True)
class PaperTask:
    """What all strategies are asked to do.

    Parameters
    ----------
    name : str
        Short, of letters, digits and underscores.
    terrain : str
        Name or file of the terrain.
    has_goal : bool
        Whether the terrain's goal is to be reached; otherwise ground is to be certified.
    duration : float
        Simulated time after which a trial ends [s].
    """

    name: str
    terrain: str
    has_goal: bool
    duration: float

    def ends(self, terrain: Terrain) -> tuple[tuple[float, float], tuple[float, float] | None]:
        """Return start and goal, map frame [m]."""
        return terrain.start, terrain.goal if self.has_goal else None


GOAL_ENV1 = PaperTask(name='goal_env1', terrain='env1', has_goal=True, duration=400.0)
GOAL_ENV2 = PaperTask(name='goal_env2', terrain='env2', has_goal=True, duration=400.0)
EXPLORE_ENV2 = PaperTask(name='explore_env2', terrain='env2', has_goal=False, duration=1000.0)
PAPER_TASKS = (GOAL_ENV1, GOAL_ENV2, EXPLORE_ENV2)

TITLES = {'goal_env1': 'Goal in environment 1 (smooth)',
          'goal_env2': 'Goal in environment 2 (heterogeneous)',
          'explore_env2': 'Exploration of environment 2'}
"""Heading of each of the paper's tasks."""


def task_on(terrain: str) -> PaperTask:
    """Return the task of reaching the goal of another terrain."""
    stem = Path(terrain).stem if Path(terrain).suffix else terrain
    name = ''.join(letter if letter.isalnum() else '_' for letter in stem)
    return PaperTask(name=f'goal_{name}', terrain=terrain, has_goal=True, duration=400.0)


def title_of(task: str) -> str:
    """Return the heading of a task, by its name."""
    return TITLES.get(task, f'Goal on {task.removeprefix("goal_")}')


@dataclass(frozen=True, kw_only=True)
class PaperTrial:
    """One run.

    Parameters
    ----------
    task : PaperTask
    strategy : str
    seed : int
        Of all noise.
    robot : Robot
    study, variant : str
        The ablation that the trial belongs to and its value there; empty for the main experiment.
    changes : pairs of (parameter, value)
        What is other than in the preset; see `paper_settings`.
    """

    task: PaperTask
    strategy: str
    seed: int
    robot: Robot
    study: str = ''
    variant: str = ''
    changes: tuple[tuple[str, object], ...] = field(default=())

    @property
    def name(self) -> str:
        """What the trial's row is called."""
        parts = [self.task.name, self.strategy, str(self.seed)]
        if self.study:
            parts[:0] = [f'{self.study}={self.variant}']
        return '-'.join(parts)


def paper_trials(tasks: Sequence[PaperTask], strategies: Sequence[str], count: int,
                 robot: Robot) -> list[PaperTrial]:
    """Return `count` trials of each task and strategy: seed by seed, so that all grow together."""
    return [PaperTrial(task=task, strategy=strategy, seed=seed, robot=robot)
            for seed in range(count) for task in tasks for strategy in strategies]
