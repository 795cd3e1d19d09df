# SPDX-License-Identifier: Apache-2.0
"""What is said of a run's steering, found by hand for runs that are made up."""

import math

import numpy as np
import pytest
import shapely

from psane_reactive.clearance import Border
from psane_reactive.command import Command, Mode
from psane_reactive.watched import Tick
from psane_sim.bench import main
from psane_sim.runs.steering_figures import Findings

WIDE, NARROW = Border(shapely.box(0, 0, 4, 2)), Border(shapely.box(0, 0, 2, 2))


def tick(border, number, mode=Mode.DRIVE, found_by='straight'):
    return Tick(0.0, Command(0.1, 0.0, mode, ''), border, math.nan, found_by, number, 1)


def figures_of(*moments):
    """Return the figures of a run of (border, region number, x) moments."""
    findings = Findings(times=[1.0], reached=1)
    findings.add_way([tick(border, number) for border, number, _ in moments],
                     np.array([(x, 1.0) for *_, x in moments]))
    return findings.figures('run')


def test_a_robot_that_drives_out_of_its_region_has_left_it():
    found = figures_of((WIDE, 1, 3.0), (WIDE, 1, 4.02), (WIDE, 1, 4.05), (WIDE, 1, 3.9))
    assert found['run_left_region_m'] == pytest.approx(0.05)
    assert found['run_left_share'] == found['run_outside_share'] == 0.5
    assert found['run_revoked'] == 0.0


def test_ground_that_is_revoked_under_the_robot_was_not_left():
    found = figures_of((WIDE, 1, 3.0), (NARROW, 2, 3.0), (NARROW, 2, 2.5), (NARROW, 2, 1.9))
    assert found['run_left_region_m'] == found['run_left_share'] == 0.0
    assert found['run_revoked'] == 1.0
    assert found['run_outside_m'] == pytest.approx(1.0)


def test_a_robot_that_came_back_and_goes_out_again_has_left_its_region():
    found = figures_of((WIDE, 1, 3.0), (NARROW, 2, 3.0), (NARROW, 2, 1.9), (NARROW, 2, 2.01))
    assert found['run_revoked'] == 1.0
    assert found['run_left_region_m'] == pytest.approx(0.01)


def test_a_robot_that_begins_outside_has_not_left_anything():
    found = figures_of((NARROW, 1, 2.2), (NARROW, 1, 2.1), (NARROW, 1, 1.9))
    assert found['run_outside_m'] == found['run_left_region_m'] == 0.0
    assert found['run_began_outside_share'] == pytest.approx(2.0 / 3.0)


def test_only_the_steering_has_a_full_measurement():
    with pytest.raises(SystemExit):
        main(['plan', '--full'])
