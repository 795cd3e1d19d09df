# SPDX-License-Identifier: Apache-2.0
"""Read a rosbag2 recording without ROS: topics, raw messages, decoded messages."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple

from psane_mapping.errors import BagError

if TYPE_CHECKING:
    pass


@dataclass(frozen=True, kw_only=True)
class BagTopic:
    """What a bag says of a topic.

    Parameters
    ----------
    name, kind : str
        Topic, and the type of its messages, like ``nav_msgs/msg/Odometry``.
    count : int
        Messages in the bag.
    digest : str
        Hash of the type (REP-2016), empty when the bag does not say.
    is_reliable, is_latched : bool
        Whether all its publishers offered that; None when the bag does not say.
    """

    name: str
    kind: str
    count: int
    digest: str
    is_reliable: bool | None
    is_latched: bool | None


class BagMessage(NamedTuple):
    """A message as it came over the wire, and when it was received [ns]."""

    topic: str
    kind: str
    time: int
    data: bytes


class BagFile:
    """A bag that is open for reading, for a ``with`` statement.

    Parameters
    ----------
    path : Path
        Folder of a bag (MCAP or SQLite, by this project or by ``ros2 bag record``), or an .mcap
        file of one.

    Raises
    ------
    BagError
        When rosbags is not installed, or the bag cannot be read.

    Notes
    -----
    Each compressed chunk is compared with its checksum, and each type with its hash, by rosbags.
    """

    def __init__(self, path: Path) -> None:
        try:
            from rosbags.highlevel import AnyReader, AnyReaderError
        except ImportError as error:
            raise BagError('bags are read with rosbags, which is not installed: '
                           'pip install rosbags') from error
        self.path = path
        self._problems = (AnyReaderError, OSError, AssertionError)
        try:
            self._reader: AnyReader = AnyReader([path])
            self._reader.open()
        except self._problems as error:
            raise BagError(f'cannot read the bag {path}: {error}') from error

    def __enter__(self) -> 'BagFile':
        """Return the bag itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        """Close the bag."""
        self._reader.close()

    @property
    def topics(self) -> tuple[BagTopic, ...]:
        """All topics, by name; one that was published with two types is there twice."""
        found = []
        for entry in sorted(self._reader.connections, key=lambda entry: entry.topic):
            offers = getattr(entry.ext, 'offered_qos_profiles', [])
            found.append(BagTopic(
                name=entry.topic, kind=entry.msgtype, count=entry.msgcount,
                digest=entry.digest,
                is_reliable=all(offer.reliability.name == 'RELIABLE' for offer in offers)
                if offers else None,
                is_latched=all(offer.durability.name == 'TRANSIENT_LOCAL' for offer in offers)
                if offers else None))
        return tuple(found)

    @property
    def start(self) -> int:
        """When the first message was received [ns]."""
        return int(self._reader.start_time)

    def names_of(self, kind: str) -> list[str]:
        """Return the topics that carry a type of message."""
        return [topic.name for topic in self.topics if topic.kind == kind]

    def messages(self, topics: Collection[str] | None = None) -> Iterator[BagMessage]:
        """Yield the messages in the order in which they were received, of some topics or all.

        Raises
        ------
        BagError
            When a chunk is damaged.
        """
        chosen = [entry for entry in self._reader.connections
                  if topics is None or entry.topic in topics]
        if not chosen:
            return
        try:
            for entry, time, data in self._reader.messages(chosen):
                yield BagMessage(entry.topic, entry.msgtype, time, bytes(data))
        except Exception as error:  # each kind of damage has an error of its own
            raise BagError(f'the bag {self.path} is damaged: {error}') from error

    def decoded(self, message: BagMessage) -> Any:
        """Return a message with the fields of its ROS definition; arrays are numpy arrays."""
        return self._reader.deserialize(message.data, message.kind)
