# SPDX-License-Identifier: Apache-2.0
"""Starts nodes as processes, watches over them, and always stops them again."""

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_prefix

from psane_sim.errors import GraphError

GRACE = ((signal.SIGINT, 4.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, 5.0))
"""Signals by which a process is stopped, and how long each is waited for [s]."""


@dataclass(frozen=True)
class Death:
    """A process that ended although nobody had asked it to."""

    name: str
    status: int
    log: Path

    @property
    def in_words(self) -> str:
        """Who died, of what, and its last words."""
        if self.status < 0:
            how = f'was killed by {signal.Signals(-self.status).name}'
        else:
            how = f'ended by itself with status {self.status}'
        lines = self.log.read_text(errors='replace').strip().splitlines()[-5:]
        last = '\n    '.join(lines) if lines else 'it had said nothing'
        return f'{self.name} {how}; the end of {self.log}:\n    {last}'


def executable(package: str, name: str) -> Path:
    """Return the path of an installed executable, the one that `ros2 run` would start.

    Raises
    ------
    GraphError
        When the package or the executable is not installed.
    """
    try:
        path = Path(get_package_prefix(package)) / 'lib' / package / name
    except PackageNotFoundError as error:
        raise GraphError(f'package {package} is not installed: build the workspace '
                         '(./psane build) and source install/setup.bash') from error
    if not path.is_file():
        raise GraphError(f'{path} does not exist: build the workspace (./psane build)')
    return path


def use_private_graph() -> None:
    """Keep the graph on this machine, on a domain of its own unless the user named one."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ.pop('ROS_LOCALHOST_ONLY', None)
    os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))


def ros_arguments(parameters: Mapping[str, object]) -> list[str]:
    """Return the command line that sets parameters of a node."""
    arguments = ['--ros-args']
    for name, value in parameters.items():
        shown = str(value).lower() if isinstance(value, bool) else str(value)
        arguments += ['-p', f'{name}:={shown}']
    return arguments


class Processes:
    """The processes of one run, each with a log file.

    Parameters
    ----------
    logs : Path
        Folder of the log files.
    """

    def __init__(self, logs: Path) -> None:
        self._logs = logs
        logs.mkdir(parents=True, exist_ok=True)
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        # A process whose parent is killed without a chance to clean up is told to end.
        setpriv = shutil.which('setpriv')
        self._guard = [setpriv, '--pdeathsig', 'TERM'] if setpriv else []

    def start(self, name: str, command: Sequence[str]) -> None:
        """Start a process in a session of its own, so that Ctrl-C reaches it through us alone."""
        with self._log_of(name).open('wb') as log:
            self._running[name] = subprocess.Popen(
                [*self._guard, *command], stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                start_new_session=True)

    def _log_of(self, name: str) -> Path:
        return self._logs / f'{name}.log'

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the processes that were started here and not stopped."""
        return tuple(self._running)

    def identity(self, name: str) -> int:
        """Return the process id of a process that was started here."""
        return self._running[name].pid

    def death(self) -> Death | None:
        """Return a process that ended although nobody had asked it to, if there is one."""
        for name, process in self._running.items():
            status = process.poll()
            if status is not None:
                return Death(name, status, self._log_of(name))
        return None

    def stop(self, *names: str) -> None:
        """Stop some processes, or all: politely first, by force in the end."""
        chosen = {name: self._running.pop(name) for name in names or tuple(self._running)}
        for number, patience in GRACE:
            alive = [process for process in chosen.values() if process.poll() is None]
            for process in alive:
                process.send_signal(number)
            deadline = time.monotonic() + patience
            for process in alive:
                try:
                    process.wait(max(deadline - time.monotonic(), 0.01))
                except subprocess.TimeoutExpired:
                    continue
