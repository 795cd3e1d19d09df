# SPDX-License-Identifier: Apache-2.0
"""What the mapper says of itself, and when it publishes."""

import math

import numpy as np
import pytest
from felt_stances import stance
from hypothesis import given
from hypothesis import strategies as st

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.gaussian_process import Innovation
from psane_mapping.innovations import InnovationMonitor
from psane_mapping.map_health import health_of
from psane_mapping.map_keeper import MapKeeper
from psane_mapping.pacing import Pacer
from psane_mapping.update_times import UpdateTimes


def watched(scale, count=100, seed=0):
    monitor = InnovationMonitor(100)
    for value in np.random.default_rng(seed).normal(0.0, scale, count):
        monitor.add(Innovation(float(value), 1.0))
    return monitor.summary()


@pytest.mark.parametrize('seed', range(20))
def test_an_honest_model_is_not_called_over_confident_and_one_twice_too_sure_is(seed):
    assert not watched(1.0, seed=seed).is_over_confident(1.5)
    assert watched(2.0, seed=seed).is_over_confident(1.5)


def test_few_contacts_are_no_evidence():
    assert not watched(5.0, count=29).is_over_confident(1.5)
    assert watched(5.0, count=30).is_over_confident(1.5)


def test_only_the_latest_innovations_count():
    monitor = InnovationMonitor(50)
    for value in [10.0] * 50 + [0.5] * 50:
        monitor.add(Innovation(value, 1.0))
    assert monitor.summary().rms == 0.5 and monitor.summary().count == 50
    monitor.clear()
    assert monitor.summary().count == 0


def test_an_innovation_that_is_not_a_number_is_left_out():
    monitor = InnovationMonitor(50)
    monitor.add(Innovation(math.nan, math.nan))
    assert monitor.summary().count == 0


def fed(strength_of, count=120, **values):
    keeper = MapKeeper(MappingConfiguration(**values))
    rng = np.random.default_rng(1)
    for seed in range(count):
        x, y = rng.uniform(3.0, 6.0, 2)
        keeper.add(stance(strength_of(x, y, seed), 0.06, seed=seed, point=(x, y),
                          time=float(seed)))
    return keeper


def test_ground_as_the_model_has_it_is_reported_as_well():
    keeper = fed(lambda x, y, seed: 0.15 + 0.05 * math.sin(x))
    health = health_of(keeper, UpdateTimes())
    assert health.is_well and f'latest contact at {keeper.mapper.latest:.2f} s' in health.message
    assert health.values['contacts accepted'] == keeper.mapper.accepted > 100
    assert float(health.values['slip: innovation rms [-]']) < 1.5


def test_ground_rougher_than_the_model_is_reported_as_over_confident():
    rng = np.random.default_rng(0)
    keeper = fed(lambda x, y, seed: math.exp(rng.normal(-2.3, 0.9)))
    health = health_of(keeper, UpdateTimes())
    assert not health.is_well and 'over-confident' in health.message


def test_rejections_are_reported_by_reason_and_a_mapper_without_contacts_says_so():
    keeper = MapKeeper(MappingConfiguration())
    keeper.add(stance(0.4, 0.001))
    health = health_of(keeper, UpdateTimes())
    assert not health.is_well and 'no contact' in health.message
    assert health.values['rejected: not deep enough'] == 1


def test_a_journal_that_cannot_be_written_is_reported(tmp_path):
    (tmp_path / 'file').write_text('in the way')
    keeper = MapKeeper(MappingConfiguration(map_directory=str(tmp_path / 'file' / 'maps')))
    keeper.add(stance(0.4, 0.06))
    health = health_of(keeper, UpdateTimes())
    assert not health.is_well and 'not kept on disk' in health.message


def test_update_times_are_those_of_the_latest_contacts():
    times = UpdateTimes()
    assert times.milliseconds() == {}
    for number in range(2000):
        times.add(1.0 if number < 1000 else 0.001 * (1 + number % 3))
    assert times.milliseconds() == pytest.approx({'median': 2.0, 'p99': 3.0, 'longest': 3.0})


def test_a_change_is_published_at_once_and_then_after_the_period():
    pacer = Pacer(5.0)
    assert pacer.is_due(0, 10.0, 0.0)
    pacer.published(0, 10.0, 0.0, 0.001)
    assert not pacer.is_due(0, 99.0, 99.0)
    assert not pacer.is_due(1, 10.19, 0.19)
    assert pacer.is_due(1, 10.2, 0.2)


def test_a_clock_that_jumps_back_does_not_stop_the_maps():
    pacer = Pacer(5.0)
    pacer.published(0, 1000.0, 0.0, 0.001)
    assert pacer.is_due(1, 3.0, 0.1)


@given(st.floats(0.001, 2.0))
def test_a_map_that_is_slow_to_publish_leaves_most_of_the_time_to_contacts(cost):
    pacer = Pacer(5.0)
    pacer.published(0, 0.0, 0.0, cost)
    assert not pacer.is_due(1, 1e6, 4.9 * cost)
    assert pacer.is_due(1, 1e6, 5.1 * cost)
