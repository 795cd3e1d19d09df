# SPDX-License-Identifier: Apache-2.0
"""Worker processes that survive each other: one that dies costs its own trial and no other."""

import multiprocessing
import os
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from psane_sim.trials.trial_pool import ONE_THREAD, keep_to_one_core

Trial = TypeVar('Trial')
Result = TypeVar('Result')


def run_steadily(run: Callable[[Trial, Any], Result], trials: Sequence[Trial], shared: Any,
                 workers: int, give_up: Callable[[Trial, Any], Result]) -> Iterator[Result]:
    """Yield ``run(trial, shared)`` of every trial, as they finish.

    No more trials are handed out than there are workers. When a worker dies, those that were
    under way are run again one at a time; ``give_up(trial, shared)`` stands for the one that
    kills its worker again.
    """
    for name in ONE_THREAD:
        os.environ[name] = '1'
    suspects: deque[Trial] = deque()
    waiting = deque(trials)
    while waiting or suspects:
        if suspects:
            trial = suspects.popleft()
            # Alone, so that it is known whose fault another death is.
            alone = _Batch(run, deque([trial]), shared, 1)
            yield from alone
            if alone.lost:
                yield give_up(trial, shared)
        else:
            batch = _Batch(run, waiting, shared, workers)
            yield from batch
            suspects.extend(batch.lost)


class _Batch(Iterator[Result]):
    """Takes trials from a queue until it is empty or a worker dies."""

    def __init__(self, run: Callable[[Trial, Any], Result], queue: deque[Trial], shared: Any,
                 workers: int) -> None:
        self.lost: list[Any] = []
        self._made = self._results(run, queue, shared, workers)

    def __next__(self) -> Result:
        return next(self._made)

    def close(self) -> None:
        """Stop the workers; what is under way is given up."""
        self._made.close()

    def _results(self, run: Callable[[Trial, Any], Result], queue: deque[Trial], shared: Any,
                 workers: int) -> Generator[Result, None, None]:
        context = multiprocessing.get_context('spawn')
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(max_workers=workers, mp_context=context,
                                   initializer=keep_to_one_core)
        under_way: dict[Future[Result], Trial] = {}
        try:
            while queue or under_way:
                while queue and len(under_way) < workers and not self.lost:
                    trial = queue.popleft()
                    try:
                        under_way[pool.submit(run, trial, shared)] = trial
                    except BrokenProcessPool:
                        self.lost.append(trial)
                if not under_way:
                    return
                done, _ = wait(under_way, return_when=FIRST_COMPLETED)
                for future in done:
                    trial = under_way.pop(future)
                    if isinstance(future.exception(), BrokenProcessPool):
                        self.lost.append(trial)
                    else:
                        yield future.result()
        finally:
            if under_way:
                # After an interrupt nobody wants what they would still find out.
                for worker in set(multiprocessing.active_children()) - others:
                    worker.terminate()
            pool.shutdown(wait=False, cancel_futures=True)
