# SPDX-License-Identifier: Apache-2.0
"""Recorded contacts and odometry through the real mapper, planner and controller.

The bags hold what the nodes said when they were recorded. `record_test_bags` of `psane_sim`
records them anew, when what the nodes say has changed and is meant to; `mutate_bags.py` shows
what these tests notice.
"""

import math

import numpy as np
import pytest
from bag_replay import BAGS, replayed

from psane_msgs.msg import PlannerStatus
from psane_sim.bags.lockstep_times import PLAN_STEP

# The first test of each bag takes the time of the whole run; a machine may be busy.
pytestmark = pytest.mark.timeout(900)

# Processors differ in the last digits of exp and log, no more.
RELATIVE = 1e-6
# A cell on the edge between two steps may then fall to the other side.
CELLS_OFF, STEPS_OFF = 1e-3, 1
# One cell of a region's edge [m^2], and the side of a cell [m].
AREA_OFF, DISTANCE_OFF = 0.01, 0.1
# Plans in which that may happen, as a share; on the machine of the recording there is none.
PLANS_OFF = 0.02
SPEED_OFF = 1e-3


@pytest.fixture(scope='module', params=['env1', 'faults'])
def run(request, tmp_path_factory):
    return request.param, replayed(request.param, tmp_path_factory.mktemp(request.param))


def test_the_nodes_offer_the_recorded_quality_of_service(run):
    _, replay = run
    assert replay.offers_now == replay.offers_then


def test_every_contact_says_of_the_ground_what_it_said(run):
    _, replay = run
    then, now = replay.recorded.all('/terrain_samples'), replay.now.all('/terrain_samples')
    assert len(now) == len(then) > 20

    def numbers(samples):
        return np.array([(sample.header.stamp.sec + 1e-9 * sample.header.stamp.nanosec,
                          sample.point.x, sample.point.y, sample.leg, sample.strength,
                          sample.log_strength_deviation, sample.slip, sample.slip_deviation)
                         for sample in samples])
    np.testing.assert_allclose(numbers(now), numbers(then), rtol=RELATIVE)
    assert {sample.header.frame_id for sample in now} == {'map'}


@pytest.mark.parametrize('topic', ['/slip/mean', '/slip/std'])
def test_the_maps_are_the_recorded_maps(run, topic):
    _, replay = run
    pairs = list(zip(replay.now.cells(topic), replay.recorded.cells(topic), strict=True))
    assert sum(then is not None for _, then in pairs) > 30
    for now, then in pairs:
        assert (now is None) == (then is None)
        if then is None:
            continue
        assert now.shape == then.shape
        off = np.abs(now.astype(int) - then)
        assert off.max() <= STEPS_OFF
        assert np.count_nonzero(off) <= CELLS_OFF * off.size


def test_the_regions_are_the_recorded_regions(run):
    _, replay = run
    areas = [now.symmetric_difference(then).area for now, then in zip(
        replay.now.regions(), replay.recorded.regions(), strict=True)]
    assert max(region.area for region in replay.recorded.regions()) > 0.5
    assert np.mean(np.array(areas) > AREA_OFF) <= PLANS_OFF


def test_the_subgoals_are_the_recorded_subgoals(run):
    _, replay = run
    now, then = replay.now.subgoals(), replay.recorded.subgoals()
    chosen = np.isfinite(then[:, 0])
    assert len({tuple(point) for point in then[chosen]}) >= 3
    assert np.mean(np.isfinite(now[:, 0]) != chosen) <= PLANS_OFF
    both = chosen & np.isfinite(now[:, 0])
    distance = np.hypot(*(now[both] - then[both]).T)
    assert np.mean(distance > DISTANCE_OFF) <= PLANS_OFF


def test_the_planner_is_in_the_recorded_states(run):
    _, replay = run
    pairs = list(zip(replay.now.all('/planner_status'), replay.recorded.all('/planner_status'),
                     strict=True))
    assert len(pairs) > 30
    assert np.mean([(now.state, now.march, now.has_subgoal, now.subgoal_is_goal)
                    != (then.state, then.march, then.has_subgoal, then.subgoal_is_goal)
                    for now, then in pairs]) <= PLANS_OFF
    areas = np.array([(now.certified_area, then.certified_area) for now, then in pairs])
    assert np.mean(np.abs(areas[:, 0] - areas[:, 1]) > 3.0 * AREA_OFF) <= PLANS_OFF


def test_the_commands_are_the_recorded_commands(run):
    _, replay = run
    now, then = replay.now.commands(), replay.recorded.commands()
    assert now.shape == then.shape
    assert np.abs(then[:, 0]).max() > 0.1 and np.abs(then[:, 1]).max() > 0.1
    # A region that differs by a cell may turn a command until it is left behind.
    assert np.mean(np.abs(now - then).max(axis=1) > SPEED_OFF) <= 3.0 * PLANS_OFF


def test_the_bags_are_small_enough_to_live_with_the_source():
    sizes = [sum(path.stat().st_size for path in folder.iterdir()) for folder in BAGS.iterdir()]
    assert len(sizes) == 2 and max(sizes) < 3_000_000


# --- what the faults do, in what the nodes say now

def between(messages, begin, end):
    return [message for time, message in messages if 1000 * begin < time <= 1000 * end]


def faults_of(run):
    name, replay = run
    if name != 'faults':
        pytest.skip('this run goes well')
    return replay.now


def test_without_odometry_the_planner_waits_and_the_robot_stands(run):
    said = faults_of(run)
    # Lost from 6 s to 7.5 s; it is too old after 0.5 s.
    lost = between(said.topics['/planner_status'], 6.8, 7.4)
    assert lost and all(status.state == PlannerStatus.WAITING for status in lost)
    commands = between(said.topics['/cmd_vel'], 6.8, 7.4)
    assert commands and all(command.linear.x == command.angular.z == 0.0 for command in commands)
    after = between(said.topics['/planner_status'], 7.9, 8.5)
    assert after and all(status.state == PlannerStatus.SEEKING for status in after)


def test_contacts_without_a_number_or_in_another_frame_change_nothing(run):
    said = faults_of(run)
    # Spoiled from 8.5 s to 10.5 s: every contact, turn by turn.
    assert between(said.topics['/terrain_samples'], 6.0, 8.5)
    assert not between(said.topics['/terrain_samples'], 8.5, 10.5)
    assert between(said.topics['/terrain_samples'], 10.6, 12.0)
    at = [number for number, time in enumerate(range(PLAN_STEP, said.end + 1, PLAN_STEP))
          if 8600 < time <= 10_400]
    maps = said.cells('/slip/mean')
    assert all(np.array_equal(maps[number], maps[at[0]]) for number in at)


def test_a_mapper_that_starts_anew_begins_with_an_empty_map_and_fills_it(run):
    said = faults_of(run)

    def estimates(time):
        return np.count_nonzero(said.cells('/slip/std')[time // PLAN_STEP - 1] < 40)
    assert estimates(12_000) == 0 < estimates(11_800)
    assert estimates(16_000) > 50


def test_no_command_is_ever_a_number_that_is_none(run):
    _, replay = run
    assert np.isfinite(replay.now.commands()).all()
    assert all(math.isfinite(status.certified_area)
               for status in replay.now.all('/planner_status'))
