# SPDX-License-Identifier: Apache-2.0
"""Turn a configuration dataclass into ROS parameters, and back."""

import math
from collections.abc import Callable
from dataclasses import Field, fields, replace
from typing import Any, Generic, TypeVar

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from psane_mapping.errors import ParameterError
from psane_mapping.parameters import (
    Configuration,
    Declaration,
    check_value,
    declaration_of,
    kind_of,
)

C = TypeVar('C', bound=Configuration)

_LOWEST_INTEGER = -(2**63)
_HIGHEST_INTEGER = 2**63 - 1


def descriptor_of(entry: 'Field[Any]') -> ParameterDescriptor:
    """Return a field as ROS describes it: meaning and unit, range, choices, read-only."""
    declared = declaration_of(entry)
    descriptor = ParameterDescriptor(
        description=f'{declared.meaning} [{declared.unit}]', read_only=declared.read_only)
    if declared.choices:
        descriptor.additional_constraints = f'one of {list(declared.choices)}'
    if declared.low is not None or declared.high is not None:
        _add_range(descriptor, kind_of(entry), declared)
    return descriptor


def _add_range(descriptor: ParameterDescriptor, kind: type, declared: Declaration) -> None:
    low, high = declared.low, declared.high
    if kind is float:
        descriptor.floating_point_range = [FloatingPointRange(
            from_value=-math.inf if low is None else float(low),
            to_value=math.inf if high is None else float(high))]
    elif kind is int:
        descriptor.integer_range = [IntegerRange(
            from_value=_LOWEST_INTEGER if low is None else math.ceil(low),
            to_value=_HIGHEST_INTEGER if high is None else math.floor(high), step=1)]


def declare(node: Node, configuration: type[C]) -> C:
    """Declare every field as a parameter of the node and return the values that are in force.

    Values from the command line or a YAML file take the place of the defaults. A whole number is
    taken for a floating-point parameter here, at the start; at run time ROS refuses it.

    Raises
    ------
    ParameterError
        For a value of the wrong type, outside its range or at odds with another one.
    """
    values = {entry.name: _value_at_start(node, entry) for entry in fields(configuration)}
    made = configuration(**values)
    for entry in fields(configuration):
        node.declare_parameter(entry.name, values[entry.name], descriptor_of(entry),
                               ignore_override=True)
    return made


def _value_at_start(node: Node, entry: 'Field[Any]') -> Any:
    """Return what the user asked for, else the default, after a check that words what is wrong."""
    untyped = ParameterDescriptor(dynamic_typing=True)
    value = node.declare_parameter(entry.name, entry.default, untyped).value
    node.undeclare_parameter(entry.name)
    kind = kind_of(entry)
    check_value(entry.name, value, kind, declaration_of(entry))
    return kind(value)


class ParameterBridge(Generic[C]):
    """Keeps a configuration equal to a node's parameters, at the start and at run time.

    Parameters
    ----------
    node : Node
        Its parameters are declared here.
    configuration : type
        The dataclass that declares them.
    on_change : callable, optional
        Called with the new configuration after a change that was accepted; it must not refuse it.

    Notes
    -----
    A change of several parameters at once is checked as a whole, so two that are related to each
    other can move together (`set_parameters_atomically`).
    """

    def __init__(self, node: Node, configuration: type[C],
                 on_change: Callable[[C], None] | None = None) -> None:
        self.configuration = declare(node, configuration)
        self._names = {entry.name for entry in fields(configuration)}
        self._on_change = on_change
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take_over)

    def _changed(self, parameters: list[Parameter]) -> C:
        values = {item.name: item.value for item in parameters if item.name in self._names}
        return replace(self.configuration, **values)

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        try:
            self._changed(parameters)
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take_over(self, parameters: list[Parameter]) -> None:
        made = self._changed(parameters)
        if made == self.configuration:
            return
        self.configuration = made
        if self._on_change is not None:
            self._on_change(made)
