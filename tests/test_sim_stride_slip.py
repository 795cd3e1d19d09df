# SPDX-License-Identifier: Apache-2.0
"""Slip of single strides, and random commands."""

import numpy as np
import pytest

from psane_sim.configuration import SimulatorConfiguration
from psane_sim.hexapod import HexapodSimulator
from psane_sim.ladder import measure_slip
from psane_sim.stride_slip import strides_of, ways_ahead
from psane_sim.terrain import Terrain
from psane_sim.twist_trials import FALLEN, walk_at_random

CONFIG = SimulatorConfiguration()


def steps_of(strength, command, seconds):
    steps = []
    with HexapodSimulator(CONFIG, Terrain.uniform(strength), (5.0, 5.0, 0.4)) as robot:
        for _ in range(round(seconds / 0.05)):
            robot.command(*command)
            steps.append((robot.time, *robot.truth().pose, *command))
            robot.step(50)
    return steps


@pytest.mark.parametrize('strength', [0.08, 0.2, 1.0])
def test_the_slip_of_strides_is_that_of_a_long_walk(strength):
    strides = strides_of(steps_of(strength, (0.29, 0.0), 9.0), CONFIG)
    assert len(strides) >= 5
    expected = measure_slip(strength).slip
    # The first strides set off from rest.
    assert np.median([stride.slip for stride in strides]) == pytest.approx(expected, abs=0.05)


def test_a_robot_that_stands_or_turns_on_the_spot_has_no_slip():
    assert not strides_of(steps_of(0.5, (0.0, 0.0), 3.0), CONFIG)
    assert not strides_of(steps_of(0.5, (0.0, 0.4), 3.0), CONFIG)


def test_a_way_is_counted_along_the_heading():
    yaw = 0.3
    rows = np.array([(0.0, 0.0, 0.0, yaw), (1.0, np.cos(yaw), np.sin(yaw), yaw),
                     (2.0, np.cos(yaw) - np.sin(yaw), np.sin(yaw) + np.cos(yaw), yaw)])
    np.testing.assert_allclose(ways_ahead(rows), [1.0, 0.0], atol=1e-12)


def test_random_commands_do_not_make_it_fall():
    # A thousand are walked by `python -m psane_sim.twist_trials`.
    trials = [walk_at_random(seed) for seed in range(5000, 5006)]
    assert all(trial.tilt < FALLEN for trial in trials)
    assert [walk_at_random(5000)] == trials[:1]
