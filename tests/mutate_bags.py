# SPDX-License-Identifier: Apache-2.0
"""Break a sign, a unit or a quality of service on purpose, and see whether the bags notice.

    ./psane shell python tests/mutate_bags.py [--only NAME ...]

Works on a copy of the sources in a temporary folder; prints a table. Exit status 1 when a mutant
goes unnoticed, or when the tests fail without one.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ('psane_mapping', 'psane_planner', 'psane_reactive', 'psane_sim')
TEST, BAG = 'tests/test_bag_integration.py', 'env1'


class Mutant(NamedTuple):
    """A change of one place: file below src, what is there, what comes instead."""

    name: str
    kind: str
    path: str
    old: str
    new: str


CONVERSIONS = 'psane_mapping/psane_mapping/conversions.py'
QUALITIES = 'psane_mapping/psane_mapping/quality_of_service.py'
LATCHED = '                     reliability=ReliabilityPolicy.{},\n' \
          '                     durability=DurabilityPolicy.{})\n'
BEST = 'BEST_EFFORT)\n"""How odometry'

MUTANTS = (
    Mutant('contact point y', 'sign', CONVERSIONS,
           'message.point.y]),\n            point_dev',
           '-message.point.y]),\n            point_dev'),
    Mutant('heading of odometry', 'sign', CONVERSIONS, '2.0 * (w * z + x * y)',
           '-2.0 * (w * z + x * y)'),
    Mutant('commanded yaw rate', 'sign', 'psane_reactive/psane_reactive/conversions.py',
           'float(command.angular)', '-float(command.angular)'),
    Mutant('contact forces in kN', 'unit', CONVERSIONS,
           'columns[name] = np.column_stack(arrays)',
           "columns[name] = np.column_stack(arrays) * (1e-3 if name == 'measured' else 1.0)"),
    Mutant('stamps in microseconds', 'unit', CONVERSIONS, '1e-9 * float(stamp.nanosec)',
           '1e-6 * float(stamp.nanosec)'),
    Mutant('published slip read as a share of 1000', 'unit',
           'psane_mapping/psane_mapping/map_cells.py', 'encoding.decode_slip_mean(mean), encoding',
           '0.1 * encoding.decode_slip_mean(mean), encoding'),
    Mutant('commanded yaw rate in degrees', 'unit',
           'psane_reactive/psane_reactive/conversions.py', 'float(command.angular)',
           '57.3 * float(command.angular)'),
    Mutant('latched topics volatile', 'QoS', QUALITIES,
           LATCHED.format('RELIABLE', 'TRANSIENT_LOCAL'), LATCHED.format('RELIABLE', 'VOLATILE')),
    Mutant('latched topics best effort', 'QoS', QUALITIES,
           LATCHED.format('RELIABLE', 'TRANSIENT_LOCAL'),
           LATCHED.format('BEST_EFFORT', 'TRANSIENT_LOCAL')),
    Mutant('odometry asked for as latched', 'QoS', QUALITIES, BEST,
           BEST.replace(')\n', ',\n' + 28 * ' ' + 'durability=DurabilityPolicy.TRANSIENT_LOCAL)\n')
           ))


def copied(folder: Path) -> Path:
    """Copy what the tests need; what was compiled comes along, with its times."""
    for name in ('src', 'tests'):
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy(ROOT / 'pyproject.toml', folder)
    return folder


def tests_pass(folder: Path) -> tuple[bool, str]:
    """Run the tests of one bag on a copy; return whether they pass, and the first that does not.

    The nodes that the tests start import what comes first in the path, which is the copy.
    """
    paths = [str(folder / 'src' / package) for package in PACKAGES]
    environment = {**os.environ, 'NUMBA_CACHE_DIR': str(folder / 'numba'),
                   'PYTHONPATH': os.pathsep.join([*paths, os.environ.get('PYTHONPATH', '')])}
    done = subprocess.run(
        [sys.executable, '-m', 'pytest', '-n', '0', '-q', '-x', '-p', 'no:cacheprovider', TEST,
         '-k', BAG], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return True, ''
    found = re.search(r'^(?:FAILED|ERROR) \S*?::(\w+)(?:.*? - (.*))?$', done.stdout, re.M)
    if found is None:
        raise RuntimeError(f'the tests did not run:\n{done.stdout[-2000:]}{done.stderr[-2000:]}')
    words = found[1].removeprefix('test_').replace('_', ' ')
    return False, f'{words}: {found[2]}' if 'GraphError' in (found[2] or '') else words


def main() -> None:
    """Try the mutants, print the table, and end with a status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--only', nargs='+', metavar='NAME', help='only these mutants')
    options = parser.parse_args()
    chosen = [mutant for mutant in MUTANTS if not options.only or mutant.name in options.only]
    unnoticed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = copied(Path(name))
        passed, failure = tests_pass(folder)
        if not passed:
            sys.exit(f'the tests fail without any mutant: {failure}')
        print('| broken on purpose | kind | noticed by | s |\n|---|---|---|---|', flush=True)
        for mutant in chosen:
            path = folder / 'src' / mutant.path
            text, times = path.read_text(), path.stat()
            if text.count(mutant.old) != 1:
                sys.exit(f'{mutant.name}: {mutant.old!r} is {text.count(mutant.old)} times in '
                         f'{mutant.path}, expected once')
            path.write_text(text.replace(mutant.old, mutant.new))
            began = time.monotonic()
            passed, failure = tests_pass(folder)
            path.write_text(text)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
            unnoticed += passed
            print(f'| {mutant.name} | {mutant.kind} | {"NOTHING" if passed else failure} | '
                  f'{time.monotonic() - began:.0f} |', flush=True)
    sys.exit(1 if unnoticed else 0)


if __name__ == '__main__':
    main()
