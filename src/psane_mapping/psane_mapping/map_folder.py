# SPDX-License-Identifier: Apache-2.0
"""Saved maps by name, all in one folder."""

import re
from pathlib import Path

from psane_mapping.errors import MapFileError
from psane_mapping.sample_file import SampleFile, read, write_whole

_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9._-]{0,63}')
SUFFIX = '.map'


class MapFolder:
    """A folder of saved maps.

    Parameters
    ----------
    folder : Path or None
        None when the user configured none.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder

    def save(self, name: str, content: bytes, overwrite: bool) -> Path:
        """Write a map under a name; return where it is.

        Raises
        ------
        MapFileError
            For a bad name, one that is taken, or a disk that cannot be written.
        """
        path = self._path(name)
        if path.exists() and not overwrite:
            raise MapFileError(f"there is a map '{name}' already; save it under another name, or "
                               'with overwrite')
        write_whole(path, content)
        return path

    def load(self, name: str) -> SampleFile:
        """Return the map that was saved under a name.

        Raises
        ------
        MapFileError
            For a bad name, one that is not there (with the list), or a file that is damaged.
        """
        path = self._path(name)
        if not path.is_file():
            raise MapFileError(f"there is no map '{name}'; available: {self.names()}")
        found = read(path)
        if found.lost_bytes:
            raise MapFileError(f'{path} is damaged after {len(found.samples)} samples')
        return found

    def names(self) -> list[str]:
        """Return the names of all saved maps."""
        if self._folder is None:
            return []
        return sorted(path.name.removesuffix(SUFFIX) for path in self._folder.glob(f'*{SUFFIX}')
                      if _NAME.fullmatch(path.name.removesuffix(SUFFIX)))

    def _path(self, name: str) -> Path:
        if self._folder is None:
            raise MapFileError('no folder for maps; set the parameter map_directory')
        if not _NAME.fullmatch(name):
            raise MapFileError(f"name = '{name}', expected 1 to 64 letters, digits, '-', '_' and "
                               "'.', of which the first is a letter or digit; it is not a path")
        return self._folder / f'{name}{SUFFIX}'
