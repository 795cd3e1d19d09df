# SPDX-License-Identifier: Apache-2.0
"""What is noted of a controller's ticks, and what is made of it."""

import math

import pytest
import shapely

from psane_reactive.command import Command, Mode
from psane_reactive.controller import ReactiveController
from psane_reactive.watched import Tick, WatchedController, turns_at_updates

SMALL, LARGE = shapely.box(0.0, 0.0, 2.0, 2.0), shapely.box(0.0, 0.0, 3.0, 2.0)


def drive(controller):
    commands = []
    for number in range(12):
        now = 0.05 * number
        controller.set_region(SMALL if number < 6 else LARGE, now)
        controller.set_subgoal((1.8, 1.0 if number < 9 else 1.5), False, False, now)
        controller.set_odometry((0.5, 1.0, 0.0), (0.0, 0.0), now)
        commands.append(controller.command(now))
    return commands


def test_a_watched_controller_gives_the_same_commands_and_counts_regions_and_subgoals():
    watched = WatchedController()
    assert drive(watched) == drive(ReactiveController())
    assert [tick.region_number for tick in watched.ticks] == [1] * 6 + [2] * 6
    assert [tick.subgoal_number for tick in watched.ticks] == [1] * 9 + [2] * 3
    assert watched.ticks[0].direction == 0.0 and watched.ticks[0].found_by == 'straight'
    assert watched.ticks[-1].direction == pytest.approx(math.atan2(0.5, 1.3))


def tick(direction, region, subgoal, mode=Mode.DRIVE):
    return Tick(0.0, Command(0.1, 0.0, mode, ''), None, direction, 'straight', region, subgoal)


def test_turns_are_taken_at_new_regions_only_and_the_short_way_round():
    ticks = [tick(3.1, 1, 1), tick(2.0, 1, 1), tick(3.1, 1, 1), tick(-3.1, 2, 1), tick(0.0, 3, 2),
             tick(math.nan, 4, 2), tick(1.0, 5, 2), tick(1.0, 6, 2, Mode.MARCH)]
    short = 2.0 * math.pi - 6.2
    assert turns_at_updates(ticks, False) == pytest.approx([short, 3.1])
    assert turns_at_updates(ticks, True) == pytest.approx([short])
