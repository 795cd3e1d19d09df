# SPDX-License-Identifier: Apache-2.0
"""The incremental posterior against dense algebra and scikit-learn, and its laws."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psane_mapping.basis import RectangleBasis
from psane_mapping.benchmark import measure
from psane_mapping.errors import ParameterError, ShapeError
from psane_mapping.gaussian_process import GridPosterior
from psane_mapping.grid import Grid
from psane_mapping.kernels import KERNELS, RadialBasis, kernel_named, reach_of
from psane_mapping.tiling import Tiling
from psane_mapping.windows import SpectralWindow

GRID = Grid.over_workspace(0.0, 0.0, 4.0, 3.0, 0.1)
RBF = RadialBasis(lengthscale=0.6, deviation=0.5)

# The requirement on any order of the same measurements, and on the exact setting.
ROUND_OFF = 1e-8
# What the default tolerance of 1e-8 may cost; the requirement on 101 x 101 cells is 1e-3.
DEFAULT_ERROR = 1e-3


def draw(count, seed, grid=GRID):
    rng = np.random.default_rng(seed)
    low = np.array([grid.origin_x, grid.origin_y]) + 1e-6
    size = np.array(grid.shape[::-1]) * grid.resolution - 2e-6
    points = low + rng.uniform(0.0, 1.0, (count, 2)) * size
    return points, rng.normal(0.3, 0.4, count), rng.uniform(0.02, 0.2, count)


def fill(posterior, points, values, noise):
    for point, value, deviation in zip(points, values, noise, strict=True):
        posterior.condition(point, value, deviation)
    return posterior


def dense(kernel, cells, points, values, noise, prior_mean=0.0):
    def covariance(one, other):
        distance = np.linalg.norm(one[:, None] - other[None], axis=-1)
        return kernel.deviation**2 * kernel.correlation(distance)

    gram = covariance(points, points) + np.diag(noise**2)
    cross = covariance(points, cells)
    mean = prior_mean + cross.T @ np.linalg.solve(gram, values - prior_mean)
    removed = (cross * np.linalg.solve(gram, cross)).sum(axis=0)
    return mean, np.sqrt(np.maximum(kernel.deviation**2 - removed, 0.0))


def small_tiles(monkeypatch, grid, kernel, tolerance, cells=12):
    tiling = Tiling(grid, cells, cells, reach_of(kernel, tolerance))
    monkeypatch.setattr(Tiling, 'cheapest', classmethod(lambda *_: tiling))
    posterior = GridPosterior(grid, kernel, tolerance=tolerance)
    assert not posterior.tiling.is_whole
    return posterior


def test_the_posterior_equals_scikit_learn_on_the_default_map():
    figures = measure()
    assert figures['max_mean_error'] <= DEFAULT_ERROR
    assert figures['max_std_error'] <= DEFAULT_ERROR
    assert figures['max_exact_error'] <= ROUND_OFF


@pytest.mark.parametrize('name', sorted(KERNELS))
def test_with_tolerance_zero_every_kernel_equals_the_dense_solve(name):
    kernel = kernel_named(name, 0.6, 0.5)
    points, values, noise = draw(150, 1)
    posterior = fill(GridPosterior(GRID, kernel, 0.2, 0.0), points, values, noise)
    mean, std = dense(kernel, GRID.points, points, values, noise, 0.2)
    assert np.abs(posterior.mean.ravel() - mean).max() < ROUND_OFF
    assert np.abs(posterior.std.ravel() - std).max() < ROUND_OFF


@pytest.mark.parametrize('name', ['rbf', 'matern32'])
@settings(max_examples=10, deadline=None)
@given(order=st.permutations(range(40)))
def test_any_order_of_the_same_measurements_gives_the_same_posterior(name, order):
    kernel = kernel_named(name, 0.6, 0.5)
    points, values, noise = draw(40, 2)
    order = np.array(order)
    one = fill(GridPosterior(GRID, kernel), points, values, noise)
    other = fill(GridPosterior(GRID, kernel), points[order], values[order], noise[order])
    assert np.abs(one.mean - other.mean).max() < ROUND_OFF
    assert np.abs(one.std - other.std).max() < ROUND_OFF


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.floats(0.0, 4.0), st.floats(0.0, 3.0), st.floats(-2.0, 2.0),
                          st.floats(1e-3, 2.0)), min_size=1, max_size=25))
def test_the_variance_never_exceeds_the_prior_and_never_grows(measurements):
    posterior = GridPosterior(GRID, RBF)
    before = posterior.std
    assert np.abs(before - RBF.deviation).max() < 1e-12
    for x, y, value, noise in measurements:
        posterior.condition(np.array([x, y]), value, noise)
        after = posterior.std
        assert (after <= before).all()
        assert np.isfinite(posterior.mean).all()
        before = after


def test_a_hundred_thousand_measurements_of_one_cell_leave_it_healthy():
    grid = Grid.over_workspace(0.0, 0.0, 1.2, 1.2, 0.1)
    posterior = GridPosterior(grid, RBF)
    count, noise, value = 100_000, 0.05, 0.4
    rng = np.random.default_rng(3)
    points = 0.6 + rng.uniform(-0.04, 0.04, (count, 2))
    fill(posterior, points, np.full(count, value), np.full(count, noise))
    centre = posterior.std[6, 6]
    # No less than what as many measurements of one number leave, and not much more.
    assert noise / math.sqrt(count) * 0.99 < centre < 10.0 * noise / math.sqrt(count)
    assert abs(posterior.mean[6, 6] - value) < 1e-3
    assert (posterior.std <= RBF.deviation).all() and np.isfinite(posterior.mean).all()
    # It still listens to new ground.
    before = posterior.std[0, 0]
    posterior.condition(np.array([0.0, 0.0]), 0.9, noise)
    assert posterior.std[0, 0] < min(before, 1.01 * noise)


def test_absurdly_exact_measurements_leave_it_healthy():
    posterior = GridPosterior(GRID, RBF)
    for turn in range(300):
        posterior.condition(np.array([2.0, 1.5 + 1e-3 * (turn % 7)]), 0.4, 1e-300)
    assert (posterior.std <= RBF.deviation).all() and np.isfinite(posterior.mean).all()
    assert abs(posterior.mean[15, 20] - 0.4) < 1e-3
    assert np.abs(posterior.mean).max() < 1.0


def test_repeated_measurements_of_a_matern_place_merge_without_bias():
    kernel = kernel_named('matern32', 0.6, 0.5)
    points, values, noise = draw(5, 4)
    rng = np.random.default_rng(4)
    turns = rng.integers(0, 5, 400)
    felt = rng.normal(values[turns], noise[turns])
    posterior = fill(GridPosterior(GRID, kernel, tolerance=0.0), points[turns], felt,
                     noise[turns])
    mean, std = dense(kernel, GRID.points, points[turns], felt, noise[turns])
    assert np.abs(posterior.mean.ravel() - mean).max() < ROUND_OFF
    assert np.abs(posterior.std.ravel() - std).max() < ROUND_OFF


def test_windows_agree_with_the_dense_process_within_a_tenth_of_its_deviation(monkeypatch):
    grid = Grid.over_workspace(0.0, 0.0, 8.0, 8.0, 0.1)
    posterior = small_tiles(monkeypatch, grid, RBF, 1e-8)
    points, _, noise = draw(400, 5, grid)
    rng = np.random.default_rng(5)
    values = np.sin(points[:, 0]) * np.cos(points[:, 1]) + rng.normal(0.0, noise)
    fill(posterior, points, values, noise)
    mean, std = dense(RBF, grid.points, points, values, noise)
    assert (np.abs(posterior.mean.ravel() - mean) <= 0.1 * std).all()
    assert np.abs(posterior.std.ravel() - std).max() < DEFAULT_ERROR


def test_smaller_tolerance_means_smaller_error():
    points, values, noise = draw(150, 6)
    mean, _ = dense(RBF, GRID.points, points, values, noise)
    errors = [np.abs(fill(GridPosterior(GRID, RBF, tolerance=tolerance), points, values,
                          noise).mean.ravel() - mean).max()
              for tolerance in (1e-3, 1e-5, 1e-7, 0.0)]
    assert errors == sorted(errors, reverse=True)


def test_a_measurement_changes_nothing_beyond_the_windows_it_reaches(monkeypatch):
    grid = Grid.over_workspace(0.0, 0.0, 20.0, 2.0, 0.1)
    posterior = small_tiles(monkeypatch, grid, RBF, 1e-8)
    posterior.condition(np.array([1.0, 1.0]), 0.7, 0.05)
    far = grid.x > 1.0 + posterior.tiling.margin + 12 * grid.resolution
    assert (posterior.mean[:, far] == 0.0).all()
    assert (posterior.std[:, far] == RBF.deviation).all()
    assert posterior.mean[10, 10] > 0.6


def test_a_window_is_rebuilt_from_its_records_to_the_last_bit():
    basis = RectangleBasis.spanning((4.0, 4.0), (np.array([2.0]), np.array([2.0])), 0.6, 1e-8)
    points, values, noise = draw(120, 7)
    lived, rebuilt = (SpectralWindow(basis, 0.5, (1, 1)) for _ in range(2))
    for (x, y), value, deviation in zip(points, values, noise, strict=True):
        lived.observe(x, y, value, deviation**2)
    rebuilt.restore(np.column_stack((points, values, noise**2)))
    for one, other in zip(lived.observe(1.5, 1.5, 0.3, 0.01),
                          rebuilt.observe(1.5, 1.5, 0.3, 0.01), strict=True):
        assert np.array_equal(one, other)


def test_windows_that_were_let_go_come_back_as_they_were(monkeypatch):
    grid = Grid.over_workspace(0.0, 0.0, 12.0, 12.0, 0.2)
    points, values, noise = draw(60, 8, grid)
    results = []
    for fewest in (1, 1000):
        monkeypatch.setattr('psane_mapping.window_store._FEWEST_RESIDENT', fewest)
        monkeypatch.setattr('psane_mapping.window_store._RESIDENT_BYTES', 0.0)
        posterior = small_tiles(monkeypatch, grid, RBF, 1e-6, cells=15)
        results.append(fill(posterior, points, values, noise))
        assert (posterior._windows.resident <= 1) == (fewest == 1)
    assert np.array_equal(results[0].mean, results[1].mean)
    assert np.array_equal(results[0].std, results[1].std)


def grow_and_fill(order, prior=0.1):
    grid = Grid.over_workspace(0.0, 0.0, 1.0, 1.0, 0.2)
    points, values, noise = draw(40, 13, Grid.over_workspace(-6.0, -3.0, 8.0, 5.0, 0.2))
    posterior = GridPosterior(grid, RBF, prior, 1e-6, grows=True)
    return fill(posterior, points[order], values[order], noise[order]), points


def test_a_map_that_grew_equals_one_that_was_large_from_the_start():
    posterior, points = grow_and_fill(np.arange(40))
    _, values, noise = draw(40, 13, Grid.over_workspace(-6.0, -3.0, 8.0, 5.0, 0.2))
    mean, std = dense(RBF, posterior.grid.points, points, values, noise, 0.1)
    assert posterior.grid.contains(points).all()
    assert (np.abs(posterior.mean.ravel() - mean) <= 0.1 * std).all()
    assert np.abs(posterior.std.ravel() - std).max() < 10 * DEFAULT_ERROR  # tolerance of 1e-6


@settings(max_examples=10, deadline=None)
@given(order=st.permutations(range(40)))
def test_a_map_grows_to_the_same_in_any_order(order):
    (one, _), (other, _) = grow_and_fill(np.arange(40)), grow_and_fill(np.array(order))
    assert one.grid.shape == other.grid.shape
    assert np.abs(one.mean - other.mean).max() < ROUND_OFF
    assert np.abs(one.std - other.std).max() < ROUND_OFF


def test_a_prior_function_is_asked_for_the_cells_that_a_map_grew_by():
    posterior = GridPosterior(Grid.over_workspace(0.0, 0.0, 1.0, 1.0, 0.1), RBF,
                              lambda grid: np.tile(0.01 * grid.x, (grid.rows, 1)), grows=True)
    posterior.condition(np.array([9.0, 0.5]), 0.09, 0.05)
    assert posterior.grid.columns > 90
    # The measurement agrees with the prior, so that the map is still the prior everywhere.
    assert np.abs(posterior.mean - 0.01 * posterior.grid.x).max() < 1e-9


def test_reset_forgets_everything():
    posterior = GridPosterior(GRID, RBF, 0.1)
    points, values, noise = draw(20, 9)
    first = fill(posterior, points, values, noise).mean
    posterior.reset()
    assert (posterior.mean == 0.1).all() and posterior.count == 0
    assert (fill(posterior, points, values, noise).mean == first).all()


def test_equal_runs_are_equal_to_the_last_bit():
    measurements = draw(60, 10)
    one, other = (fill(GridPosterior(GRID, RBF), *measurements) for _ in range(2))
    assert one.mean.tobytes() == other.mean.tobytes()
    assert one.std.tobytes() == other.std.tobytes()


def test_innovations_of_a_process_from_the_prior_are_standard_normal():
    points, _, noise = draw(300, 11)
    rng = np.random.default_rng(11)
    distance = np.linalg.norm(points[:, None] - points[None], axis=-1)
    covariance = 0.25 * RBF.correlation(distance) + np.diag(noise**2)
    values = np.linalg.cholesky(covariance) @ rng.normal(size=300)
    posterior = GridPosterior(GRID, RBF)
    ratios = np.array([value / deviation for value, deviation in (
        posterior.condition(*m) for m in zip(points, values, noise, strict=True))])
    # 300 independent standard normals: the mean square is 1 +- 0.08 (one sigma).
    assert 0.75 < (ratios**2).mean() < 1.25
    assert abs(ratios.mean()) < 0.25


def test_a_prior_map_shows_where_nothing_was_felt_and_is_corrected_where_it_was():
    prior = np.tile(0.2 + 0.1 * GRID.x, (GRID.rows, 1))
    posterior = GridPosterior(GRID, RBF, prior)
    assert (posterior.mean == prior).all()
    # A measurement that agrees with the (linear) prior map between cells changes nothing.
    posterior.condition(np.array([1.234, 1.517]), 0.2 + 0.1 * 1.234, 0.03)
    assert np.abs(posterior.mean - prior).max() < 1e-12
    posterior.condition(np.array([3.0, 1.5]), 0.9, 0.01)
    assert abs(posterior.mean[15, 30] - 0.9) < 0.01


def test_the_gradient_is_the_slope_of_the_mean():
    posterior = GridPosterior(GRID, RBF)
    points, _, _ = draw(400, 12)
    fill(posterior, points, 0.1 * points[:, 0] - 0.2 * points[:, 1], np.full(400, 0.01))
    assert np.allclose(posterior.gradient(np.array([2.0, 1.5])), (0.1, -0.2), atol=0.02)


@pytest.mark.parametrize('point, value, deviation', [
    ((math.nan, 1.0), 0.1, 0.1), ((1.0, math.inf), 0.1, 0.1), ((1.0, 1.0), math.nan, 0.1),
    ((1.0, 1.0), 0.1, 0.0), ((1.0, 1.0), 0.1, -0.1), ((1.0, 1.0), 0.1, math.inf),
    ((99.0, 1.0), 0.1, 0.1), ((1.0, -3.0), 0.1, 0.1), ((1.0, 1.0, 1.0), 0.1, 0.1)])
def test_a_bad_measurement_is_refused_and_changes_nothing(point, value, deviation):
    posterior = GridPosterior(GRID, RBF)
    posterior.condition(np.array([1.0, 1.0]), 0.4, 0.05)
    mean, std = posterior.mean, posterior.std
    with pytest.raises(ShapeError):
        posterior.condition(np.array(point), value, deviation)
    assert (posterior.mean == mean).all() and (posterior.std == std).all()


@pytest.mark.parametrize('tolerance', [-1e-9, 0.011, math.nan])
def test_a_tolerance_out_of_range_is_refused(tolerance):
    with pytest.raises(ParameterError, match='tolerance'):
        GridPosterior(GRID, RBF, tolerance=tolerance)


def test_an_unknown_kernel_is_refused_with_the_list():
    with pytest.raises(ParameterError, match='matern32'):
        kernel_named('cubic', 0.6, 0.5)


@pytest.mark.parametrize('name', sorted(KERNELS))
def test_kernels_fall_from_one_and_reach_their_tolerance(name):
    kernel = kernel_named(name, 0.6, 0.5)
    correlation = kernel.correlation(np.linspace(0.0, 6.0, 200))
    assert correlation[0] == 1.0 and (np.diff(correlation) < 0.0).all()
    reach = np.array(reach_of(kernel, 1e-6))
    assert math.isclose(float(kernel.correlation(reach)) ** 2, 1e-6, rel_tol=1e-6)
    assert math.isinf(reach_of(kernel, 0.0))


def test_the_basis_loses_less_variance_with_a_smaller_floor():
    cells = (np.linspace(0.0, 4.0, 41), np.linspace(0.0, 4.0, 41))
    losses = [np.abs(RectangleBasis.spanning((4.0, 4.0), cells, 0.6, floor)
                     .variance_left_out()).max() for floor in (1e-4, 1e-6, 1e-8, 0.0)]
    assert losses == sorted(losses, reverse=True)
    assert losses[-1] < 1e-12
