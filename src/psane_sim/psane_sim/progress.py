# SPDX-License-Identifier: Apache-2.0
"""One line that says how a run is going."""

import sys
import time
from dataclasses import dataclass
from typing import TextIO


@dataclass(frozen=True, kw_only=True)
class Progress:
    """What the line shows: simulated time [s], distance to the goal [m], certified area [m^2]."""

    time: float
    distance: float | None
    area: float
    contacts: int
    state: str
    cause: str = ''


class ProgressLine:
    """Rewrites one line on a terminal; elsewhere prints a line every few simulated seconds.

    Parameters
    ----------
    stream : TextIO
    every : float
        Simulated time between lines where the stream is not a terminal [s].
    """

    def __init__(self, stream: TextIO = sys.stderr, every: float = 5.0) -> None:
        self._stream = stream
        self._every = every
        self._is_terminal = stream.isatty()
        self._began = time.monotonic()
        self._last = -every
        self._state = ''
        self._width = 0

    def show(self, progress: Progress) -> None:
        """Show the state of the run."""
        is_news = progress.state != self._state
        if not (self._is_terminal or is_news) and progress.time - self._last < self._every:
            return
        self._last, self._state = progress.time, progress.state
        line = self._text(progress)
        if self._is_terminal:
            self._stream.write('\r' + line.ljust(self._width))
            self._width = len(line)
        else:
            self._stream.write(line + '\n')
        self._stream.flush()

    def close(self) -> None:
        """End the line, so that what follows starts on its own."""
        if self._is_terminal and self._width:
            self._stream.write('\n')
            self._stream.flush()

    def _text(self, progress: Progress) -> str:
        factor = progress.time / max(time.monotonic() - self._began, 1e-6)
        goal = 'exploring' if progress.distance is None else f'to goal {progress.distance:5.2f} m'
        cause = f': {progress.cause}' if progress.cause else ''
        return (f't {progress.time:6.1f} s  x{factor:4.1f}  {goal}  '
                f'certified {progress.area:6.2f} m2  contacts {progress.contacts:4d}  '
                f'{progress.state}{cause}')[:160]
