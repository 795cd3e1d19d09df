# SPDX-License-Identifier: Apache-2.0
"""Writes a rosbag2 recording: an MCAP file with checksums, and metadata.yaml beside it.

The layout is that of rosbag2 in ROS 2 Jazzy (metadata version 9), so that `ros2 bag` and Foxglove
read it. Messages come as they went over the wire; nothing is decoded here.
"""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import yaml

from psane_mapping.errors import BagError

if TYPE_CHECKING:
    pass

METADATA_VERSION = 9
Quality = dict[str, object]
"""An offered profile of quality of service, with the names that rosbag2 writes."""


@dataclass(frozen=True, kw_only=True)
class TopicType:
    """The type of a topic's messages.

    Parameters
    ----------
    name : str
        Like ``nav_msgs/msg/Odometry``.
    definition : str
        The text of its .msg file, followed by those that it needs.
    digest : str
        Hash of the type as the graph shows it (REP-2016).
    """

    name: str
    definition: str
    digest: str


class BagWriter:
    """A bag that is being written; `close` makes it whole.

    Parameters
    ----------
    folder : Path
        Is made; must not exist.

    Raises
    ------
    BagError
        When mcap is not installed, or the folder exists or cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        try:
            from mcap.writer import CompressionType, Writer
        except ImportError as error:
            raise BagError('bags are written with mcap, which is not installed: '
                           'pip install mcap zstandard') from error
        self.folder = folder
        self._file = f'{folder.resolve().name}_0.mcap'
        try:
            folder.mkdir(parents=True)
            self._stream: BinaryIO = (folder / self._file).open('wb')
        except OSError as error:
            raise BagError(f'cannot write a bag to {folder}: {error.strerror}') from error
        self._writer: Writer = Writer(self._stream, compression=CompressionType.ZSTD,
                                      enable_crcs=True, enable_data_crcs=True)
        self._writer.start(profile='ros2', library='psane')
        self._schemas: dict[str, int] = {}
        self._topics: dict[int, dict[str, object]] = {}
        self._counts: Counter[int] = Counter()
        self._first, self._last = 2**63 - 1, 0

    @property
    def count(self) -> int:
        """Messages written so far."""
        return self._counts.total()

    def add_topic(self, name: str, kind: TopicType, offered: Sequence[Quality]) -> int:
        """Announce a topic; return the number by which its messages are written."""
        if kind.name not in self._schemas:
            self._schemas[kind.name] = self._writer.register_schema(
                name=kind.name, encoding='ros2msg', data=kind.definition.encode())
        number = self._writer.register_channel(
            topic=name, message_encoding='cdr', schema_id=self._schemas[kind.name],
            metadata={'offered_qos_profiles': _yaml(list(offered)),
                      'topic_type_hash': kind.digest})
        self._topics[number] = {
            'name': name, 'type': kind.name, 'serialization_format': 'cdr',
            'offered_qos_profiles': list(offered), 'type_description_hash': kind.digest}
        return number

    def write(self, topic: int, data: bytes, received: int, sent: int, sequence: int) -> None:
        """Write a message.

        Parameters
        ----------
        topic : int
            From `add_topic`.
        data : bytes
            As it came over the wire.
        received, sent : int
            When it arrived and when it was published [ns since 1970].
        sequence : int
            The publisher's count of it.
        """
        self._writer.add_message(channel_id=topic, log_time=received, data=data,
                                 publish_time=sent, sequence=sequence & 0xFFFFFFFF)
        self._counts[topic] += 1
        self._first, self._last = min(self._first, received), max(self._last, received)

    def close(self, notes: Mapping[str, str]) -> None:
        """Write what is left, and the metadata with some notes."""
        metadata = self._metadata(notes)
        self._writer.add_metadata(
            'rosbag2', {'serialized_metadata': _yaml(metadata)})
        self._writer.finish()
        self._stream.close()
        (self.folder / 'metadata.yaml').write_text(
            _yaml({'rosbag2_bagfile_information': metadata}), encoding='utf-8')

    def _metadata(self, notes: Mapping[str, str]) -> dict[str, object]:
        start = self._first if self._last else 0
        duration = {'nanoseconds': max(self._last - start, 0)}
        starting = {'nanoseconds_since_epoch': start}
        return {
            'version': METADATA_VERSION, 'storage_identifier': 'mcap', 'duration': duration,
            'starting_time': starting, 'message_count': self.count,
            'topics_with_message_count': [
                {'topic_metadata': topic, 'message_count': self._counts[number]}
                for number, topic in self._topics.items()],
            'compression_format': '', 'compression_mode': '',
            'relative_file_paths': [self._file],
            'files': [{'path': self._file, 'starting_time': starting, 'duration': duration,
                       'message_count': self.count}],
            'custom_data': dict(notes) or None,
            'ros_distro': os.environ.get('ROS_DISTRO', 'jazzy')}



class _PlainDumper(yaml.SafeDumper):  # type: ignore[misc]
    def ignore_aliases(self, data: object) -> bool:
        """Write everything out: readers in other languages choke on references."""
        return True


def _yaml(data: object) -> str:
    return yaml.dump(data, Dumper=_PlainDumper, sort_keys=False)
