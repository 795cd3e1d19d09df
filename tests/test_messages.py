# SPDX-License-Identifier: Apache-2.0
"""Every message, service and action survives serialization, and its constants are told apart."""

import array
import itertools
import math
from pathlib import Path

import pytest
from geometry_msgs.msg import Point, PoseStamped, Wrench
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from source_tree import ROOT

from psane_msgs import action, msg, srv

INTERFACES = ROOT / 'src' / 'psane_msgs'

# Parts of services and actions are messages too.
PLAIN = [
    msg.LegContact, msg.HipWrenches, msg.TerrainSample, msg.MapScale, msg.Ring,
    msg.RegionPolygon, msg.SafeRegion, msg.FrontierArray, msg.PlannerStatus,
    srv.SaveMap.Request, srv.SaveMap.Response, srv.LoadMap.Request, srv.LoadMap.Response,
    srv.ResetMap.Request, srv.ResetMap.Response, action.NavigateSafely.Goal,
    action.NavigateSafely.Result, action.NavigateSafely.Feedback,
]
numbers = st.floats(allow_nan=False)
channels = st.lists(numbers, max_size=20)


def sent(message):
    """Return the message as a subscriber gets it."""
    return deserialize_message(serialize_message(message), type(message))


def filled(kind, counter):
    """Return a message in which every field differs from its default and from the others."""
    message = kind()
    for name, field_type in kind.get_fields_and_field_types().items():
        setattr(message, name, value_for(getattr(message, name), field_type, counter))
    return message


def value_for(default, field_type, counter):
    number = next(counter)
    if field_type == 'boolean':
        return True
    if isinstance(default, str):
        return f'text {number}'
    if isinstance(default, int):
        return 1 + number % 250
    if isinstance(default, float):
        return number + 0.5
    if hasattr(default, 'get_fields_and_field_types'):
        return filled(type(default), counter)
    return values_for(default, field_type, counter)


def values_for(default, field_type, counter):
    if field_type == 'sequence<double>':
        return array.array('d', [next(counter) + 0.25 for _ in range(3)])
    if field_type == 'sequence<boolean>':
        return [True, False, True]
    element = {'geometry_msgs/Point': Point, 'geometry_msgs/Wrench': Wrench,
               'psane_msgs/Ring': msg.Ring, 'psane_msgs/RegionPolygon': msg.RegionPolygon}
    name = field_type.removeprefix('sequence<').removesuffix('>').split('[')[0]
    return [filled(element[name], counter) for _ in range(len(default) or 2)]


@pytest.mark.parametrize('kind', PLAIN, ids=lambda kind: kind.__name__)
def test_every_field_survives_serialization(kind):
    message = filled(kind, itertools.count(1))
    if message.get_fields_and_field_types():
        assert message != kind() or kind is srv.ResetMap.Request
    assert sent(message) == message


@pytest.mark.parametrize('kind', PLAIN, ids=lambda kind: kind.__name__)
def test_an_empty_message_survives_serialization(kind):
    assert sent(kind()) == kind()


def test_the_list_above_names_every_interface_there_is():
    files = {path.stem for folder in ('msg', 'srv', 'action')
             for path in (INTERFACES / folder).iterdir()}
    built = {kind.__name__.rsplit('_', 1)[0] if '_' in kind.__name__ else kind.__name__
             for kind in PLAIN}
    assert built == files
    listed = (INTERFACES / 'CMakeLists.txt').read_text()
    assert not [name for name in files if f'/{name}.' not in listed]


@settings(max_examples=50, deadline=None)
@given(depth=channels, x=numbers, y=numbers, leg=st.integers(0, 255))
def test_the_numbers_of_a_contact_arrive_to_the_last_bit(depth, x, y, leg):
    message = msg.LegContact(leg=leg, point=Point(x=x, y=y), depth=depth,
                             measured_forward=depth, deviation_moment=depth)
    arrived = sent(message)
    assert (arrived.leg, arrived.point.x, arrived.point.y) == (leg, x, y)
    assert list(arrived.depth) == list(arrived.deviation_moment) == depth
    assert not arrived.response_forward


@settings(max_examples=30, deadline=None)
@given(sizes=st.lists(st.lists(st.integers(0, 5), min_size=1, max_size=4), max_size=4))
def test_a_region_keeps_its_polygons_rings_and_points(sizes):
    def ring(count, offset):
        return msg.Ring(points=[Point(x=float(offset), y=float(i)) for i in range(count)])

    polygons = [msg.RegionPolygon(outer=ring(counts[0], 0),
                                  holes=[ring(n, 1 + i) for i, n in enumerate(counts[1:])])
                for counts in sizes]
    region = sent(msg.SafeRegion(polygons=polygons, clearance=0.17, sequence=2**32 - 1))
    assert region.polygons == polygons
    assert (region.clearance, region.sequence) == (0.17, 2**32 - 1)


def test_a_status_without_a_goal_carries_not_a_number():
    assert math.isnan(sent(msg.PlannerStatus(distance_to_goal=math.nan)).distance_to_goal)


def test_six_hips_are_neither_five_nor_seven():
    for count in (5, 7):
        with pytest.raises(AssertionError):
            msg.HipWrenches(check_fields=True, wrenches=[Wrench()] * count)


@pytest.mark.parametrize(('kind', 'names'), [
    (msg.PlannerStatus, ('WAITING', 'SEEKING', 'TO_GOAL', 'REACHED', 'EXPLORED', 'STALLED',
                         'LOST')),
    (action.NavigateSafely.Result, ('NONE', 'INVALID_GOAL', 'INVALID_STRATEGY', 'INVALID_FRAME',
                                    'STALLED', 'LOST', 'NO_DATA', 'PREEMPTED', 'UNKNOWN'))])
def test_constants_are_told_apart(kind, names):
    values = [getattr(kind, name) for name in names]
    assert len(set(values)) == len(values)


def test_an_action_goal_holds_a_pose():
    goal = action.NavigateSafely.Goal(goal=PoseStamped(), explore=True, strategy='psane')
    goal.goal.header.frame_id = 'map'
    assert sent(goal).goal.header.frame_id == 'map'


@pytest.mark.parametrize('path', sorted(INTERFACES.glob('*/*.[msa]*')), ids=lambda p: p.name)
def test_every_number_states_its_unit(path: Path):
    """A float64 stands below a comment with its unit in brackets."""
    comment, previous_was_field = '', False
    for line in path.read_text().splitlines():
        if line.startswith('#'):
            comment = line if previous_was_field or not comment else comment + line
            previous_was_field = False
        elif not line.strip():
            if previous_was_field:
                comment = ''
            previous_was_field = False
        else:
            if line.startswith('float64'):
                has_unit = '[' in comment or path.name == 'MapScale.msg'
                assert has_unit, f'{path.name}: {line} has no unit above it'
            previous_was_field = True
