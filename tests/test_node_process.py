# SPDX-License-Identifier: Apache-2.0
"""Whatever a test starts is stopped again, however it behaves."""

import signal
import textwrap
import time
from pathlib import Path

import pytest
from node_process import PATIENCE, NodeProcess

OBEDIENT = """
    import time
    print('ready')
    try:
        time.sleep(60)
    except KeyboardInterrupt:
        print('bye')
"""
DEAF_TO_INTERRUPTS = """
    import signal, time
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    print('ready')
    time.sleep(60)
"""
DEAF = """
    import signal, time
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    print('ready')
    time.sleep(60)
"""
PARENT = """
    import subprocess, sys, time
    child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'])
    print('ready', child.pid)
    time.sleep(60)
"""


@pytest.fixture
def start(tmp_path):
    started = []

    def begin(program):
        path = tmp_path / 'pack' / 'lib' / 'pack' / 'program'
        path.parent.mkdir(parents=True)
        path.write_text(textwrap.dedent(program))
        started.append(NodeProcess(tmp_path, 'pack', 'program', (), tmp_path / 'log'))
        started[-1].wait_for_output('ready')
        return started[-1]

    yield begin
    for process in started:
        process.stop(0.1)


@pytest.mark.parametrize(('program', 'status'), [
    (OBEDIENT, 0), (DEAF_TO_INTERRUPTS, -signal.SIGTERM), (DEAF, -signal.SIGKILL)])
def test_a_process_is_stopped_by_the_mildest_signal_that_works(start, program, status):
    process = start(program)
    assert process.is_running
    assert process.stop(2.0) == status
    assert not process.is_running


def is_alive(pid):
    """Tell whether a process is there and not merely waiting to be buried."""
    try:
        state = Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state not in ('Z', 'X')


def test_what_a_process_started_ends_with_it(start):
    process = start(PARENT)
    child = int(process.output.split()[1])
    assert is_alive(child)
    process.stop(2.0)
    end = time.monotonic() + PATIENCE  # the kernel needs a moment after SIGKILL
    while is_alive(child) and time.monotonic() < end:
        time.sleep(0.01)
    assert not is_alive(child)


def test_a_text_that_never_comes_is_reported_with_what_came(start):
    process = start("print('ready'); print('wrong port')")
    process.wait()
    with pytest.raises(TimeoutError, match='wrong port'):
        process.wait_for_output('listening', 10.0)


def test_an_executable_that_is_not_installed_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match='psane build'):
        NodeProcess(tmp_path, 'pack', 'missing', (), tmp_path / 'log')
