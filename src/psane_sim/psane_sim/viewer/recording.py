# SPDX-License-Identifier: Apache-2.0
"""A run of the live view as one page with a timeline, which needs no server and no network."""

from pathlib import Path

import viser

LONGEST_PAUSE = 5.0
"""A gap in time that is longer is shortened to this [s]."""


class Recording:
    """Records the scene of a server from now on.

    Parameters
    ----------
    server : viser.ViserServer
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._serializer = server.get_scene_serializer()
        self._time: float | None = None
        self._length = 0.0

    @property
    def length(self) -> float:
        """Recorded so far [s]."""
        return self._length

    def advance(self, time: float) -> None:
        """Move the timeline on to a time [s]; time that goes back restarts the clock."""
        if self._time is not None and time > self._time:
            pause = min(time - self._time, LONGEST_PAUSE)
            self._serializer.insert_sleep(pause)
            self._length += pause
        self._time = time

    def write(self, path: Path) -> None:
        """Write the page, whole or not at all; the recording ends."""
        unfinished = path.with_name(path.name + '.part')
        unfinished.write_text(self._serializer.as_html(), encoding='utf-8')
        unfinished.replace(path)
