# SPDX-License-Identifier: Apache-2.0
"""A mapper whose map grows, and one that several robots feed."""

import math

import numpy as np
import pytest
from felt_stances import stance
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.errors import ParameterError
from psane_mapping.mapper import TerrainMapper, TerrainSample
from psane_mapping.prior_map import PriorMap
from psane_mapping.recent_stances import KEPT, RecentStances
from psane_mapping.strength import Reason

GROWING = MappingConfiguration(grow=True, max_x=1.0, max_y=1.0, largest_extent=50.0)
# The requirement on any order of the same contacts.
ROUND_OFF = 1e-8


def robot(number, count=15):
    """Return the stances of one robot's walk."""
    rng = np.random.default_rng(number)
    steps = np.cumsum(rng.uniform(-0.3, 0.5, (count, 2)), axis=0)
    return [stance(rng.uniform(0.1, 1.0), 0.06, seed=turn, point=tuple(point), time=float(turn))
            for turn, point in enumerate(5.0 * number + steps)]


def test_a_growing_map_follows_the_robot_and_keeps_what_was_felt():
    mapper = TerrainMapper(GROWING)
    first = mapper.grid
    near = mapper.add(stance(0.3, 0.08, point=(0.5, 0.5)))
    far = mapper.add(stance(1.0, 0.05, point=(-12.0, 20.0)))
    maps = mapper.maps()
    assert maps.grid == mapper.grid and maps.slip_mean.shape == maps.grid.shape
    assert maps.grid.rows > first.rows and maps.grid.origin_x < first.origin_x
    for sample in (near, far):
        row, column = maps.grid.index_of(sample.point)
        assert maps.slip_std[row, column] < 0.3 * GROWING.slip_prior_deviation
        assert abs(maps.slip_mean[row, column] - sample.slip) < 0.05


def test_a_grown_map_has_its_cells_where_they_were():
    mapper = TerrainMapper(GROWING)
    mapper.add(stance(0.3, 0.08, point=(0.5, 0.5)))
    before = mapper.maps()
    mapper.add(stance(0.3, 0.08, point=(-20.0, -20.0)))
    after = mapper.maps()
    low = after.grid.index_of(before.grid.point_of(np.array([0, 0])))
    high = low + np.array(before.grid.shape)
    kept = (slice(low[0], high[0]), slice(low[1], high[1]))
    assert np.allclose(after.grid.points.reshape(*after.grid.shape, 2)[kept],
                       before.grid.points.reshape(*before.grid.shape, 2))
    assert np.array_equal(after.slip_mean[kept], before.slip_mean)
    assert np.array_equal(after.slip_std[kept], before.slip_std)


def test_a_contact_absurdly_far_away_does_not_make_an_absurd_map():
    mapper = TerrainMapper(GROWING)
    before = mapper.grid
    outcome = mapper.add(stance(0.3, 0.08, point=(1e9, 0.0)))
    assert outcome.reason is Reason.OUTSIDE_MAP and mapper.grid == before
    assert isinstance(mapper.add(stance(0.3, 0.08, point=(50.0, 0.0))), TerrainSample)


def test_a_growing_map_has_a_prior_map_beyond_where_it_began():
    grid = TerrainMapper(MappingConfiguration()).grid
    prior = PriorMap.of_slip(grid, np.full(grid.shape, 0.4), TerrainMapper(GROWING).slip_model)
    mapper = TerrainMapper(GROWING, prior=prior)
    mapper.add(stance(0.3, 0.08, point=(9.0, 0.5)))
    maps = mapper.maps()
    row, column = maps.grid.index_of(np.array([4.0, 3.0]))
    assert abs(maps.slip_mean[row, column] - 0.4) < 1e-3


