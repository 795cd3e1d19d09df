# SPDX-License-Identifier: Apache-2.0
"""How long the latest contacts took to get into the map."""

from collections import deque

import numpy as np

_KEPT = 1000


class UpdateTimes:
    """The latest thousand durations [s]."""

    def __init__(self) -> None:
        self._durations: deque[float] = deque(maxlen=_KEPT)

    def add(self, duration: float) -> None:
        """Take in one duration [s]."""
        self._durations.append(duration)

    def milliseconds(self) -> dict[str, float]:
        """Return the median, the 99th percentile and the longest [ms]; empty without any."""
        if not self._durations:
            return {}
        times = 1e3 * np.array(self._durations)
        return {'median': float(np.median(times)), 'p99': float(np.percentile(times, 99)),
                'longest': float(times.max())}
