# SPDX-License-Identifier: Apache-2.0
"""Each accepted sample on disk as it comes, so that a mapper that was killed finds them again."""

import fcntl
import os
from pathlib import Path

from psane_mapping.errors import MapFileError
from psane_mapping.sample import TerrainSample, record_of
from psane_mapping.sample_file import SampleFile, parse, write_whole

SYNC_POLICIES = ('never', 'second', 'contact')
NAME = 'journal.psane'


class Journal:
    """An append-only file of samples.

    It never raises for a disk that is full, missing or read-only: `problem` says what is wrong,
    what could not be written is kept, and `sync` tries again.

    Parameters
    ----------
    folder : Path
    header : bytes
        See `sample_file.header_of`.
    sync_policy : str
        When what was written must have reached the disk: after each contact, at each `sync`, or
        when the operating system likes. A killed process loses nothing under any of them; a power
        cut may cost what was not synchronised.
    """

    def __init__(self, folder: Path, header: bytes, sync_policy: str = 'second') -> None:
        self._folder = folder
        self.path = folder / NAME
        self._header = header
        self._sync_policy = sync_policy
        self._file = -1
        self._lock = -1
        self._backlog = bytearray()
        self._replacement: bytearray | None = None
        self._unsynchronised = False
        self.problem = ''

    def recover(self) -> SampleFile | None:
        """Open the journal, or begin one; return what was in it.

        A torn last record, which a kill may leave, is dropped in silence. A journal damaged
        before its end is set aside as it was, and its sound part is used; `problem` says so.
        """
        try:
            self._take_lock()
            content = self.path.read_bytes() if self.path.exists() else b''
        except OSError as error:
            self._fail(error)
            return None
        found = self._sound_part(content)
        self._replacement = bytearray(self._header)
        if found is not None:
            self._replacement = bytearray(content[:found.sound_bytes])
        damage = self.problem
        if found is not None and not found.lost_bytes:
            self._replacement = None
            self._open()
        else:
            self._replace()
        self.problem = self.problem or damage
        return found

    def append(self, sample: TerrainSample) -> None:
        """Write one sample."""
        record = record_of(sample)
        if self._replacement is not None:
            self._replacement += record
            return
        self._backlog += record
        if not self.problem:
            self._write()

    def replace(self, records: bytes) -> None:
        """Begin anew with other records, all at once."""
        self._backlog.clear()
        self._replacement = bytearray(self._header + records)
        self._replace()

    def set_aside(self, word: str) -> Path:
        """Keep the present journal under another name too, and return that."""
        number = 1
        while (other := self._folder / f'journal.{word}-{number}.psane').exists():
            number += 1
        os.link(self.path, other)
        return other

    def sync(self) -> None:
        """Try again what failed, and have what was written reach the disk."""
        if self._lock < 0:
            self._retry_lock()
        if self._lock < 0:
            return
        if self._replacement is not None:
            self._replace()
        elif self._backlog:
            if self._file < 0:
                self._open()
            self._write()
        if self._unsynchronised and self._sync_policy != 'never':
            self._flush()

    def close(self) -> None:
        """Let go of the file and the folder."""
        for handle in (self._file, self._lock):
            if handle >= 0:
                os.close(handle)
        self._file = self._lock = -1

    def _take_lock(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(self._folder / '.lock', os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            raise BlockingIOError(0, 'another mapper has this folder') from None
        self._lock = handle

    def _retry_lock(self) -> None:
        """Take the folder once it can be had; a journal that is in it is set aside, not lost."""
        backlog = bytes(self._backlog)
        try:
            self._take_lock()
            if self.path.exists():
                self.set_aside('before')
        except OSError as error:
            self._fail(error)
            return
        if self._replacement is None:
            self._replacement = bytearray(self._header + backlog)
        self._backlog.clear()

    def _sound_part(self, content: bytes) -> SampleFile | None:
        if not content:
            return None
        try:
            found: SampleFile | None = parse(content, str(self.path))
            damage = ('' if found is None or found.is_torn or not found.lost_bytes else
                      f'{self.path} is damaged after {len(found.samples)} samples')
        except MapFileError as error:
            found, damage = None, str(error)
            if self._header.startswith(content):
                damage = ''
        if damage:
            self.problem = f'{damage}; it was kept as {self.set_aside("damaged")}'
        return found

    def _replace(self) -> None:
        if self._replacement is None or self._lock < 0:
            return
        try:
            write_whole(self.path, bytes(self._replacement))
        except MapFileError as error:
            self.problem = str(error)
            return
        self._replacement = None
        self._open()

    def _open(self) -> None:
        if self._file >= 0:
            os.close(self._file)
            self._file = -1
        try:
            self._file = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CLOEXEC)
            self.problem = ''
        except OSError as error:
            self._fail(error)

    def _write(self) -> None:
        """Write what is waiting; a part that was written is not written again."""
        if self._file < 0:
            return
        try:
            while self._backlog:
                written = os.write(self._file, self._backlog)
                del self._backlog[:written]
                self._unsynchronised = True
            self.problem = ''
            if self._sync_policy == 'contact':
                self._flush()
        except OSError as error:
            self._fail(error)

    def _flush(self) -> None:
        try:
            os.fdatasync(self._file)
            self._unsynchronised = False
        except OSError as error:
            self._fail(error)

    def _fail(self, error: OSError) -> None:
        self.problem = f'cannot write {self.path}: {error.strerror or error}'
