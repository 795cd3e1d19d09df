# SPDX-License-Identifier: Apache-2.0
"""Hyperparameters from a mission's samples."""

import math
import re

import numpy as np
import pytest
import yaml

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.errors import MapFileError, ShapeError
from psane_mapping.fit import main, measurements_of
from psane_mapping.hyperparameters import (
    Bounds,
    Measurements,
    Prior,
    fit,
    on_bound,
    score,
    split,
)
from psane_mapping.parameters import from_mapping
from psane_mapping.sample import TerrainSample, record_of
from psane_mapping.sample_file import header_of
from psane_mapping.sample_source import read_samples, write_table

NOISE = 0.05


def prior_named(name, lengthscale, deviation, mean):
    return Prior(kernel_name=name, lengthscale=lengthscale, deviation=deviation, mean=mean)


def ground(kernel, count=300, seed=0, size=8.0):
    """Draw measurements of ground from a prior."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, size, (count, 2))
    distance = np.linalg.norm(points[:, None] - points[None], axis=-1)
    covariance = kernel.deviation**2 * kernel.correlation(distance) + 1e-9 * np.eye(count)
    values = np.linalg.cholesky(covariance) @ rng.normal(size=count)
    return Measurements(points=points, values=values + rng.normal(0.0, NOISE, count),
                        deviations=np.full(count, NOISE))


def mission(count=120, lengthscale=1.0, seed=3):
    drawn = ground(prior_named('rbf', lengthscale, 0.3, 0.0).kernel, count, seed, 5.0)
    return [TerrainSample(time=float(number), point=point, leg=number % 6,
                          strength=math.exp(-1.0 + 2.0 * value), log_strength_deviation=0.15,
                          slip=0.4 + value, slip_deviation=NOISE)
            for number, (point, value) in enumerate(zip(drawn.points, drawn.values, strict=True))]


@pytest.mark.parametrize('name', ['rbf', 'matern32', 'matern52'])
def test_the_truth_is_found_from_draws_of_it(name):
    truth = prior_named(name, 0.9, 0.4, 0.0)
    found = fit(ground(truth.kernel), prior_named(name, 0.3, 1.0, 0.0), Bounds(), restarts=1)
    # 300 draws over 80 correlation areas: the estimates scatter by a few per cent and about 15 %.
    assert 0.7 < found.lengthscale / 0.9 < 1.4
    assert 0.65 < found.deviation / 0.4 < 1.5
    assert found.kernel_name == name


def test_what_was_fitted_predicts_held_out_measurements_better():
    truth = prior_named('rbf', 1.2, 0.4, 0.0)
    wrong = prior_named('rbf', 0.3, 2.0, 0.0)
    every = ground(truth.kernel)
    fitted_to, held_out = split(300, 0.25, 0)
    known, unknown = every.where(fitted_to), every.where(held_out)
    found = fit(known, wrong, Bounds(), restarts=1)
    before, after, best = (score(prior, known, unknown) for prior in (wrong, found, truth))
    assert after.log_density > before.log_density + 0.3
    assert after.rmse < before.rmse
    assert after.log_density > best.log_density - 0.05
    assert 0.7 < after.normalised_rms < 1.4


def test_the_predictive_density_is_that_of_the_dense_process():
    prior = prior_named('rbf', 0.7, 0.4, 0.3)
    every = ground(prior.kernel, 30)
    known, unknown = every.where(np.arange(29)), every.where(np.array([29]))
    distance = np.linalg.norm(every.points[:, None] - every.points[None], axis=-1)
    joint = 0.16 * prior.kernel.correlation(distance) + NOISE**2 * np.eye(30)
    gain = np.linalg.solve(joint[:29, :29], joint[:29, 29])
    mean = 0.3 + gain @ (known.values - 0.3)
    variance = joint[29, 29] - gain @ joint[:29, 29]
    expected = -0.5 * ((unknown.values[0] - mean)**2 / variance
                       + math.log(2.0 * math.pi * variance))
    assert math.isclose(score(prior, known, unknown).log_density, expected, rel_tol=1e-6)


def test_bounds_hold_and_an_optimum_on_one_is_named():
    bounds = Bounds(lengthscale=(0.1, 0.4), deviation=(0.1, 1.0))
    found = fit(ground(prior_named('rbf', 1.5, 0.4, 0.0).kernel),
                prior_named('rbf', 0.3, 0.5, 0.0), bounds, restarts=1)
    assert found.lengthscale == pytest.approx(0.4)
    assert on_bound(found, bounds) == ['lengthscale']


def test_held_out_measurements_are_whole_stretches_of_the_walk():
    fitted_to, held_out = split(237, 0.2, 1)
    assert (fitted_to ^ held_out).all() and 20 <= held_out.sum() <= 60
    changes = np.flatnonzero(np.diff(held_out)) + 1
    assert (changes % 10 == 0).all()


def test_too_few_samples_are_refused():
    with pytest.raises(ShapeError, match='at least 20'):
        fit(ground(prior_named('rbf', 1.0, 0.4, 0.0).kernel, 19),
            prior_named('rbf', 1.0, 0.4, 0.0), Bounds())


def test_a_table_gives_back_what_was_written(tmp_path):
    samples = mission(25)
    write_table(tmp_path / 'a.csv', samples)
    back = read_samples(tmp_path / 'a.csv')
    assert [record_of(sample) for sample in back] == [record_of(sample) for sample in samples]


@pytest.mark.parametrize('text, words', [
    ('time,x\n1,2\n', 'lacks the columns'),
    ('time,x,y,leg,strength,log_strength_deviation,slip,slip_deviation\n1,2,3,0,oops,1,1,1\n',
     'line 2.*oops'),
    ('time,x,y,leg,strength,log_strength_deviation,slip,slip_deviation\n1,2,3,0,nan,1,1,1\n',
     'line 2.*strength = nan'),
    ('time,x,y,leg,strength,log_strength_deviation,slip,slip_deviation\n1,2,3\n', 'line 2')])
def test_a_bad_table_is_refused_with_its_line(tmp_path, text, words):
    (tmp_path / 'a.csv').write_text(text)
    with pytest.raises(MapFileError, match=words):
        read_samples(tmp_path / 'a.csv')


@pytest.mark.parametrize('suffix', ['.csv', '.psane', '.map'])
def test_the_command_writes_parameters_that_the_mapper_takes(tmp_path, capsys, suffix):
    samples = mission()
    source = tmp_path / f'mission{suffix}'
    if suffix == '.csv':
        write_table(source, samples)
    else:
        source.write_bytes(header_of({}) + b''.join(record_of(sample) for sample in samples))
    main([str(source), '--out', str(tmp_path / 'fitted.yaml'), '--restarts', '0'])
    printed = capsys.readouterr().out
    values = yaml.safe_load((tmp_path / 'fitted.yaml').read_text())['/**']['ros__parameters']
    config = from_mapping(MappingConfiguration, values)
    assert 0.7 < config.lengthscale < 1.5
    densities = re.findall(r'log density +(\S+) +(\S+)', printed)
    assert len(densities) == 2
    assert all(float(after) > float(before) for before, after in densities)


def test_the_command_says_what_is_wrong_with_a_file(tmp_path, capsys):
    for path in (tmp_path / 'none.csv', tmp_path / 'a.bag', tmp_path / 'none.psane'):
        with pytest.raises(SystemExit) as ended:
            main([str(path)])
        assert ended.value.code == 2
        assert str(path) in capsys.readouterr().err


def test_log_strength_is_fitted_on_its_logarithm():
    samples = mission(30)
    log_strength = measurements_of(samples, 'log-strength')
    assert np.allclose(np.exp(log_strength.values), [sample.strength for sample in samples])
