# SPDX-License-Identifier: Apache-2.0
"""When each recorded message is due, and the ticks of a clock where the bag holds none."""

from collections.abc import Iterator
from typing import NamedTuple

from psane_mapping.bag_file import BagFile, BagMessage

CLOCK = '/clock'


class Due(NamedTuple):
    """A message, or a tick of the clock (None), and the time from the start at rate 1 [ns]."""

    offset: int
    message: BagMessage | None


def schedule(bag: BagFile, topics: list[str], clock_rate: float) -> Iterator[Due]:
    """Yield what is due, in order of time.

    Parameters
    ----------
    topics : list of str
        Recorded names.
    clock_rate : float
        Ticks in a second of the bag's time [Hz]; 0 for none.
    """
    start = bag.start
    messages = (Due(message.time - start, message) for message in bag.messages(topics))
    if clock_rate <= 0.0:
        return messages
    return _with_ticks(messages, round(1e9 / clock_rate))


def _with_ticks(messages: Iterator[Due], period: int) -> Iterator[Due]:
    """Put a tick before the first message at or after its time; the last message ends it."""
    tick = 0
    for due in messages:
        while tick <= due.offset:
            yield Due(tick, None)
            tick += period
        yield due
