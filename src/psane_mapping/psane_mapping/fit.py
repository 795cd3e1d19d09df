# SPDX-License-Identifier: Apache-2.0
"""Fit the map's hyperparameters to a mission: `psane run psane_mapping fit JOURNAL_OR_BAG`."""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.errors import MappingError
from psane_mapping.hyperparameters import (
    Bounds,
    Measurements,
    Prior,
    Score,
    fit,
    on_bound,
    score,
    split,
)
from psane_mapping.kernels import KERNELS
from psane_mapping.sample import TerrainSample
from psane_mapping.sample_source import READERS, read_samples, write_table

FIELDS = {'slip': ('slip_prior_mean', 'slip_prior_deviation'),
          'log-strength': ('log_strength_prior_mean', 'log_strength_prior_deviation')}


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """One quantity before and after, on the same held-out contacts."""

    before: Prior
    after: Prior
    score_before: Score
    score_after: Score


def measurements_of(samples: Sequence[TerrainSample], quantity: str) -> Measurements:
    """Return the values of a quantity in `FIELDS`."""
    if quantity == 'slip':
        pairs = [(sample.slip, sample.slip_deviation) for sample in samples]
    else:
        pairs = [(np.log(sample.strength), sample.log_strength_deviation) for sample in samples]
    values = np.array(pairs).reshape(-1, 2)
    return Measurements(points=np.array([sample.point for sample in samples]).reshape(-1, 2),
                        values=values[:, 0], deviations=values[:, 1])


def compare(samples: Sequence[TerrainSample], before: Prior, quantity: str,
            options: argparse.Namespace) -> Comparison:
    """Fit to a part of the samples and try both priors on the rest."""
    every = measurements_of(samples, quantity)
    fitted_to, held_out = split(len(samples), options.hold_out, options.seed)
    known, unknown = every.where(fitted_to), every.where(held_out)
    after = fit(known, before, bounds_of(options), options.restarts, options.most, options.seed)
    return Comparison(before=before, after=after, score_before=score(before, known, unknown),
                      score_after=score(after, known, unknown))


def bounds_of(options: argparse.Namespace) -> Bounds:
    """Return the ranges that the user asked for."""
    return Bounds(lengthscale=tuple(options.lengthscale_bounds),
                  deviation=tuple(options.deviation_bounds))


def parameters_of(found: dict[str, Comparison], kernel: str) -> dict[str, object]:
    """Return the node's parameters. Both maps have one lengthscale: the shorter one is safer."""
    lengthscale = min(comparison.after.lengthscale for comparison in found.values())
    values: dict[str, object] = {'kernel': kernel, 'lengthscale': round(lengthscale, 4)}
    for quantity, comparison in found.items():
        values[FIELDS[quantity][1]] = round(comparison.after.deviation, 4)
    # What cannot be published at the default step gets a step that it can.
    defaults = MappingConfiguration()
    for step, deviation in (('std_scale', 'slip_prior_deviation'),
                            ('log_std_scale', 'log_strength_prior_deviation')):
        largest = float(str(values.get(deviation, 0.0)))
        if largest > 100.0 * getattr(defaults, step):
            values[step] = round(largest / 100.0 + 1e-5, 5)
    return values


def yaml_of(values: dict[str, object]) -> str:
    """Return parameters as a file that a node takes with ``--params-file``."""
    lines = ['/**:', '  ros__parameters:']
    lines += [f'    {name}: {value}' for name, value in values.items()]
    return '\n'.join(lines) + '\n'


def show(quantity: str, found: Comparison, bounds: Bounds) -> None:
    """Print one quantity before and after."""
    print(f'{quantity:14s}{"before":>12s}{"after":>12s}')
    for word, one, other in (
            ('lengthscale [m]', found.before.lengthscale, found.after.lengthscale),
            ('deviation', found.before.deviation, found.after.deviation),
            ('held out: log density', found.score_before.log_density,
             found.score_after.log_density),
            ('held out: rmse', found.score_before.rmse, found.score_after.rmse),
            ('held out: normalised rms', found.score_before.normalised_rms,
             found.score_after.normalised_rms)):
        print(f'  {word:26s}{one:10.4f}{other:12.4f}')
    for name in on_bound(found.after, bounds):
        print(f'  {name} ended at an end of its range: widen it, or gather more contacts')


def parser() -> argparse.ArgumentParser:
    """Return what the command understands."""
    config = MappingConfiguration()
    made = argparse.ArgumentParser(prog='fit', description=__doc__)
    made.add_argument('samples', type=Path, help='the folder of a bag, or a file that ends in '
                      f'one of {sorted(READERS)}')
    made.add_argument('--out', type=Path, help='YAML to write (default: none)')
    made.add_argument('--table', type=Path, help='write the samples as CSV, too')
    made.add_argument('--kernel', choices=sorted(KERNELS), default=config.kernel)
    made.add_argument('--hold-out', type=float, default=0.2, metavar='SHARE')
    made.add_argument('--restarts', type=int, default=4)
    made.add_argument('--most', type=int, default=800, help='most contacts to fit to')
    made.add_argument('--seed', type=int, default=0)
    made.add_argument('--lengthscale-bounds', type=float, nargs=2, metavar=('LOW', 'HIGH'),
                      default=Bounds().lengthscale)
    made.add_argument('--deviation-bounds', type=float, nargs=2, metavar=('LOW', 'HIGH'),
                      default=Bounds().deviation)
    return made


def run(options: argparse.Namespace) -> None:
    """Fit, print and write.

    Raises
    ------
    MappingError
        For a file that cannot be read or written, or too few samples.
    """
    config = MappingConfiguration()
    samples = read_samples(options.samples)
    if options.table is not None:
        write_table(options.table, samples)
    found = {}
    for quantity, (mean, deviation) in FIELDS.items():
        before = Prior(kernel_name=options.kernel, lengthscale=config.lengthscale,
                       deviation=getattr(config, deviation), mean=getattr(config, mean))
        found[quantity] = compare(samples, before, quantity, options)
    print(f'{len(samples)} contacts, {options.hold_out:.0%} of them held out')
    for quantity, comparison in found.items():
        show(quantity, comparison, bounds_of(options))
    text = yaml_of(parameters_of(found, options.kernel))
    if options.out is None:
        print(text, end='')
        return
    options.out.write_text(text, encoding='utf-8')
    print(f'wrote {options.out}')


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command; what goes wrong is said in a sentence, with status 2."""
    options = parser().parse_args(arguments)
    try:
        if not 0.0 < options.hold_out < 1.0:
            raise MappingError(f'--hold-out = {options.hold_out}, expected a share in (0, 1)')
        for low, high in (options.lengthscale_bounds, options.deviation_bounds):
            if not 0.0 < low < high:
                raise MappingError(f'bounds {low} {high}, expected 0 < low < high')
        run(options)
    except (MappingError, OSError) as error:
        print(f'psane: {error}', file=sys.stderr)
        sys.exit(2)


if __name__ == '__main__':
    main()
