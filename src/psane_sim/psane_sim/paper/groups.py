# SPDX-License-Identifier: Apache-2.0
"""What the trials of one task and strategy add up to."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from psane_sim.paper.task import STRATEGIES

Row = dict[str, Any]


class Spread(NamedTuple):
    """Mean and standard deviation (of the sample) of some trials; NaN without any."""

    mean: float
    deviation: float
    trials: int


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A figure of merit.

    Parameters
    ----------
    name : str
        Key in the summary.
    heading : str
        With its unit.
    digits : int
        After the point.
    of_arrivals : bool
        Counted over trials that reached the goal only: what another trial took says how long it
        was allowed to.
    """

    name: str
    heading: str
    digits: int
    of_arrivals: bool = False


QUANTITIES = (
    Quantity(name='success', heading='success', digits=2),
    Quantity(name='time_s', heading='time [s]', digits=1, of_arrivals=True),
    Quantity(name='path_m', heading='path [m]', digits=2, of_arrivals=True),
    Quantity(name='unsafe_time_s', heading='unsafe [s]', digits=2),
    Quantity(name='unsafe_foot_share', heading='unsafe feet', digits=4),
    Quantity(name='false_certified_cells', heading='false cells', digits=0),
    Quantity(name='coverage', heading='coverage', digits=2),
    Quantity(name='time_ratio', heading='time / optimum', digits=2, of_arrivals=True),
    Quantity(name='length_ratio', heading='path / optimum', digits=2, of_arrivals=True),
)

HAS_GOAL = 'goal'
"""How the names of tasks begin that have one."""


def quantity_named(name: str) -> Quantity:
    """Return a figure of merit by its key."""
    return next(quantity for quantity in QUANTITIES if quantity.name == name)


@dataclass(frozen=True, kw_only=True)
class Group:
    """Trials that differ in their seed only."""

    task: str
    strategy: str
    rows: tuple[Row, ...]

    @property
    def endings(self) -> Counter[str]:
        """How often each reason of an end came up."""
        return Counter(row['summary']['reason'] for row in self.rows)

    def spread(self, quantity: Quantity) -> Spread:
        """Return a figure of merit over the trials that have it."""
        if quantity.name == 'success' and not self.has_goal:
            # The paper calls no exploration a success or a failure; its safety is a figure apart.
            return Spread(float('nan'), float('nan'), 0)
        values = [float(row['summary'][quantity.name]) for row in self.rows
                  if row['summary'].get(quantity.name) is not None
                  and not (quantity.of_arrivals and self.has_goal
                           and row['summary']['reason'] != 'REACHED')]
        if not values:
            return Spread(float('nan'), float('nan'), 0)
        deviation = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
        return Spread(float(np.mean(values)), deviation, len(values))

    @property
    def has_goal(self) -> bool:
        """Whether the task is to reach a goal."""
        return self.task.startswith(HAS_GOAL)


def grouped(rows: Sequence[Row]) -> list[Group]:
    """Return the rows by task, in the order in which those come, and strategy."""
    tasks = list(dict.fromkeys(row['task'] for row in rows))
    groups = []
    for task in tasks:
        for strategy in sorted({row['strategy'] for row in rows if row['task'] == task},
                               key=_rank):
            chosen = [row for row in rows if (row['task'], row['strategy']) == (task, strategy)]
            groups.append(Group(task=task, strategy=strategy,
                                rows=tuple(sorted(chosen, key=lambda row: row['seed']))))
    return groups


def _rank(strategy: str) -> tuple[int, str]:
    known = strategy in STRATEGIES
    return (STRATEGIES.index(strategy) if known else len(STRATEGIES), strategy)
