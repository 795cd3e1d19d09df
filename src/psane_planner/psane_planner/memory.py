# SPDX-License-Identifier: Apache-2.0
"""Frontiers that were visited in vain are set aside for a while."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_planner.configuration import PlannerConfiguration


@dataclass
class _Visit:
    point: FloatArray
    since: float
    record: int
    arrivals: int = 0
    resting_until: float = float('-inf')
    in_vain_at: float = float('-inf')
    given_up_at: float = float('-inf')


class FrontierMemory:
    """Counts arrivals at a frontier that brought nothing.

    One arrival is a stay of `dwell_time` during which the certified cells around the frontier did
    not exceed their record. After `arrivals_before_rest` of them all frontier cells in the
    neighbourhood rest for `rest_time`. A record can only grow, so a cell that is certified and
    revoked in turn does not pass for progress.
    """

    def __init__(self, configuration: PlannerConfiguration) -> None:
        """Remember nothing."""
        self._configuration = configuration
        self._visits: list[_Visit] = []

    def note_stay(self, point: FloatArray, certified_nearby: int, now: float) -> None:
        """Take note that the robot stands at the frontier `point` (2,) [m].

        Parameters
        ----------
        certified_nearby : int
            Certified cells around the frontier.
        """
        visit = self._visit_at(point, certified_nearby, now)
        if certified_nearby > visit.record:
            visit.record, visit.arrivals, visit.since = certified_nearby, 0, now
            return
        if now - visit.since > 2.0 * self._configuration.dwell_time:
            # The robot has been elsewhere: this stay begins now.
            visit.since = now
        if now - visit.since >= self._configuration.dwell_time:
            visit.arrivals += 1
            visit.since = now
        if visit.arrivals >= self._configuration.arrivals_before_rest:
            visit.in_vain_at = now
            self._rest(visit, now)

    def set_aside(self, point: FloatArray, now: float) -> None:
        """Let the frontier around `point` (2,) [m] rest, since the robot cannot get there."""
        visit = self._visit_at(point, 0, now)
        visit.given_up_at = now
        self._rest(visit, now)

    def only_in_vain_since(self, since: float) -> bool:
        """Tell whether the robot got to every frontier that it left since then, one at least."""
        return (any(visit.in_vain_at >= since for visit in self._visits)
                and not any(visit.given_up_at >= since for visit in self._visits))

    def _rest(self, visit: _Visit, now: float) -> None:
        visit.arrivals = 0
        visit.resting_until = now + self._configuration.rest_time

    def is_resting(self, points: FloatArray, now: float) -> NDArray[np.bool_]:
        """Tell which of `points` (n, 2) [m] belong to a frontier that rests."""
        resting = np.zeros(points.shape[0], dtype=np.bool_)
        for visit in self._visits:
            if visit.resting_until > now:
                aside = points - visit.point
                resting |= (aside**2).sum(axis=1) <= self._configuration.neighbourhood**2
        return resting

    def wake(self) -> None:
        """Let all frontiers be tried again."""
        for visit in self._visits:
            visit.resting_until = float('-inf')

    def _visit_at(self, point: FloatArray, record: int, now: float) -> _Visit:
        limit = self._configuration.neighbourhood
        near = [(float(np.hypot(*(visit.point - point))), index)
                for index, visit in enumerate(self._visits)]
        if near and min(near)[0] <= limit:
            return self._visits[min(near)[1]]
        visit = _Visit(np.array(point, dtype=np.float64), now, record)
        self._visits.append(visit)
        return visit
