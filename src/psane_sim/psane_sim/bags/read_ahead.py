# SPDX-License-Identifier: Apache-2.0
"""Takes items from an iterator ahead of time, so that who needs them next does not wait."""

import queue
import threading
from collections.abc import Iterable, Iterator
from typing import Generic, TypeVar

_Item = TypeVar('_Item')
_PATIENCE = 0.2


class ReadAhead(Generic[_Item]):
    """Iterates over items that a thread of its own takes from a source.

    Parameters
    ----------
    source : iterable
    most : int
        Items that are held at once.

    Notes
    -----
    An exception of the source is raised where its next item would have been.
    """

    def __init__(self, source: Iterable[_Item], most: int = 20_000) -> None:
        self._source = source
        self._queue: queue.Queue[tuple[_Item] | None] = queue.Queue(most)
        self._error: BaseException | None = None
        self._is_closed = threading.Event()
        self._thread = threading.Thread(target=self._fill, daemon=True)
        self._thread.start()

    def _fill(self) -> None:
        try:
            for item in self._source:
                self._put((item,))
                if self._is_closed.is_set():
                    return
        except BaseException as error:  # noqa: B902 - raised again by the one who iterates
            self._error = error
        self._put(None)

    def _put(self, item: tuple[_Item] | None) -> None:
        while not self._is_closed.is_set():
            try:
                self._queue.put(item, timeout=_PATIENCE)
                return
            except queue.Full:
                continue

    def __iter__(self) -> Iterator[_Item]:
        """Yield the items in order."""
        while (item := self._queue.get()) is not None:
            yield item[0]
        if self._error is not None:
            raise self._error

    def close(self) -> None:
        """End the thread, whether or not all items were taken."""
        self._is_closed.set()
        self._thread.join()
