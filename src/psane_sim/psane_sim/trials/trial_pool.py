# SPDX-License-Identifier: Apache-2.0
"""Spread trials over this machine's cores, or over a Dask cluster where one is given."""

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, TypeVar

import cv2

from psane_sim.errors import AuditError

Row = dict[str, Any]
Result = TypeVar('Result')

ONE_THREAD = ('OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS', 'NUMBA_NUM_THREADS')
"""Variables that keep a worker to its core."""


def keep_to_one_core() -> None:
    """Keep OpenCV, which reads no such variable, from starting threads in this process."""
    cv2.setNumThreads(1)


def run_locally(run: Callable[..., Row], trials: Sequence[Any], shared: Any, workers: int
                ) -> Iterator[Row]:
    """Yield ``run(trial, shared)`` of every trial, as they finish, from `workers` processes."""
    for name in ONE_THREAD:
        os.environ[name] = '1'
    context = multiprocessing.get_context('spawn')
    with ProcessPoolExecutor(max_workers=workers, mp_context=context,
                             initializer=keep_to_one_core) as pool:
        waiting = {pool.submit(run, trial, shared) for trial in trials}
        try:
            for done in as_completed(waiting):
                yield done.result()
        finally:
            # After an interrupt only the trials under way are waited for.
            pool.shutdown(wait=False, cancel_futures=True)


def run_on_cluster(run: Callable[..., Result], trials: Sequence[Any], shared: Any, address: str
                   ) -> Iterator[Result]:
    """Yield ``run(trial, shared=shared)`` of every trial, as they finish, from a Dask cluster.

    Its workers must have the same packages installed.

    Raises
    ------
    AuditError
        When the package `distributed` is missing or the scheduler does not answer.
    """
    try:
        from distributed import Client
        from distributed import as_completed as as_completed_there
    except ImportError as missing:
        raise AuditError('--scheduler needs the package distributed, which is not installed; '
                         'install it (pip install distributed), or leave --scheduler out to use '
                         'the cores of this machine') from missing
    try:
        client = Client(address, timeout='10s')
    except (OSError, ValueError) as problem:
        raise AuditError(f'no Dask scheduler answers at {address}: {problem}') from problem
    with client:
        futures = client.map(run, trials, shared=shared, pure=False)
        for done in as_completed_there(futures):
            yield done.result()
