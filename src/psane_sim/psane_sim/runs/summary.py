# SPDX-License-Identifier: Apache-2.0
"""The outcome of a run in numbers: written as `summary.json` and printed for people."""

import json
import platform
from dataclasses import asdict, dataclass
from enum import Enum
from importlib import metadata
from pathlib import Path
from typing import Any

from psane_sim.runs.scoring import Score
from psane_sim.touch.summary import touch_in_words

VERSIONED = ('numpy', 'scipy', 'shapely', 'opencv-python-headless', 'numba', 'pybullet')


class Ending(Enum):
    """Why a run ended."""

    REACHED = 'the goal is reached'
    EXPLORED = 'no ground is left that could be certified'
    STALLED = 'the planner has nothing left to try'
    STUCK = 'the robot has sunk in and does not get away'
    TIMEOUT = 'the time is over'
    INTERRUPTED = 'interrupted by the user'
    NODE_DIED = 'a node died'


@dataclass(frozen=True, kw_only=True)
class Task:
    """What a run was asked to do; points in the map frame [m], slip [-], times [s]."""

    terrain: str
    start: tuple[float, float]
    goal: tuple[float, float] | None
    strategy: str
    threshold: float
    seed: int
    duration: float
    robot: str = 'x_rhex'
    soil: str = 'granular'


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How a run ended.

    Parameters
    ----------
    ending : Ending
    cause : str
        The planner's or the demo's own words, may be empty.
    time : float
        Simulated time from the start to the end [s].
    subgoals, contacts : int
        Subgoals chosen, and contacts that the map accepted [count].
    wall : float
        Time that the run took on the clock on the wall [s].
    """

    ending: Ending
    cause: str
    time: float
    subgoals: int
    contacts: int
    wall: float


def is_success(task: Task, outcome: Outcome, score: Score) -> bool:
    """Tell whether the task is done and the robot was never on truly unsafe ground.

    With a goal the task is done when it is reached; exploring, when nothing is left to certify or
    the time is over.
    """
    done = {Ending.REACHED} if task.goal is not None else {Ending.EXPLORED, Ending.TIMEOUT}
    return outcome.ending in done and score.unsafe_time_s == 0.0


def versions() -> dict[str, str]:
    """Return the versions that a result may depend on."""
    found = {'python': platform.python_version()}
    for name in VERSIONED:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = 'unknown'
    return found


def summarise(task: Task, outcome: Outcome, score: Score,
              touch: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return the summary; only the object `timing` may differ between equal runs.

    `touch` is what `touch_summary` says of the run.
    """
    numbers = {name: round(value, 6) for name, value in asdict(score).items()}
    return {
        'success': is_success(task, outcome, score),
        'reason': outcome.ending.name,
        'cause': outcome.cause,
        'time_s': round(outcome.time, 3),
        **numbers,
        'subgoals': outcome.subgoals,
        'contacts': outcome.contacts,
        **(touch or {}),
        **asdict(task),
        'versions': versions(),
        'timing': {'real_time_factor': round(outcome.time / max(outcome.wall, 1e-9), 2),
                   'wall_s': round(outcome.wall, 2)},
    }


def write_summary(summary: dict[str, Any], path: Path) -> None:
    """Write the summary as JSON, whole or not at all."""
    unfinished = path.with_suffix('.part')
    unfinished.write_text(json.dumps(summary, indent=2) + '\n')
    unfinished.replace(path)


def in_words(summary: dict[str, Any]) -> str:
    """Return the lines that are printed at the end of a run."""
    verdict = 'success' if summary['success'] else 'no success'
    reason = Ending[summary['reason']].value
    cause = f' ({summary["cause"]})' if summary['cause'] else ''
    timing = summary['timing']
    touch = touch_in_words(summary)
    return '\n'.join((
        f'{verdict}: {reason}{cause}',
        f'  time                  {summary["time_s"]:.1f} s simulated, {timing["wall_s"]:.1f} s '
        f'on the wall (x{timing["real_time_factor"]:.1f})',
        f'  path                  {summary["path_m"]:.2f} m, {summary["subgoals"]} subgoals, '
        f'{summary["contacts"]} contacts',
        f'  on unsafe ground      {summary["unsafe_time_s"]:.1f} s, '
        f'feet {100.0 * summary["unsafe_foot_share"]:.2f} %',
        f'  certified             {summary["certified_cells"]} cells, '
        f'{summary["false_certified_cells"]} of them wrongly at any time, '
        f'coverage {100.0 * summary["coverage"]:.0f} %',
        *touch,
    ))
