# SPDX-License-Identifier: Apache-2.0
"""Dataclasses as parameters of a real node."""

import math
from dataclasses import dataclass, fields

import pytest
import rclpy
from rclpy.parameter import Parameter

from psane_mapping.errors import ParameterError
from psane_mapping.parameters import Configuration, parameter
from psane_mapping.ros_parameters import ParameterBridge, declare, descriptor_of


@dataclass(frozen=True, kw_only=True)
class Sample(Configuration):
    """One field of each kind."""

    low: float = parameter(0.25, 'lower end', unit='m', low=0.0, high=1.0)
    high: float = parameter(0.75, 'upper end', unit='m', low=0.0, high=1.0)
    above: float = parameter(2.0, 'no upper limit', unit='s', low=0.0)
    free: float = parameter(-3.5, 'no limit', unit='N')
    count: int = parameter(5, 'legs', unit='count', low=1, high=8)
    seed: int = parameter(0, 'seed of the noise', low=0)
    active: bool = parameter(True, 'whether it runs')
    rule: str = parameter('plain', 'how it works', choices=('plain', 'fancy'))
    frame: str = parameter('map', 'name of the frame', read_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.low > self.high:
            raise ParameterError('low', self.low, f'at most high = {self.high}', 'm')


@pytest.fixture(scope='module', autouse=True)
def context():
    rclpy.init()
    yield
    rclpy.try_shutdown()


@pytest.fixture
def make_node():
    nodes = []

    def make(**overrides):
        nodes.append(rclpy.create_node('sample', parameter_overrides=[
            Parameter(name, value=value) for name, value in overrides.items()]))
        return nodes[-1]

    yield make
    for node in nodes:
        node.destroy_node()


def attempt(node, **values):
    return node.set_parameters_atomically(
        [Parameter(name, value=value) for name, value in values.items()])


def test_without_overrides_the_defaults_are_in_force(make_node):
    node = make_node()
    assert declare(node, Sample) == Sample()
    for entry in fields(Sample):
        assert node.get_parameter(entry.name).value == entry.default


def test_overrides_are_read_back_into_the_dataclass_and_into_the_node(make_node):
    node = make_node(low=0.5, count=8, active=False, rule='fancy', frame='odom')
    made = declare(node, Sample)
    assert made == Sample(low=0.5, count=8, active=False, rule='fancy', frame='odom')
    assert node.get_parameter('count').value == 8
    assert node.get_parameter('frame').value == 'odom'


def test_a_whole_number_is_taken_for_a_double_at_the_start(make_node):
    node = make_node(above=3)
    made = declare(node, Sample)
    assert made.above == 3.0 and isinstance(made.above, float)
    assert node.get_parameter('above').type_ == Parameter.Type.DOUBLE


@pytest.mark.parametrize(('name', 'value'), [
    ('low', -0.001), ('high', 1.001), ('low', math.nan), ('above', -1.0), ('free', math.inf),
    ('low', 'much'), ('low', True), ('count', 0), ('count', 9), ('count', 2.5), ('active', 1),
    ('rule', 'other'), ('frame', 7), ('low', 0.9)])
def test_a_bad_value_at_the_start_is_refused_with_a_sentence(make_node, name, value):
    with pytest.raises(ParameterError, match=rf'{name} = .*, expected '):
        declare(make_node(**{name: value}), Sample)


@pytest.mark.parametrize(('name', 'value'), [
    ('low', 0.0), ('high', 1.0), ('count', 1), ('count', 8), ('seed', 2**40)])
def test_the_ends_of_a_range_belong_to_it(make_node, name, value):
    made = declare(make_node(**{name: value}), Sample)
    assert getattr(made, name) == value


def test_descriptors_carry_meaning_unit_range_and_choices(make_node):
    node = make_node()
    declare(node, Sample)
    low = node.describe_parameter('low')
    assert low.description == 'lower end [m]'
    assert (low.floating_point_range[0].from_value, low.floating_point_range[0].to_value) == (0, 1)
    count = node.describe_parameter('count').integer_range[0]
    assert (count.from_value, count.to_value) == (1, 8)
    assert node.describe_parameter('above').floating_point_range[0].to_value == math.inf
    assert not node.describe_parameter('free').floating_point_range
    assert 'fancy' in node.describe_parameter('rule').additional_constraints
    assert node.describe_parameter('frame').read_only
    assert not low.read_only and not low.dynamic_typing


def test_a_descriptor_is_made_for_every_kind_of_field():
    assert [descriptor_of(entry).description for entry in fields(Sample)] == [
        f'{meaning} [{unit}]' for meaning, unit in (
            ('lower end', 'm'), ('upper end', 'm'), ('no upper limit', 's'), ('no limit', 'N'),
            ('legs', 'count'), ('seed of the noise', '-'), ('whether it runs', '-'),
            ('how it works', '-'), ('name of the frame', '-'))]


def test_a_change_at_run_time_is_handed_over_as_a_new_configuration(make_node):
    node, handed = make_node(), []
    bridge = ParameterBridge(node, Sample, handed.append)
    before = bridge.configuration
    assert attempt(node, high=0.5).successful
    assert handed == [Sample(high=0.5)] and bridge.configuration == handed[0]
    assert before == Sample()


@pytest.mark.parametrize(('name', 'value'), [
    ('low', 2.0), ('low', 1), ('low', math.nan), ('free', math.inf), ('count', 99),
    ('rule', 'other'), ('active', 'yes'), ('frame', 'odom'), ('low', 0.8)])
def test_a_bad_value_at_run_time_changes_nothing(make_node, name, value):
    node, handed = make_node(), []
    bridge = ParameterBridge(node, Sample, handed.append)
    result = attempt(node, **{name: value})
    assert not result.successful
    assert name in result.reason or 'Wrong parameter type, expected' in result.reason
    assert not handed and bridge.configuration == Sample()
    assert node.get_parameter(name).value == getattr(Sample(), name)


def test_related_parameters_can_move_together_where_one_alone_may_not(make_node):
    node = make_node()
    bridge = ParameterBridge(node, Sample)
    assert not attempt(node, low=0.9).successful
    assert attempt(node, low=0.9, high=0.95).successful
    assert (bridge.configuration.low, bridge.configuration.high) == (0.9, 0.95)


def test_a_foreign_parameter_and_an_equal_value_are_no_change(make_node):
    node, handed = make_node(), []
    ParameterBridge(node, Sample, handed.append)
    node.declare_parameter('other', 1)
    assert attempt(node, other=2).successful
    assert attempt(node, low=0.25).successful
    assert not handed


def test_two_configurations_share_a_node(make_node):
    @dataclass(frozen=True, kw_only=True)
    class Another(Configuration):
        """A second one."""

        rate: float = parameter(5.0, 'how often', unit='Hz', low=0.1, high=50.0)

    node, handed = make_node(rate=10.0), []
    first = ParameterBridge(node, Sample, handed.append)
    second = ParameterBridge(node, Another, handed.append)
    assert second.configuration.rate == 10.0
    assert attempt(node, rate=20.0, count=6).successful
    assert (first.configuration.count, second.configuration.rate) == (6, 20.0)
    assert len(handed) == 2
