# SPDX-License-Identifier: Apache-2.0
"""A controller that notes what it did, tick by tick, for figures."""

import math
from typing import Any, NamedTuple

import numpy as np

from psane_reactive.clearance import Border
from psane_reactive.command import Command, Mode
from psane_reactive.controller import ReactiveController


class Tick(NamedTuple):
    """One command and what it came from.

    Parameters
    ----------
    time : float [s]
    command : Command
    border : Border or None
        Edge of the region that was steered in.
    direction : float
        From the robot to the point that is driven at, map frame [rad]; not finite where there
        is none.
    found_by : str
        What found the way: straight, the map's name, field; empty where none was asked.
    region_number, subgoal_number : int
        How many regions and subgoals that differ from the one before were heard so far.
    """

    time: float
    command: Command
    border: Border | None
    direction: float
    found_by: str
    region_number: int
    subgoal_number: int


class WatchedController(ReactiveController):
    """Gives the same commands, and keeps a list of ticks."""

    ticks: list[Tick]

    def __init__(self, *arguments: Any) -> None:
        self.ticks = []
        self._subgoal_number = self._region_number = 0
        self._known: object = None
        super().__init__(*arguments)

    def set_subgoal(self, point: Any, march: bool, is_goal: bool, now: float) -> None:
        """Take where to go, and count it when it is another place."""
        before = self.inputs.subgoal
        super().set_subgoal(point, march, is_goal, now)
        after = self.inputs.subgoal
        is_same = before is after or (before is not None and after is not None
                                      and bool(np.array_equal(before, after)))
        self._subgoal_number += not is_same

    def command(self, now: float) -> Command:
        """Return the command for the moment `now` [s], and note it."""
        self.aim = None
        command = super().command(now)
        self._region_number += self._guide is not self._known
        self._known = self._guide
        border = None if self._guide is None else self._guide.border
        direction = math.nan
        if self.aim is not None:
            away = self.aim.target - self.inputs.pose.position
            direction = math.atan2(away[1], away[0])
        self.ticks.append(Tick(now, command, border, direction,
                               '' if self.aim is None else self.aim.found_by,
                               self._region_number, self._subgoal_number))
        return command


def turns_at_updates(ticks: list[Tick], same_subgoal: bool) -> list[float]:
    """Return by how much the direction of travel changed at each new region [rad].

    Parameters
    ----------
    same_subgoal : bool
        True to leave out updates at which the robot was sent elsewhere, too.
    """
    turns = []
    for before, after in zip(ticks, ticks[1:], strict=False):
        if after.region_number == before.region_number or not _both_drive(before, after):
            continue
        if same_subgoal and after.subgoal_number != before.subgoal_number:
            continue
        change = after.direction - before.direction
        turns.append(abs(math.remainder(change, 2.0 * math.pi)))
    return turns


def _both_drive(before: Tick, after: Tick) -> bool:
    return all(math.isfinite(tick.direction) and tick.command.mode is not Mode.MARCH
               for tick in (before, after))
