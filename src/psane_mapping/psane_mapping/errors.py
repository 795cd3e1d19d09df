# SPDX-License-Identifier: Apache-2.0
"""What can go wrong in the mapping package; every error names the value and what was expected."""

from typing import Any


class MappingError(Exception):
    """Root of the mapping package's errors."""


class ParameterError(MappingError, ValueError):
    """A parameter has the wrong type, lies outside its range or is not known."""

    def __init__(self, name: str, value: Any, expected: str, unit: str = '-') -> None:
        shown = f'{value!r}' + ('' if unit == '-' else f' {unit}')
        super().__init__(f'{name} = {shown}, expected {expected}')
        self.name = name
        self.value = value
        self.expected = expected


class ShapeError(MappingError, ValueError):
    """An array does not have the shape, size or finiteness that was asked for."""


class MessageError(MappingError, ValueError):
    """A message cannot be used: wrong frame, non-finite number or wrong size."""


class MapFileError(MappingError):
    """A file of samples cannot be read or written, or its name is not one."""


class BagError(MappingError):
    """A bag cannot be read or written, or what it takes is not installed."""
