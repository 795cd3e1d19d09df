# SPDX-License-Identifier: Apache-2.0
"""Pieces of certified ground, and ways over it, beside plain ways to work them out."""

import math

import numpy as np
import pytest
from scipy import ndimage

from psane_mapping.grid import Grid
from psane_planner.component import Components
from psane_planner.geodesic import distance_along, least_cost

GRID = Grid.over_workspace(0.0, 0.0, 4.0, 3.0, 0.1)
ROUNDING = 1e-9


def some_ground(seed, share=0.5):
    field = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=GRID.shape), 1.5)
    return field > np.quantile(field, 1.0 - share)


@pytest.mark.parametrize('seed', range(6))
def test_the_piece_is_that_of_the_nearest_certified_square(seed):
    certified = some_ground(seed)
    labels, _ = ndimage.label(certified)
    pieces = Components(certified, GRID)
    for position in np.random.default_rng(seed).uniform((-0.5, -0.5), (4.5, 3.5), (40, 2)):
        aside = np.maximum(np.abs(GRID.points - position) - GRID.resolution / 2.0, 0.0)
        away = np.where(certified.ravel(), np.hypot(*aside.T), np.inf)
        found = pieces.around(position)
        assert found.outside_distance == pytest.approx(away.min(), abs=ROUNDING)
        label = labels.ravel()[np.argmin(away)]
        assert np.array_equal(found.mask, labels == label)


def test_a_piece_that_is_asked_for_again_is_the_very_same():
    certified = some_ground(1)
    pieces = Components(certified, GRID)
    inside = GRID.points[np.flatnonzero(certified.ravel())[0]]
    assert pieces.around(inside).mask is pieces.around(inside + 1e-4).mask


def test_without_certified_ground_there_is_no_piece():
    found = Components(np.zeros(GRID.shape, dtype=bool), GRID).around(np.array((1.0, 1.0)))
    assert not found.mask.any()
    assert found.outside_distance == math.inf


def residual_of(field, cost, where):
    """Return by how much a field in cells misses the upwind scheme, cell by cell."""
    padded = np.pad(field, 1, constant_values=np.inf)
    across = np.minimum(padded[1:-1, :-2], padded[1:-1, 2:])
    along = np.minimum(padded[:-2, 1:-1], padded[2:, 1:-1])
    low, high = np.minimum(across, along)[where], np.maximum(across, along)[where]
    value = low + cost[where]
    both = high < value
    gap = high[both] - low[both]
    value[both] = 0.5 * (low[both] + high[both]
                         + np.sqrt(2.0 * cost[where][both] ** 2 - gap**2))
    return np.abs(value - field[where])


@pytest.mark.parametrize('seed', range(6))
def test_the_least_cost_solves_the_upwind_scheme_in_every_cell(seed):
    generator = np.random.default_rng(seed)
    cost = np.where(some_ground(seed, 0.7), 1.0 + 4.0 * generator.random(GRID.shape), np.inf)
    source = GRID.points[np.flatnonzero(np.isfinite(cost).ravel())[50]]
    field = least_cost(cost, GRID, source) / GRID.resolution
    # Around the source the field is not the scheme's, but straight.
    far = np.hypot(*(GRID.points - source).T).reshape(GRID.shape) > 0.31
    assert residual_of(field, cost, np.isfinite(field) & far).max() < 1e-6


@pytest.mark.parametrize('seed', range(6))
def test_ways_lead_to_every_cell_of_the_piece_and_to_no_other(seed):
    certified = some_ground(seed)
    start = GRID.points[np.flatnonzero(certified.ravel())[20]]
    field = distance_along(certified, GRID, start)
    piece = Components(certified, GRID).around(start).mask
    assert np.array_equal(np.isfinite(field), piece)
