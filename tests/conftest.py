# SPDX-License-Identifier: Apache-2.0
"""Keeps every test's graph to this machine and this run, and starts nodes as processes."""

import os
import random
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent

# Before any import of rclpy: domain ids 1..101 use ports that Linux does not hand out to others.
os.environ['ROS_DOMAIN_ID'] = str(random.SystemRandom().randint(1, 101))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ.setdefault('OMP_NUM_THREADS', '1')
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
os.environ.setdefault('MPLBACKEND', 'Agg')
# A busy machine may take long over one example; that says nothing about the law.
settings.register_profile('untimed', deadline=None)
settings.load_profile('untimed')
for _package in ('psane_mapping', 'psane_planner', 'psane_reactive', 'psane_sim'):
    sys.path.insert(0, str(ROOT / 'src' / _package))
sys.path.insert(0, str(ROOT / 'tests'))

from graph_probe import Probe  # noqa: E402  (found through the path set above)
from node_process import NodeProcess  # noqa: E402


@pytest.fixture
def start_node(tmp_path: Path) -> Iterator[Callable[..., NodeProcess]]:
    """Start installed executables by package, name and arguments; all are stopped at the end."""
    started: list[NodeProcess] = []

    def start(package: str, executable: str, *arguments: str) -> NodeProcess:
        log = tmp_path / f'{len(started)}_{executable}.log'
        started.append(NodeProcess(ROOT / 'install', package, executable, arguments, log))
        return started[-1]

    yield start
    for process in reversed(started):
        process.stop()


@pytest.fixture
def probe() -> Iterator[Probe]:
    """Join the test's graph with a node of its own."""
    made = Probe()
    yield made
    made.close()
