# SPDX-License-Identifier: Apache-2.0
"""Looks at a run from outside, by the truth: coverage over time, moments to draw, a sunk robot."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_planner.status import Plan
from psane_sim.runs.run_record import RunRecord
from psane_sim.runs.scoring import Score
from psane_sim.runs.summary import Ending

STUCK_TIME = 60.0
"""Time on unsafe ground without getting away after which a robot is called stuck [s]."""

STUCK_RADIUS = 0.3
"""Distance that such a robot does not get beyond in that time [m]."""

COVERAGE_PERIOD = 5.0
"""Time between looks at the coverage [s]."""

FIRST_MOMENT = 10.0
"""When the first moment is kept; every later one comes after twice the time [s]."""


class WatchedLoop(Protocol):
    """What both closed loops show of a run under way."""

    plan: Plan | None
    record: RunRecord

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""

    @property
    def unsafe_time(self) -> float:
        """Time on unsafe ground so far [s]."""

    def score(self) -> Score:
        """Return the score so far."""


Watch = Callable[[WatchedLoop], Ending | None]
"""Called after each plan; an ending ends the run."""


@dataclass(frozen=True, kw_only=True)
class Moment:
    """One planning cycle with all that its picture shows.

    Parameters
    ----------
    time : float [s]
    plan : Plan
    slip_mean, slip_std : (rows, columns) float [-]
    position : (2,) float, map frame [m]
    """

    time: float
    plan: Plan
    slip_mean: FloatArray
    slip_std: FloatArray
    position: FloatArray


class RunWatch:
    """Gathers coverage and moments of one run, and ends it when the robot is stuck.

    Parameters
    ----------
    moment : float, optional
        The one time at which to keep a moment [s]; by default after 10, 20, 40, ... s.
    """

    def __init__(self, moment: float | None = None) -> None:
        self.coverage: list[tuple[float, float]] = []
        self.moments: list[Moment] = []
        self._due = FIRST_MOMENT if moment is None else moment
        self._growth = 2.0 if moment is None else np.inf
        self._look = 0.0
        self._anchor: tuple[float, FloatArray] | None = None
        self._unsafe_time = 0.0

    def __call__(self, loop: WatchedLoop) -> Ending | None:
        """Take in the present state of a run."""
        now = loop.time
        if now >= self._look:
            self.coverage.append((now, loop.score().coverage))
            self._look += COVERAGE_PERIOD
        if now >= self._due and loop.plan is not None and loop.plan.frontier is not None:
            self._keep(loop, loop.plan)
        return Ending.STUCK if self._is_stuck(loop) else None

    def finish(self, loop: WatchedLoop) -> None:
        """Take in the end of a run."""
        self.coverage.append((loop.time, loop.score().coverage))

    def _keep(self, loop: WatchedLoop, plan: Plan) -> None:
        record = loop.record
        if record.slip_mean is None or record.slip_std is None or not record.path:
            return
        self.moments.append(Moment(
            time=loop.time, plan=plan, slip_mean=np.array(record.slip_mean),
            slip_std=np.array(record.slip_std), position=np.array(record.path[-1][1:])))
        while self._due <= loop.time:
            self._due *= self._growth

    def _is_stuck(self, loop: WatchedLoop) -> bool:
        """Tell whether the robot has been on unsafe ground, near one point, for long."""
        if not loop.record.path:
            return False
        place = np.array(loop.record.path[-1][1:])
        unsafe_time = loop.unsafe_time
        stayed_unsafe = unsafe_time > self._unsafe_time
        self._unsafe_time = unsafe_time
        if not stayed_unsafe or self._anchor is None or float(
                np.hypot(*(place - self._anchor[1]))) > STUCK_RADIUS:
            self._anchor = (loop.time, place)
        return loop.time - self._anchor[0] >= STUCK_TIME


def packed(mask: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return a mask as bits."""
    return np.packbits(np.asarray(mask, dtype=bool))


def unpacked(bits: NDArray[np.uint8], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Return the mask (rows, columns) of such bits."""
    return np.unpackbits(bits, count=shape[0] * shape[1]).astype(bool).reshape(shape)
