# SPDX-License-Identifier: Apache-2.0
"""The Pareto front of two objectives that are both to be large."""

import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray


def pareto_front(first: FloatArray, second: FloatArray) -> NDArray[np.bool_]:
    """Mark the candidates that no other one beats.

    Parameters
    ----------
    first, second : (n,) float
        The two objectives.

    Returns
    -------
    (n,) bool, True unless another candidate is at least as good in both and better in one.
    """
    count = first.shape[0]
    front = np.zeros(count, dtype=np.bool_)
    if count == 0:
        return front
    order = np.lexsort((-second, -first))
    best_second = second[order]
    # Within one value of the first objective only the best of the second can stand, and only
    # when it also exceeds whatever candidates with a larger first objective have reached.
    ordered = first[order]
    begins = np.ones(count, dtype=np.bool_)
    begins[1:] = ordered[1:] != ordered[:-1]
    group = np.cumsum(begins) - 1
    group_best = best_second[begins]
    reached = np.full(group_best.size, -np.inf)
    reached[1:] = np.maximum.accumulate(group_best)[:-1]
    stands = (best_second == group_best[group]) & (group_best > reached)[group]
    front[order[stands]] = True
    return front
