# SPDX-License-Identifier: Apache-2.0
"""Counts lost messages from the numbers that their publishers gave them."""


class SequenceWatch:
    """Follows the counters of all publishers of one topic.

    Notes
    -----
    Each publisher counts its messages from 1, and they arrive in order. Which publisher sent a
    message is not known, so that a number continues the run that ends just before it, if there is
    one. With one publisher the count is exact; with several, it is the smallest that explains
    what was heard.
    """

    def __init__(self) -> None:
        self._runs: list[int] = []
        self.heard = 0
        self.lost = 0
        self.before = 0

    def take(self, sequence: int, publishers: int) -> None:
        """Take in the number of a message.

        Parameters
        ----------
        sequence : int
            The publisher's count, from 1; 0 when it does not count.
        publishers : int
            How many publishers the topic has had so far.
        """
        self.heard += 1
        if sequence <= 0:
            return
        if sequence - 1 in self._runs:
            self._runs[self._runs.index(sequence - 1)] = sequence
            return
        earlier = [last for last in self._runs if last < sequence]
        if not earlier or len(self._runs) < publishers:
            # What a publisher sent before this could hear it.
            self.before += sequence - 1
            self._runs.append(sequence)
            return
        nearest = max(earlier)
        self.lost += sequence - 1 - nearest
        self._runs[self._runs.index(nearest)] = sequence
