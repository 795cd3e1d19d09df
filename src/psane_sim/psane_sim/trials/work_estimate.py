# SPDX-License-Identifier: Apache-2.0
"""How much work is left: each kind of trial is weighed by what its like has taken so far."""

import sys
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import TextIO

Kind = tuple[str, ...]
"""What trials that take about as long have in common."""


class WorkEstimate:
    """Expected work of the trials that are left.

    Parameters
    ----------
    guesses : mapping of kind to float
        Work expected of one trial of each kind before any was run [s].
    kinds : sequence
        Kind of each trial to be run.
    """

    def __init__(self, guesses: Mapping[Kind, float], kinds: Sequence[Kind]) -> None:
        self._guesses = dict(guesses)
        self._left: dict[Kind, int] = defaultdict(int)
        self._taken: dict[Kind, list[float]] = defaultdict(list)
        for kind in kinds:
            self._left[kind] += 1
        self.total = len(kinds)
        self.done = 0

    def note(self, kind: Kind, work: float) -> None:
        """Take in a finished trial and the work that it was [s]."""
        self._left[kind] -= 1
        self._taken[kind].append(work)
        self.done += 1

    @property
    def left(self) -> float:
        """Work left [s].

        A kind that was run counts with its mean; one that was not, with its guess times the
        factor by which the guesses of the others were wrong.
        """
        expected = sum(self._guesses[kind] * len(works) for kind, works in self._taken.items())
        spent = sum(sum(works) for works in self._taken.values())
        factor = spent / expected if expected > 0.0 else 1.0
        return sum(count * self._mean(kind, factor) for kind, count in self._left.items())

    @property
    def spent(self) -> float:
        """Work done [s]."""
        return sum(sum(works) for works in self._taken.values())

    def _mean(self, kind: Kind, factor: float) -> float:
        works = self._taken.get(kind)
        return sum(works) / len(works) if works else self._guesses[kind] * factor


class WorkBar:
    """A bar on a terminal; elsewhere a line for every twentieth of the trials.

    Parameters
    ----------
    estimate : WorkEstimate
    workers : int
        Trials that run at the same time.
    stream : TextIO
    """

    def __init__(self, estimate: WorkEstimate, workers: int, stream: TextIO | None = None
                 ) -> None:
        self._estimate = estimate
        self._workers = workers
        self._stream = stream or sys.stderr
        self._began = time.monotonic()
        self._width = 0

    def advance(self, kind: Kind, work: float, what: str) -> None:
        """Take in a finished trial, and say how far it all is."""
        estimate = self._estimate
        estimate.note(kind, work)
        line = self.line(time.monotonic() - self._began, what)
        step = max(1, estimate.total // 20)
        if self._stream.isatty():
            self._stream.write('\r' + line.ljust(self._width))
            self._width = len(line)
        elif estimate.done % step == 0 or estimate.done == estimate.total:
            self._stream.write(line + '\n')
        self._stream.flush()

    def line(self, passed: float, what: str) -> str:
        """Return the line that is shown after some time [s]."""
        estimate = self._estimate
        share = estimate.spent / max(estimate.spent + estimate.left, 1e-9)
        filled = round(30 * share)
        left = estimate.left / min(self._workers, max(estimate.total - estimate.done, 1))
        return (f'[{"#" * filled}{"." * (30 - filled)}] {estimate.done}/{estimate.total}  '
                f'{_minutes(passed)} gone, about {_minutes(left)} left  {what}')

    def close(self) -> None:
        """End the line."""
        if self._stream.isatty() and self._width:
            self._stream.write('\n')


def _minutes(seconds: float) -> str:
    return f'{seconds:.0f} s' if seconds < 100.0 else f'{seconds / 60.0:.0f} min'
