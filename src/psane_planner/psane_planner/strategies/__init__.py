# SPDX-License-Identifier: Apache-2.0
"""The strategies by name: each public `Strategy` in a file of this folder is one."""

import pkgutil
from collections.abc import Iterator
from importlib import import_module

from psane_planner.errors import StrategyError
from psane_planner.strategies.strategy import Strategy, Traits


def _found() -> Iterator[type[Strategy]]:
    for file in pkgutil.iter_modules(__path__):
        module = import_module(f'{__name__}.{file.name}')
        for entry in vars(module).values():
            if isinstance(entry, type) and issubclass(entry, Strategy) \
                    and entry.__module__ == module.__name__ and hasattr(entry, 'name'):
                yield entry


AVAILABLE: dict[str, type[Strategy]] = {kind.name: kind for kind in _found()}


def make_strategy(name: str) -> Strategy:
    """Return a new strategy.

    Raises
    ------
    StrategyError
        When there is none of that name; the message lists those there are.
    """
    if name not in AVAILABLE:
        raise StrategyError(name, sorted(AVAILABLE))
    return AVAILABLE[name]()


__all__ = ['AVAILABLE', 'Strategy', 'Traits', 'make_strategy']
