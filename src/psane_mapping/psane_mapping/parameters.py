# SPDX-License-Identifier: Apache-2.0
"""Declare a parameter once: default, meaning, unit and closed range in one dataclass field.

ROS parameters (`ros_parameters`), the README's table and the checks of the in-process loop are all
made from these declarations, so that a default or a range is never written twice.
"""

import math
from collections.abc import Mapping
from dataclasses import Field, dataclass, field, fields
from typing import Any

from psane_mapping.errors import ParameterError

_KEY = 'psane'


@dataclass(frozen=True, kw_only=True)
class Declaration:
    """What is known of a parameter besides its default.

    Parameters
    ----------
    meaning : str
        One sentence fragment, shown by ``ros2 param describe`` and in the README.
    unit : str
        Unit of the value, ``-`` when dimensionless.
    low, high : float, optional
        Closed range; `None` where there is no limit.
    choices : tuple of str
        The permitted words of a text parameter; empty where any text will do.
    read_only : bool
        True when the parameter builds a structure and cannot change at run time.
    """

    meaning: str
    unit: str = '-'
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = False


def parameter(default: Any, meaning: str, **details: Any) -> Any:
    """Make a dataclass field that carries its declaration (see `Declaration` for `details`)."""
    metadata = {_KEY: Declaration(meaning=meaning, **details)}
    return field(default=default, metadata=metadata)


def declaration_of(entry: 'Field[Any]') -> Declaration:
    """Return the declaration that `parameter` stored in a dataclass field."""
    declared: Declaration = entry.metadata[_KEY]
    return declared


def check_value(name: str, value: Any, kind: type, declared: Declaration) -> None:
    """Refuse a value of the wrong type, outside its range or not among its choices.

    Raises
    ------
    ParameterError
        Naming the value, what was expected and the unit.
    """
    if kind in (int, float):
        _check_number(name, value, kind, declared)
    elif kind is bool and not isinstance(value, bool):
        raise ParameterError(name, value, 'true or false')
    elif kind is str and not isinstance(value, str):
        raise ParameterError(name, value, 'text')
    if declared.choices and value not in declared.choices:
        raise ParameterError(name, value, f'one of {list(declared.choices)}')


def _check_number(name: str, value: Any, kind: type, declared: Declaration) -> None:
    low = -math.inf if declared.low is None else declared.low
    high = math.inf if declared.high is None else declared.high
    expected = f'a finite value in [{low:g}, {high:g}]'
    try:
        is_number = not isinstance(value, (bool, str)) and math.isfinite(value)
    except TypeError:
        is_number = False
    if not is_number or (kind is int and int(value) != value) or not low <= value <= high:
        whole = ' whole number' if kind is int else ''
        raise ParameterError(name, value, expected.replace(' value', whole or ' value'),
                             declared.unit)


@dataclass(frozen=True, kw_only=True)
class Configuration:
    """Base of every package's configuration: all fields are checked at construction.

    A subclass that relates parameters to each other extends `__post_init__`, this one first.
    """

    def __post_init__(self) -> None:
        """Check each field against its declaration."""
        for entry in fields(self):
            check_value(entry.name, getattr(self, entry.name), kind_of(entry),
                        declaration_of(entry))


def kind_of(entry: 'Field[Any]') -> type:
    """Return the parameter's type: bool, int, float or str (taken from its default)."""
    return type(entry.default)


def from_mapping(configuration: type[Configuration], values: Mapping[str, Any]) -> Any:
    """Build a configuration from names and values, as read from a YAML file.

    Raises
    ------
    ParameterError
        For an unknown name or a bad value.
    """
    known = {entry.name for entry in fields(configuration)}
    for name in values:
        if name not in known:
            raise ParameterError(name, values[name], f'a parameter among {sorted(known)}')
    return configuration(**values)
