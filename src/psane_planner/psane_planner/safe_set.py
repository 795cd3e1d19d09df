# SPDX-License-Identifier: Apache-2.0
"""The certified cells: where slip stays below the threshold with the chosen confidence."""

import math

import numpy as np

from psane_mapping.grid import FloatArray, Grid
from psane_planner.component import component_around
from psane_planner.confidence import Bounds
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import NO_DISC, Mask, squared_radii, union_of_discs
from psane_planner.window import window_around


def admissible_cells(grid: Grid, border_width: float, keep_out: Mask | None = None) -> Mask:
    """Return the cells that may ever be certified: off the border and off keep-out ground."""
    # A cell whose centre lies on the line belongs to the border; rounding must not free it.
    admissible = grid.distance_to_border() > border_width + 1e-6
    return admissible if keep_out is None else admissible & ~keep_out


def propagate(previous: Mask, upper: FloatArray, configuration: PlannerConfiguration,
              resolution: float) -> Mask:
    """Return the union over certified x of {x' : upper(x) + L |x - x'| <= h}.

    Notes
    -----
    Jiang et al., section "Safe Region Characterization", computed as a union of discs
    (see `discs`), bit for bit equal to testing every pair of cells.
    """
    radii = np.full(upper.shape, NO_DISC, dtype=np.int64)
    limit = upper.shape[0] ** 2 + upper.shape[1] ** 2
    radii[previous] = squared_radii(upper[previous], configuration.slip_threshold,
                                    configuration.lipschitz_constant, resolution, limit)
    return union_of_discs(radii)


class SafeSet:
    """S_t by either rule, from the robot's own component on.

    Notes
    -----
    `bound` certifies each cell by its own interval, S_t = {u_t <= h}; a cell whose posterior mean
    exceeds h is refused even where an older interval still speaks for it, so that no certificate
    outlives its evidence. `lipschitz` is the paper's propagation. With `monotone` nothing that
    was certified is ever given up. S_0 is the component of {u_0 <= h} around the robot; an S_t
    that has become empty starts over from there.
    """

    def __init__(self, configuration: PlannerConfiguration, grid: Grid,
                 mask: Mask | None = None) -> None:
        """Start with `mask` (rows, columns) as S_{t-1}, by default with no certified cell."""
        self._configuration = configuration
        self._grid = grid
        self._rests_on: tuple[int, Mask, Mask | None] | None = None
        self.mask: Mask = np.zeros(grid.shape, dtype=np.bool_) if mask is None else mask

    def update(self, bounds: Bounds, std: FloatArray, admissible: Mask,
               position: FloatArray, known_safe: Mask | None = None) -> Mask:
        """Return S_t.

        Parameters
        ----------
        bounds : Bounds
            Ends of C_t.
        std : (rows, columns) float [-], slip ratio
            Posterior standard deviation, NaN where there is no estimate.
        admissible : (rows, columns) bool
            Cells that may be certified.
        position : (2,) float, map frame [m]
            The robot's, used for S_0 only.
        known_safe : (rows, columns) bool, optional
            Cells that are certified unasked, until they are known to be unsafe.
        """
        if self._is_current(bounds, admissible, known_safe):
            return self.mask
        h = self._configuration.slip_threshold
        previous = self.mask & admissible
        own = (bounds.upper <= h) & admissible
        if self._configuration.certification == 'bound':
            certified = own & (bounds.newest <= h) & self._within_felt_reach(bounds, std)
        elif previous.any():
            certified = propagate(previous, bounds.upper, self._configuration,
                                  self._grid.resolution) & admissible
        else:
            near = component_around(own, self._grid, position)
            close = near.outside_distance <= self._configuration.lost_distance
            certified = near.mask if close else np.zeros_like(own)
        if self._configuration.monotone:
            certified = certified | previous
        if known_safe is not None:
            certified = certified | (known_safe & admissible & ~(bounds.lower > h))
        certified.setflags(write=False)
        self.mask = certified
        self._rests_on = (bounds.version, admissible, known_safe)
        return certified

    def _is_current(self, bounds: Bounds, admissible: Mask, known_safe: Mask | None) -> bool:
        """Tell whether nothing has changed; propagation goes on even then."""
        known = self._rests_on
        return (known is not None and self._configuration.certification == 'bound'
                and known[0] == bounds.version and known[1] is admissible
                and known[2] is known_safe)

    def _within_felt_reach(self, bounds: Bounds, std: FloatArray) -> Mask:
        """Return the cells that stay safe even if slip rises steeply beyond what was felt."""
        config = self._configuration
        if config.felt_slope == 0.0:
            return np.ones(std.shape, dtype=np.bool_)
        within = np.zeros(std.shape, dtype=np.bool_)
        felt = (std <= config.felt_deviation) & (bounds.newest <= config.slip_threshold)
        where = window_around(felt, 0)
        if where is None:
            return within
        newest = bounds.newest[where]
        reach = (config.slip_threshold - float(newest[felt[where]].min())) / config.felt_slope
        where = window_around(felt, math.ceil(reach / self._grid.resolution)) or where
        felt, newest = felt[where], bounds.newest[where]
        radii = np.full(felt.shape, NO_DISC, dtype=np.int64)
        radii[felt] = squared_radii(newest[felt], config.slip_threshold, config.felt_slope,
                                    self._grid.resolution, felt.shape[0]**2 + felt.shape[1]**2)
        within[where] = union_of_discs(radii)
        return within
