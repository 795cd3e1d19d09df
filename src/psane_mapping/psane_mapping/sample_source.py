# SPDX-License-Identifier: Apache-2.0
"""Where the samples of a mission come from: a journal, a saved map, a table or a bag.

A further kind of file is one more function in `READERS`.
"""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np

from psane_mapping.bag_source import read_bag
from psane_mapping.errors import MapFileError, MappingError
from psane_mapping.sample import TerrainSample
from psane_mapping.sample_file import read

COLUMNS = ('time', 'x', 'y', 'leg', 'strength', 'log_strength_deviation', 'slip',
           'slip_deviation')


def read_samples(path: Path) -> list[TerrainSample]:
    """Return the samples of a file, of the kind that its name ends in; a folder is a bag.

    Raises
    ------
    MapFileError
        For an unknown kind, or a file that cannot be read.
    BagError
        For a bag that cannot be read.
    """
    reader = read_bag if path.is_dir() else READERS.get(path.suffix)
    if reader is None:
        raise MapFileError(f"cannot read '{path}'; expected a name that ends in one of "
                           f'{sorted(READERS)}')
    return reader(path)


def write_table(path: Path, samples: list[TerrainSample]) -> None:
    """Write samples as CSV, with all digits.

    Raises
    ------
    MapFileError
        When the file cannot be written.
    """
    try:
        with path.open('w', newline='', encoding='utf-8') as file:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            for sample in samples:
                x, y = sample.point.tolist()
                writer.writerow((repr(sample.time), repr(x), repr(y), sample.leg,
                                 *(repr(float(getattr(sample, name))) for name in COLUMNS[4:])))
    except OSError as error:
        raise MapFileError(f'cannot write {path}: {error.strerror}') from error


def _read_table(path: Path) -> list[TerrainSample]:
    try:
        with path.open(newline='', encoding='utf-8') as file:
            reader = csv.DictReader(file)
            missing = set(COLUMNS) - set(reader.fieldnames or ())
            if missing:
                raise MapFileError(f'{path} lacks the columns {sorted(missing)}; '
                                   f'expected {list(COLUMNS)}')
            return [_sample(row, f'{path}, line {reader.line_num}') for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise MapFileError(f'cannot read {path}: {error}') from error


def _sample(row: dict[str, str], place: str) -> TerrainSample:
    try:
        return TerrainSample(
            time=float(row['time']), point=np.array([float(row['x']), float(row['y'])]),
            leg=int(row['leg']), **{name: float(row[name]) for name in COLUMNS[4:]})
    except (ValueError, TypeError, MappingError) as error:
        raise MapFileError(f'{place}: {error}') from error


def _read_records(path: Path) -> list[TerrainSample]:
    return list(read(path).samples)


READERS: dict[str, Callable[[Path], list[TerrainSample]]] = {
    '.csv': _read_table, '.psane': _read_records, '.map': _read_records, '.mcap': read_bag}
"""How a file is read, by the end of its name."""
