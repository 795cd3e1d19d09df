# SPDX-License-Identifier: Apache-2.0
"""`psane run psane_sim record_test_bags`: record anew the bags that the tests replay."""

import argparse
import shutil
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from psane_mapping.errors import BagError
from psane_sim.errors import GraphError

FOLDER = Path('tests/data/bags')
NAMES = ('env1', 'faults')


def main(arguments: Sequence[str] | None = None) -> None:
    """Record, and end the program with status 0, or 2 when that cannot be done."""
    parser = argparse.ArgumentParser(
        prog='psane run psane_sim record_test_bags',
        description='Let the real mapper, planner and controller lead a simulated robot, step by '
        'step, and record what they are told and say. Needed when what they say has changed and '
        'is meant to.')
    parser.add_argument('--only', choices=NAMES, help='one of them (default: all)')
    parser.add_argument('--out', type=Path, default=FOLDER, metavar='DIR',
                        help=f'folder of the bags (default {FOLDER})')
    options = parser.parse_args(arguments)
    # Only here, so that a bad argument is answered at once.
    from psane_sim.bags.ros_bag_scenarios import SCENARIOS, record
    from psane_sim.processes import use_private_graph
    use_private_graph()
    try:
        for name in (options.only,) if options.only else NAMES:
            began = time.monotonic()
            with tempfile.TemporaryDirectory() as folder:
                count = record(SCENARIOS[name], Path(folder) / name, Path(folder) / 'logs')
                shutil.rmtree(options.out / name, ignore_errors=True)
                options.out.mkdir(parents=True, exist_ok=True)
                shutil.copytree(Path(folder) / name, options.out / name)
            size = sum(path.stat().st_size for path in (options.out / name).iterdir())
            print(f'{options.out / name}: {count} messages, {1e-6 * size:.2f} MB, in '
                  f'{time.monotonic() - began:.0f} s', flush=True)
    except (BagError, GraphError, OSError) as error:
        print(f'psane record_test_bags: {error}', file=sys.stderr)
        sys.exit(2)
