# SPDX-License-Identifier: Apache-2.0
"""Build the map of a region, at once or beside the control loop."""

from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import ParamSpec, TypeVar

import numpy as np
import shapely

from psane_reactive.configuration import ReactiveConfiguration
from psane_reactive.errors import ReactiveError
from psane_reactive.harmonic import HarmonicMap
from psane_reactive.model_map import ModelMap
from psane_reactive.purging import PurgingMap

_Arguments = ParamSpec('_Arguments')
_Result = TypeVar('_Result')


class AtOnce(Executor):
    """Runs what it is given before it returns: the same inputs give the same commands."""

    def submit(self, task: Callable[_Arguments, _Result], /, *arguments: _Arguments.args,
               **named: _Arguments.kwargs) -> Future[_Result]:
        """Run a task and return its finished future."""
        future: Future[_Result] = Future()
        try:
            future.set_result(task(*arguments, **named))
        except Exception as error:  # noqa: BLE001 - handed on to whoever asks for the result
            future.set_exception(error)
        return future


def build_map(component: shapely.Polygon, settings: ReactiveConfiguration) -> ModelMap | None:
    """Return the chosen map of a smoothed polygon, None when it cannot be built."""
    try:
        if settings.steering_map == 'purging':
            return PurgingMap(component, settings.purge_switch, settings.purge_pieces,
                              settings.purge_width)
        # A hexagonal lattice has one vertex per 0.866 edge^2.
        edge = max(settings.mesh_edge, component.length / settings.mesh_size,
                   float(np.sqrt(component.area / (0.866 * settings.mesh_size))))
        return HarmonicMap(component, edge, settings.hole_stiffness, settings.longest_detour)
    except ReactiveError:
        return None
