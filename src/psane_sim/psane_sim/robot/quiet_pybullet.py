# SPDX-License-Identifier: Apache-2.0
"""The one place that imports pybullet, without the line it prints of its own accord.

When it is loaded, the engine writes "pybullet build time: ..." past Python, through C's standard
streams (which one depends on its version), where it mixes with what a program prints.
"""

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ['pybullet']


@contextmanager
def silent_stream(number: int) -> Iterator[None]:
    """Send what C code writes to standard output (1) or standard error (2) nowhere."""
    buffers = ctypes.CDLL(None)
    sys.stdout.flush()
    buffers.fflush(None)
    try:
        kept = os.dup(number)
    except OSError:  # the stream is closed, so nothing can land in it
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, number)
        yield
    finally:
        buffers.fflush(None)
        os.dup2(kept, number)
        os.close(kept)
        os.close(nowhere)


with silent_stream(1), silent_stream(2):
    import pybullet
