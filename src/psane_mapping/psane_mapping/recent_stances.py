# SPDX-License-Identifier: Apache-2.0
"""Recognise a stance that was heard before."""

from collections import OrderedDict

from psane_mapping.contact import LegContact

KEPT = 4096
"""Stances that are remembered: a quarter of an hour of walking [count]."""

Key = tuple[int, float, float, float, float]


class RecentStances:
    """Remembers the last stances by leg, times and place; two robots do not step on one point."""

    def __init__(self) -> None:
        self._keys: OrderedDict[Key, None] = OrderedDict()

    def holds(self, contact: LegContact) -> bool:
        """Return whether this very stance is among those remembered."""
        return _key(contact) in self._keys

    def add(self, contact: LegContact) -> None:
        """Remember a stance, and forget the oldest when there are too many."""
        self._keys[_key(contact)] = None
        if len(self._keys) > KEPT:
            self._keys.popitem(last=False)

    def clear(self) -> None:
        """Forget all."""
        self._keys.clear()


def _key(contact: LegContact) -> Key:
    x, y = contact.point.tolist()
    return (contact.leg, contact.touch_down, contact.lift_off, x, y)
