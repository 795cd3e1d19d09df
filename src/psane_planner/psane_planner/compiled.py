# SPDX-License-Identifier: Apache-2.0
"""Compile a loop over cells to machine code, keeping its types for the reader and the checker."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar('Function', bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Return `function` compiled at first call; the machine code is kept on disk."""
    return cast(Function, numba.njit(cache=True)(function))
