# SPDX-License-Identifier: Apache-2.0
"""Several robots in one world and one process: one map for all, a planner and legs for each.

Contacts between the robots are not simulated: each walks in an engine of its own, on the same
terrain. A robot keeps out of the way of those before it in the list.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from psane_mapping.mapper import TerrainMapper
from psane_sim.demo.options import Assignment
from psane_sim.progress import Progress
from psane_sim.runs.closed_loop import PLAN_PERIOD, SENSOR_PERIOD, ClosedLoop, Settings
from psane_sim.runs.neighbours import taken_cells
from psane_sim.runs.patience import Patience
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.scoring import Score
from psane_sim.runs.summary import Ending, Outcome


@dataclass(frozen=True, kw_only=True)
class Member:
    """One robot of a team.

    Parameters
    ----------
    assignment : Assignment
    departure : float
        Time at which it is given its goal [s].
    """

    assignment: Assignment
    departure: float


@dataclass(frozen=True, kw_only=True)
class MemberRun:
    """How the run of one robot went; its time is counted from its departure."""

    record: RunRecord
    outcome: Outcome
    score: Score


class TeamLoop:
    """Robots that share a map.

    Parameters
    ----------
    members : sequence of Member
        Those further back give way.
    settings : Settings
    """

    def __init__(self, members: Sequence[Member], settings: Settings) -> None:
        self._members = tuple(members)
        self._duration = max(member.assignment.task.duration for member in members)
        self._mapper = TerrainMapper(settings.mapping)
        self._loops = [self._loop(member, settings) for member in members]
        self._patience = [Patience() for _ in members]
        self._endings: dict[int, tuple[Ending, float]] = {}

    def _loop(self, member: Member, settings: Settings) -> ClosedLoop:
        assignment = member.assignment
        loop = ClosedLoop(assignment.task, assignment.terrain, assignment.start_pose, settings,
                          self._mapper)
        loop.is_waiting = True
        return loop

    def run(self, show: Callable[[Progress], None] | None = None) -> list[MemberRun]:
        """Run until every robot's planner ended, the time is over or the user interrupts."""
        began = time.monotonic()
        rest = Ending.TIMEOUT
        try:
            for tick in range(0, round(1000.0 * self._duration), SENSOR_PERIOD):
                self._advance(tick)
                if tick % PLAN_PERIOD == 0 and show is not None:
                    show(self._progress())
                if len(self._endings) == len(self._loops):
                    break
        except KeyboardInterrupt:
            rest = Ending.INTERRUPTED
        finally:
            for loop in self._loops:
                loop.close()
        wall = time.monotonic() - began
        return [self._result(index, rest, wall) for index in range(len(self._loops))]

    def _advance(self, tick: int) -> None:
        now = 1e-3 * tick
        for index, (member, loop) in enumerate(zip(self._members, self._loops, strict=True)):
            if index in self._endings:
                continue
            loop.is_waiting = now < member.departure
            if tick % PLAN_PERIOD == 0:
                others = [np.array(self._loops[other].position) for other in range(index)]
                loop.keep_out = taken_cells(self._mapper.grid, others) if others else None
            loop.advance(tick)
            ending = (None if loop.plan is None or loop.is_waiting
                      else self._patience[index].ending(loop.plan.state, now))
            if ending is not None:
                self._endings[index] = (ending, now - member.departure)

    def _progress(self) -> Progress:
        """Return what the line shows: the robot that is not there yet, the first of them."""
        waiting = [index for index in range(len(self._loops)) if index not in self._endings]
        index = waiting[0] if waiting else len(self._loops) - 1
        progress = self._loops[index].progress()
        return replace(progress, state=f'robot {index + 1} {progress.state}')

    def _result(self, index: int, rest: Ending, wall: float) -> MemberRun:
        loop, departure = self._loops[index], self._members[index].departure
        ending, took = self._endings.get(index, (rest, self._duration - departure))
        outcome = replace(loop.outcome(ending, wall), time=took)
        return MemberRun(record=loop.record, outcome=outcome, score=loop.score())
