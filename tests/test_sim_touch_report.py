# SPDX-License-Identifier: Apache-2.0
"""How well strength is felt: the figures that are asked for, on a shorter walk."""

import numpy as np
import pytest

from psane_mapping.configuration import MappingConfiguration
from psane_sim.touch.report import OTHER_GAITS, STRAIGHT, Effort, _felt, errors_of, figures

EFFORT = Effort(seconds=5.0, draws=3, strengths=(0.05, 0.2, 0.8, 3.0))
CONFIG = MappingConfiguration()
LINEAR = MappingConfiguration(strength_method='linear_stiffness', least_r_squared=0.0)


@pytest.fixture(scope='module')
def matched():
    return _felt(EFFORT, [STRAIGHT], 0.005, {})


def test_strength_is_felt_to_a_tenth_and_much_better_than_by_the_linear_fit(matched):
    errors, linear = errors_of(matched, CONFIG), errors_of(matched, LINEAR)
    assert errors.median <= 0.10
    assert errors.rmse <= 0.13  # what is asked for at 2 mm of height bias; 0.20 at these 5 mm
    assert linear.rmse >= 1.5 * errors.rmse
    assert errors.rejected_share < 0.05


def test_nine_of_ten_intervals_hold_the_truth(matched):
    # 85 to 95 % is asked for over the whole range; these few stances know it to about 3 %.
    assert 0.82 <= errors_of(matched, CONFIG).coverage <= 0.99


def test_learning_the_height_helps_at_ten_millimetres_and_does_no_harm_at_two(matched):
    for bias, factor in ((0.010, 0.6), (0.002, 1.05)):
        learnt, not_learnt = (errors_of(_felt(EFFORT, [STRAIGHT], bias, {}, learn_height=learn),
                                        CONFIG).rmse for learn in (True, False))
        assert learnt <= factor * not_learnt


def test_other_gaits_feel_as_well():
    assert errors_of(_felt(EFFORT, OTHER_GAITS, 0.005, {}), CONFIG).rmse <= 0.15


def test_the_vertical_force_alone_will_do_without_a_velocity():
    errors = errors_of(_felt(EFFORT, [STRAIGHT], 0.005, {}, with_odometry=False), CONFIG)
    assert errors.rmse <= 0.20


def test_ground_that_is_not_as_modelled_is_felt_worse_and_it_is_said_by_how_much(matched):
    other = errors_of(_felt(EFFORT, [STRAIGHT], 0.005, {'depth_exponent': 1.2}), CONFIG)
    assert other.rmse > errors_of(matched, CONFIG).rmse
    claimed = np.hypot(other.claimed, other.missing_deviation)
    assert np.mean(np.abs(other.error) <= 1.645 * claimed) == pytest.approx(0.9, abs=0.02)


def test_every_figure_has_a_name_of_its_own(matched):
    errors = errors_of(matched, CONFIG)
    named = figures({'5 mm': errors, '5 mm, tilted 20 %': errors, '5 mm, tilted -20 %': errors})
    assert len(named) == 15
    assert all(name.isidentifier() for name in named)
