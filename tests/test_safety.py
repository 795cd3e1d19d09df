# SPDX-License-Identifier: Apache-2.0
"""Safety properties of the whole stack, each below the requirement that it defends.

The parts' own properties are tested beside the parts; here the loop runs on the physics while
something is wrong.
"""

from dataclasses import replace

import numpy as np
import pytest

from psane_mapping.mapper import TerrainMapper
from psane_planner.planner import SafePlanner
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.runs.closed_loop import ClosedLoop, Settings
from psane_sim.runs.summary import Task
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.touch.contact_sensing import ContactSensor

STANDING = 0.02
"""A body slower than this stands [m/s]: a robot at rest creeps a thousand times slower."""


def loop_of(duration, seed=0, settings=None, terrain=None, goal=None):
    terrain = terrain or load_terrain('env1')
    task = Task(terrain=terrain.name, start=terrain.start, goal=goal or terrain.goal,
                strategy='psane_geodesic', threshold=0.5, seed=seed, duration=duration)
    return ClosedLoop(task, terrain, terrain.start_pose, settings or Settings())


def speeds(loop):
    """Return times and speeds of the body along its recorded path, over spans of 0.1 s."""
    time, x, y = np.array(loop.record.path).T
    return time[2:], np.hypot(x[2:] - x[:-2], y[2:] - y[:-2]) / (time[2:] - time[:-2])


class Silence:
    """Makes a method do nothing from some moment on."""

    def __init__(self, method, is_over, answer=None):
        self._method, self._is_over, self._answer = method, is_over, answer

    def __call__(self, *arguments):
        return self._answer if self._is_over() else self._method(*arguments)


@pytest.mark.parametrize('seed', [11, 12])
def test_doubled_noise_leads_nobody_onto_unsafe_ground(seed):
    """Requirement: zero time where the true slip exceeds h; noise twice the reference."""
    settings = Settings(simulator=SimulatorConfiguration(noise_scale=2.0))
    loop = loop_of(60.0, seed, settings)
    _, score = loop.run()
    assert score.unsafe_time_s == 0.0
    assert score.false_certified_cells == 0
    assert score.path_m > 1.0


def test_a_start_beside_soft_ground_leads_nobody_into_it():
    """Requirement: zero time where the true slip exceeds h; here from 0.45 m beside it."""
    terrain = load_terrain('env1')
    slip = terrain.true_slip(np.array([[x, 5.0] for x in np.arange(2.0, 3.5, 0.01)]))
    edge = 2.0 + 0.01 * float(np.argmax(slip > 0.5))
    beside = replace(terrain, start=(edge - 0.45, 5.0), goal=(9.0, 5.0))
    _, score = loop_of(30.0, terrain=beside, goal=(9.0, 5.0)).run()
    assert score.unsafe_time_s == 0.0
    assert score.false_certified_cells == 0


def test_without_odometry_the_robot_stands_within_a_second(monkeypatch):
    """Requirement: odometry older than 0.5 s: the robot stops and says so."""
    loop = loop_of(14.0)
    lost = 10.0
    monkeypatch.setattr(loop, '_take_odometry', Silence(
        loop._take_odometry, lambda: loop._simulator.time > lost))
    loop.run()
    time, speed = speeds(loop)
    assert speed[(time > lost - 2.0) & (time < lost)].max() > 5.0 * STANDING
    # 0.5 s until odometry is too old, 0.35 s to the next command and to stand, 0.1 s for speeds.
    assert speed[time > lost + 1.0].max() < STANDING


def test_when_the_planner_falls_silent_the_robot_stays_in_its_last_region(monkeypatch):
    """Requirement: a stale region or subgoal: stop; never leave the region before that."""
    loop = loop_of(45.0)
    lost = 15.0
    monkeypatch.setattr(loop, '_plan', Silence(
        loop._plan, lambda: loop._simulator.time > lost))
    loop.run()
    limit = Settings().reactive.region_age_limit
    time, speed = speeds(loop)
    from shapely.geometry import Point
    # A third of the 0.15 m of certified ground that lie around the region; a march may drift.
    inside = [loop.record.region.buffer(0.05).contains(Point(x, y))
              for when, x, y in loop.record.path if when > lost]
    assert all(inside)
    assert speed[time > lost + limit + 1.0].max() < STANDING


def test_when_contacts_end_nothing_more_is_certified(monkeypatch):
    """Requirement: only what was felt is certified."""
    loop = loop_of(25.0)
    lost = 10.0
    areas = {}
    note = loop.record.note_plan

    def noting(plan, now, maps):
        areas[now] = int(plan.certified.sum())
        note(plan, now, maps)
    monkeypatch.setattr(loop.record, 'note_plan', noting)
    monkeypatch.setattr(loop._contact_sensor, 'update', Silence(
        loop._contact_sensor.update, lambda: loop._simulator.time > lost, answer=[]))
    _, score = loop.run()
    at_loss = max(area for now, area in areas.items() if now <= lost + 0.3)
    assert max(area for now, area in areas.items() if now > lost) <= at_loss
    assert score.unsafe_time_s == 0.0


def test_the_silenced_parts_exist():
    """The names that these tests replace are those of the loop, so that none tests nothing."""
    assert callable(ClosedLoop._take_odometry)
    assert callable(ClosedLoop._plan)
    assert callable(ContactSensor.update)
    assert callable(TerrainMapper.add)
    assert callable(SafePlanner.update)
