# SPDX-License-Identifier: Apache-2.0
"""Standard output and standard error belong to the program, not to the physics engine."""

import subprocess
import sys

import pytest
from source_tree import all_modules, imports_of

QUIET = 'quiet_pybullet.py'


def output_of(program):
    done = subprocess.run([sys.executable, '-c', f'import sys; sys.path[:] = {sys.path!r}\n'
                           + program], capture_output=True, text=True, check=True)
    return done.stdout, done.stderr


def test_the_engine_announces_itself_when_nobody_silences_it():
    # Else the next test could not fail.
    assert 'pybullet' in ''.join(output_of('import pybullet'))


def test_nothing_but_what_the_program_prints_is_on_its_streams():
    said = output_of('print("before")\nfrom psane_sim.robot import engine\nprint("{}")')
    assert said == ('before\n{}\n', '')


@pytest.mark.parametrize('stream', [1, 2])
def test_a_closed_stream_does_no_harm(stream):
    output_of(f'import os\nos.close({stream})\n'
              'from psane_sim.robot.quiet_pybullet import pybullet\n'
              'pybullet.connect(pybullet.DIRECT)')


@pytest.mark.parametrize('path', [p for p in all_modules() if p.name != QUIET],
                         ids=lambda path: path.name)
def test_every_other_module_gets_the_engine_from_the_quiet_place(path):
    assert 'pybullet' not in imports_of(path)
