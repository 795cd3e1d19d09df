# SPDX-License-Identifier: Apache-2.0
"""The live view beside a demo: a process of its own, which may fail without ending the run."""

import contextlib
import os
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from psane_sim.processes import Processes, executable, use_private_graph

NAME = 'viewer'
STARTING, WRITING = 30.0, 60.0
"""Longest times that the viewer is waited for, until it serves and until its page is written
[s]."""


@contextlib.contextmanager
def live_view(port: int | None, out: Path,
              robot: str, robots: Sequence[str] = ('',)) -> Iterator[None]:
    """Serve the live view while the block runs, and leave `view.html` behind.

    Parameters
    ----------
    port : int or None
        0 for any that is free; None serves nothing.
    out : Path
        Folder for the page and the log.
    robot : str
        What the robots look like.
    robots : sequence of str
        Their namespaces.
    """
    if port is None:
        yield
        return
    use_private_graph()
    processes = Processes(out / 'logs')
    page = out / 'view.html'
    page.unlink(missing_ok=True)
    processes.start(NAME, [
        sys.executable, str(executable('psane_sim', NAME)), '--port', str(port),
        '--export', str(page.resolve()), '--robot', robot, '--robots', *robots])
    try:
        print(_first_words(processes, out / 'logs' / f'{NAME}.log'), flush=True)
        yield
    finally:
        _end(processes)
        if page.is_file():
            print(f'  recorded view         {page}')


def _end(processes: Processes) -> None:
    """Stop the viewer when it has written its page, or is given up."""
    deadline = time.monotonic() + WRITING
    if processes.death() is None:
        os.kill(processes.identity(NAME), signal.SIGINT)
    while processes.death() is None and time.monotonic() < deadline:
        time.sleep(0.1)
    processes.stop()


def _first_words(processes: Processes, log: Path) -> str:
    """Return what the viewer said when it was ready, or why it is not."""
    deadline = time.monotonic() + STARTING
    while time.monotonic() < deadline:
        said = log.read_text(errors='replace')
        if 'http://' in said:
            return next(line for line in said.splitlines() if 'http://' in line)
        death = processes.death()
        if death is not None:
            return f'psane demo: there is no live view: {death.in_words}'
        time.sleep(0.1)
    return f'psane demo: the live view is not up after {STARTING:g} s; see {log}'
