# SPDX-License-Identifier: Apache-2.0
"""An installed executable as a process that is always stopped again."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

PATIENCE = 240.0
"""Longest wait for what surely comes: a busy machine is slow, not wrong [s]."""


class NodeProcess:
    """What `ros2 run PACKAGE EXECUTABLE` starts, without the `ros2` command.

    Parameters
    ----------
    install : Path
        The workspace's install folder.
    package, executable : str
        Its name in ``lib/<package>``.
    arguments : sequence of str
        Passed on, for instance ``--ros-args -p name:=value``.
    log : Path
        Takes what the process prints.
    """

    def __init__(self, install: Path, package: str, executable: str, arguments: Sequence[str],
                 log: Path) -> None:
        program = install / package / 'lib' / package / executable
        if not program.is_file():
            raise FileNotFoundError(f'{program} is not there; build it with ./psane build')
        self.log = log
        with log.open('wb') as output:
            # A group of its own, so that whatever it starts is stopped with it.
            self._process = subprocess.Popen(
                [sys.executable, str(program), *arguments], stdin=subprocess.DEVNULL,
                stdout=output, stderr=subprocess.STDOUT, start_new_session=True,
                env={**os.environ, 'PYTHONUNBUFFERED': '1'})

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def is_running(self) -> bool:
        """Whether the process has not ended yet."""
        return self._process.poll() is None

    @property
    def output(self) -> str:
        """What it has printed so far."""
        return self.log.read_text(errors='replace')

    def send(self, which: signal.Signals) -> None:
        """Send a signal to the process alone."""
        if self.is_running:
            self._process.send_signal(which)

    def wait(self, timeout: float = PATIENCE) -> int:
        """Wait for the end [s] and return the exit status."""
        return self._process.wait(timeout)

    def wait_for_output(self, text: str, timeout: float = PATIENCE) -> None:
        """Wait until it has printed a text.

        Raises
        ------
        TimeoutError
            With what it did print, when it ends or the time [s] is over before.
        """
        end = time.monotonic() + timeout
        while text not in self.output:
            if not self.is_running or time.monotonic() > end:
                raise TimeoutError(f'{text!r} is not in what it printed:\n{self.output}')
            time.sleep(0.02)

    def stop(self, patience: float = 5.0) -> int:
        """Stop it by SIGINT, then SIGTERM, then SIGKILL, and return the exit status.

        Parameters
        ----------
        patience : float
            Time to react to each of the first two [s].
        """
        for which in (signal.SIGINT, signal.SIGTERM):
            self.send(which)
            try:
                self._process.wait(patience)
                break
            except subprocess.TimeoutExpired:
                continue
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        return self._process.wait()