@settings(max_examples=5, deadline=None)
@given(order=st.permutations(range(30)), grow=st.booleans())
def test_two_robots_feed_one_map_in_whatever_order_their_contacts_come(order, grow):
    # Both depend on the map as it was when a contact came.
    config = MappingConfiguration(use_position_noise=False, surprise_reach=0.0, grow=grow)
    contacts = robot(0) + robot(1)
    one, other = TerrainMapper(config), TerrainMapper(config)
    for number in range(30):
        one.add(contacts[number])
        other.add(contacts[order[number]])
    assert one.accepted == other.accepted > 15
    for name in ('slip_mean', 'slip_std', 'log_strength_mean', 'log_strength_std'):
        difference = getattr(one.maps(), name) - getattr(other.maps(), name)
        assert np.abs(difference).max() < ROUND_OFF
    assert one.maps().time == other.maps().time


def test_samples_of_another_mapper_count_as_much_as_own_contacts():
    first, both = TerrainMapper(MappingConfiguration()), TerrainMapper(MappingConfiguration())
    for contact in robot(0):
        sample = first.add(contact)
        if isinstance(sample, TerrainSample):
            assert both.take(sample)
    assert np.array_equal(first.maps().slip_mean, both.maps().slip_mean)
    # A second robot starts on ground that the first one knows.
    assert both.maps().slip_std.min() < 0.3 * both.config.slip_prior_deviation


def test_the_order_of_contacts_matters_only_through_the_slope_and_little():
    contacts = robot(0)
    one, other = TerrainMapper(MappingConfiguration()), TerrainMapper(MappingConfiguration())
    for forward, backward in zip(contacts, reversed(contacts), strict=True):
        one.add(forward)
        other.add(backward)
    difference = np.abs(one.maps().slip_mean - other.maps().slip_mean)
    assert difference.max() > ROUND_OFF
    assert (difference <= 0.5 * one.maps().slip_std).all()


def test_duplicate_stamps_do_no_harm():
    mapper = TerrainMapper(MappingConfiguration())
    for leg in range(300):
        mapper.add(stance(0.4, 0.06, time=1.0, leg=leg))
    maps = mapper.maps()
    assert mapper.accepted == 300 and maps.time == 1.0
    assert np.isfinite(maps.slip_mean).all() and math.isfinite(maps.slip_std.sum())
    assert maps.slip_std.min() >= mapper.config.common_deviation


def test_the_same_stance_again_is_counted_and_tells_nothing_new():
    once, again = TerrainMapper(MappingConfiguration()), TerrainMapper(MappingConfiguration())
    once.add(stance(0.4, 0.06))
    for _ in range(5):
        outcome = again.add(stance(0.4, 0.06))
    assert outcome.reason is Reason.DUPLICATE and again.rejected[Reason.DUPLICATE] == 4
    assert np.array_equal(once.maps().slip_std, again.maps().slip_std)
    again.reset()
    assert isinstance(again.add(stance(0.4, 0.06)), TerrainSample)


def test_a_stance_is_remembered_for_long_but_not_for_ever():
    recent = RecentStances()
    for number in range(KEPT + 1):
        recent.add(stance(time=float(number)))
    assert recent.holds(stance(time=1.0)) and recent.holds(stance(time=float(KEPT)))
    assert not recent.holds(stance(time=0.0))


@pytest.mark.parametrize('text, topics', [
    ('leg_contacts', ('leg_contacts',)),
    (' /one/leg_contacts, two/leg_contacts,/one/leg_contacts,',
     ('/one/leg_contacts', 'two/leg_contacts')), ('~/felt', ('~/felt',))])
def test_topics_are_separated_by_commas_and_heard_once(text, topics):
    assert MappingConfiguration(contact_topics=text).topics_of_contacts == topics


@pytest.mark.parametrize('values', [
    {'contact_topics': ''}, {'contact_topics': ' , '}, {'contact_topics': 'a b'},
    {'contact_topics': '1robot'}, {'contact_topics': 'a//b'}, {'prior_topic': 'a b'},
    {'grow': True, 'tolerance': 0.0}, {'journal_sync': 'sometimes'}])
def test_a_configuration_that_cannot_work_is_refused(values):
    with pytest.raises(ParameterError):
        MappingConfiguration(**values)
