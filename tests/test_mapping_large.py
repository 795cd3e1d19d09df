# SPDX-License-Identifier: Apache-2.0
"""A long walk on a map too large for one window, as the benchmark measures it."""

import numpy as np
import pytest

from psane_mapping import large_map_benchmark
from psane_mapping.large_map_benchmark import _Walk, walk


@pytest.fixture(scope='module')
def walked():
    made = _Walk(30.0, 1500, 1)
    made.feed()
    return made


def test_blocks_agree_with_the_dense_process_around_the_walk(walked):
    mean, in_std, std = walked.errors(0)
    assert not walked.maps[0].tiling.is_whole
    # Measured on the benchmark's walk: 0.05 deviations and 6e-4.
    assert in_std < 0.15 and std < 1e-3
    assert 0.0 < mean < 0.03


def test_the_walk_stays_on_the_map_and_goes_far():
    points = walk(20000, 100.0, np.random.default_rng(0))
    assert (points >= 0.0).all() and (points <= 100.0).all()
    assert (np.ptp(points, axis=0) > 30.0).all()
    # Feet of consecutive steps are near each other.
    assert np.median(np.linalg.norm(np.diff(points, axis=0), axis=1)) < 0.5


def test_memory_is_that_of_this_process():
    before = large_map_benchmark._largest_memory()
    block = np.ones(30_000_000)
    after = large_map_benchmark._largest_memory()
    assert block.sum() > 0.0 and before > 10.0
    # Freed memory below an earlier peak may be used again, which can hide part of it.
    assert after >= before
