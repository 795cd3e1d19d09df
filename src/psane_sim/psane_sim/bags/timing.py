# SPDX-License-Identifier: Apache-2.0
"""Compares a bag with a recording of its replay: whether all came, and whether on time."""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from psane_mapping.bag_file import BagFile
from psane_mapping.grid import FloatArray

_ALIGNMENT = 4


@dataclass(frozen=True, kw_only=True)
class ReplayTiming:
    """How a replay was heard.

    Parameters
    ----------
    expected, heard, different : int
        Messages in the bag, heard again, and heard with other content [count].
    lateness : (n,) float
        Of each that was heard, against its time in the bag [s].
    """

    expected: int
    heard: int
    different: int
    lateness: FloatArray

    @property
    def median_error(self) -> float:
        """Median of the absolute lateness [s]."""
        return float(np.median(np.abs(self.lateness))) if self.lateness.size else float('nan')

    def figures(self) -> dict[str, float]:
        """Return what is published of it [count, ms]."""
        error = 1e3 * np.abs(self.lateness)
        return {'replay_messages': self.expected, 'replay_missing': self.expected - self.heard,
                'replay_different': self.different,
                'replay_error_ms_p50': float(np.median(error)),
                'replay_error_ms_p99': float(np.percentile(error, 99)),
                'replay_error_ms_longest': float(error.max())}


def is_same(one: bytes, other: bytes) -> bool:
    """Tell whether two serialized messages are the same but for the padding at their end.

    On the wire a message is filled up with zeros to a multiple of four bytes; in a bag it may end
    where its content ends.
    """
    short, long = sorted((one, other), key=len)
    rest = long[len(short):]
    return len(rest) < _ALIGNMENT and long.startswith(short) and not any(rest)


def compare(original: BagFile, heard: BagFile, epoch: int, rate: float) -> ReplayTiming:
    """Compare a bag with what was recorded of its replay, topic by topic, in order.

    Parameters
    ----------
    epoch : int
        When the replay began [ns since 1970].
    rate : float
        Seconds of the bag for each second on the wall.
    """
    again: dict[str, list[tuple[int, bytes]]] = defaultdict(list)
    for message in heard.messages():
        again[message.topic].append((message.time, message.data))
    expected, different, lateness = 0, 0, []
    position: dict[str, int] = defaultdict(int)
    for message in original.messages():
        expected += 1
        index = position[message.topic]
        if index >= len(again[message.topic]):
            continue
        position[message.topic] += 1
        time, data = again[message.topic][index]
        different += not is_same(data, message.data)
        lateness.append(1e-9 * (time - epoch - (message.time - original.start) / rate))
    return ReplayTiming(expected=expected, heard=len(lateness), different=different,
                        lateness=np.array(lateness))
