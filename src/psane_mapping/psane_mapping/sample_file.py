# SPDX-License-Identifier: Apache-2.0
"""Files of samples: a header that says how they were made, then one record after the other.

A map is a function of its samples, so that saved maps and the journal are such files, and a map
that is read back equals the one that was saved to the last bit.
"""

import contextlib
import json
import os
import struct
import tempfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from psane_mapping.errors import MapFileError
from psane_mapping.sample import RECORD_BYTES, TerrainSample, sample_of

_MAGIC = b'PSANEMAP'
_HEAD = struct.Struct('<8sIII')
_VERSION = 1
_LARGEST_HEADER = 1 << 20


@dataclass(frozen=True, kw_only=True)
class SampleFile:
    """What a file of samples holds.

    Parameters
    ----------
    parameters : mapping of str
        Those that the samples were made with.
    samples : tuple of TerrainSample
        All up to the first record that is not whole.
    sound_bytes : int
        Length of the file up to there [count].
    lost_bytes : int
        What follows [count].
    """

    parameters: Mapping[str, object]
    samples: tuple[TerrainSample, ...]
    sound_bytes: int
    lost_bytes: int

    @property
    def is_torn(self) -> bool:
        """True when no more than the last record is missing a part, as a kill may leave it."""
        return 0 < self.lost_bytes <= RECORD_BYTES


def header_of(parameters: Mapping[str, object]) -> bytes:
    """Return the header of a file whose samples were made with some parameters."""
    text = json.dumps({'parameters': dict(parameters)}, sort_keys=True).encode()
    return _HEAD.pack(_MAGIC, _VERSION, len(text), zlib.crc32(text)) + text


def parse(content: bytes, name: str) -> SampleFile:
    """Return what the bytes of a file hold; `name` is for the words of an error.

    Raises
    ------
    MapFileError
        For a header that is damaged, or not ours.
    """
    if len(content) < _HEAD.size or not content.startswith(_MAGIC):
        raise MapFileError(f'{name} is not a map of PSANE')
    _, version, length, check = _HEAD.unpack_from(content)
    if version != _VERSION:
        raise MapFileError(f'{name} has format {version}, expected {_VERSION}')
    text = content[_HEAD.size:_HEAD.size + min(length, _LARGEST_HEADER)]
    if len(text) != length or zlib.crc32(text) != check:
        raise MapFileError(f'the header of {name} is damaged')
    parameters = json.loads(text)['parameters']
    position = _HEAD.size + length
    samples: list[TerrainSample] = []
    while (sample := sample_of(content[position:position + RECORD_BYTES])) is not None:
        samples.append(sample)
        position += RECORD_BYTES
    return SampleFile(parameters=parameters, samples=tuple(samples), sound_bytes=position,
                      lost_bytes=len(content) - position)


def read(path: Path) -> SampleFile:
    """Return what a file holds.

    Raises
    ------
    MapFileError
        When it cannot be read or is not ours.
    """
    try:
        return parse(path.read_bytes(), str(path))
    except OSError as error:
        raise MapFileError(f'cannot read {path}: {error.strerror}') from error


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that either all of it is there, or what was there before.

    Raises
    ------
    MapFileError
        When that fails: full disk, folder that cannot be written.
    """
    temporary = ''
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f'.{path.name}.')
        with os.fdopen(handle, 'wb') as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        if temporary:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
        raise MapFileError(f'cannot write {path}: {error.strerror}') from error
