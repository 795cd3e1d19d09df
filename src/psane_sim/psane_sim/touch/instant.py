# SPDX-License-Identifier: Apache-2.0
"""Puts the measurements of one instant together, which arrive on three topics."""

from collections.abc import Iterator
from dataclasses import dataclass

from psane_sim.touch.sensing import ImuSample, JointSample, WrenchSample

LONGEST_WAIT = 20
"""Instants that may wait for a part; the oldest one beyond that is given up."""


@dataclass
class _Instant:
    joints: JointSample | None = None
    wrenches: WrenchSample | None = None
    imu: ImuSample | None = None


class InstantCollector:
    """Waits for joints, wrenches and inertial sample of the same stamp."""

    def __init__(self) -> None:
        self._instants: dict[int, _Instant] = {}
        self._newest = -1
        self.incomplete = 0

    def joints(self, sample: JointSample) -> None:
        """Take in the joints."""
        self._at(sample.time).joints = sample

    def wrenches(self, sample: WrenchSample) -> None:
        """Take in the hip wrenches."""
        self._at(sample.time).wrenches = sample

    def imu(self, sample: ImuSample) -> None:
        """Take in the inertial sample."""
        self._at(sample.time).imu = sample

    def _at(self, time: float) -> _Instant:
        return self._instants.setdefault(round(time * 1e6), _Instant())

    def whole(self) -> Iterator[tuple[JointSample, WrenchSample, ImuSample]]:
        """Yield the instants that are whole, in the order of time, and forget older ones."""
        for key in sorted(self._instants):
            instant = self._instants[key]
            if instant.joints is None or instant.wrenches is None or instant.imu is None:
                continue
            self._drop_before(key)
            del self._instants[key]
            yield instant.joints, instant.wrenches, instant.imu
        while len(self._instants) > LONGEST_WAIT:
            del self._instants[min(self._instants)]
            self.incomplete += 1

    def _drop_before(self, key: int) -> None:
        for older in [other for other in self._instants if other < key]:
            del self._instants[older]
            self.incomplete += 1
