# SPDX-License-Identifier: Apache-2.0
"""The linters pass."""

import subprocess
import sys

from source_tree import PACKAGES, ROOT, core_modules, modules_of


def run(*command):
    done = subprocess.run([sys.executable, '-m', *command], cwd=ROOT, capture_output=True,
                          text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def test_ruff_has_nothing_to_say():
    status, said = run('ruff', 'check', 'src', 'tests', 'examples', 'docker')
    assert status == 0, said


def test_types_of_the_core_are_consistent():
    status, said = run('mypy', *(str(path.relative_to(ROOT)) for path in core_modules()))
    assert status == 0, said


def test_files_stay_small_enough_to_hold_one_idea():
    limit = 300  # the house style asks for a split at about 250
    long = {path.name: count for package in PACKAGES for path in modules_of(package)
            if (count := len(path.read_text().splitlines())) > limit}
    assert not long
