# SPDX-License-Identifier: Apache-2.0
"""A long build runs beside the control loop; an old map leads only within a grown region."""

from concurrent.futures import Executor, Future

import pytest
import shapely

from psane_reactive.command import Mode
from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.controller import ReactiveController
from psane_reactive.map_builder import AtOnce, build_map

STEP = 0.05
STILL = (0.0, 0.0)
L_SHAPE = shapely.box(0, 0, 5, 0.8).union(shapely.box(4.2, 0, 5, 4))
GROWN = L_SHAPE.union(shapely.box(4.2, 3, 7, 4))
SHRUNK = L_SHAPE.difference(shapely.box(0, 0.6, 3.6, 0.8))


class Later(Executor):
    """Keeps tasks until it is told to run them."""

    def __init__(self):
        self.waiting = []

    def submit(self, task, /, *arguments, **named):
        future = Future()
        self.waiting.append((future, task, arguments, named))
        return future

    def run(self):
        for future, task, arguments, named in self.waiting:
            future.set_result(task(*arguments, **named))
        self.waiting = []


def steered(executor, region=L_SHAPE):
    controller = ReactiveController(ReactiveConfiguration(), executor)
    controller.set_region(region, 0.0)
    controller.set_subgoal((4.6, 3.8), False, True, 0.0)
    controller.set_odometry((0.4, 0.4, 0.0), STILL, 0.0)
    return controller


def test_while_the_first_map_is_built_the_robot_stands_and_says_why():
    later = Later()
    controller = steered(later)
    command = controller.command(0.0)
    assert command.mode is Mode.STOPPED
    assert 'being built' in command.reason
    assert controller.counts.by_field == 0
    later.run()
    assert controller.command(STEP).reason == 'harmonic'
    assert controller.counts.maps_built == 1


def test_a_grown_region_is_steered_in_by_the_old_map_until_the_new_one_is_there():
    later = Later()
    controller = steered(later)
    controller.command(0.0)
    later.run()
    controller.command(0.0)
    controller.set_region(GROWN, STEP)
    assert controller.command(STEP).reason == 'harmonic'
    assert len(later.waiting) == 1
    later.run()
    assert controller.command(2 * STEP).reason == 'harmonic'
    assert controller.counts.maps_built == 2


def test_a_shrunk_region_is_never_steered_in_by_the_old_map():
    later = Later()
    controller = steered(later)
    controller.command(0.0)
    later.run()
    controller.set_region(SHRUNK, STEP)
    assert controller.command(STEP).mode is Mode.STOPPED
    later.run()
    assert controller.command(2 * STEP).reason == 'harmonic'


def test_a_visible_goal_needs_no_map():
    later = Later()
    controller = steered(later)
    controller.set_subgoal((2.0, 0.4), False, True, 0.0)
    assert controller.command(0.0).reason == 'straight'
    assert later.waiting == []


@pytest.mark.parametrize('steering', ['harmonic', 'purging'])
def test_a_region_without_area_gives_no_map_and_no_exception(steering):
    settings = ReactiveConfiguration(steering_map=steering)
    assert build_map(shapely.Polygon([(0, 0), (1, 0), (2, 0)]), settings) is None


def test_at_once_hands_on_results_and_errors():
    assert AtOnce().submit(lambda: 3).result() == 3
    with pytest.raises(ZeroDivisionError):
        AtOnce().submit(lambda: 1 / 0).result()
