# SPDX-License-Identifier: Apache-2.0
"""The edge of the robot's certified ground, and how much could be won from each of its cells."""

import cv2
import numpy as np

from psane_mapping.grid import FloatArray
from psane_planner.configuration import PlannerConfiguration
from psane_planner.discs import Integers, Mask, count_in_discs, squared_radii
from psane_planner.window import window_around


def frontier_cells(component: Mask, certified: Mask, admissible: Mask) -> Integers:
    """Return the cells of the robot's component that border ground yet to be certified.

    Parameters
    ----------
    component, certified, admissible : (rows, columns) bool
        The robot's piece of the certified cells; all of them; and the cells that may be certified.

    Returns
    -------
    (n, 2) int, row and column, in the order of `numpy.argwhere`.

    Notes
    -----
    Border following by Suzuki & Abe (1985), as in OpenCV. A border cell that only touches
    forbidden ground (the workspace's border, keep-out areas) is none: nothing can be won there.
    """
    where = window_around(component, 1)
    if where is None:
        return np.empty((0, 2), dtype=np.int64)
    inner = component[where]
    contours, _ = cv2.findContours(inner.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    on_border = np.zeros(inner.shape, dtype=np.bool_)
    for contour in contours:
        on_border[contour[:, 0, 1], contour[:, 0, 0]] = True
    open_ground = admissible[where] & ~certified[where]
    cells: Integers = np.argwhere(on_border & inner & beside(open_ground))
    return cells + (where.rows.start, where.columns.start)


def beside(mask: Mask) -> Mask:
    """Return the cells that share an edge with a cell of `mask`."""
    near = np.zeros_like(mask)
    near[1:] |= mask[:-1]
    near[:-1] |= mask[1:]
    near[:, 1:] |= mask[:, :-1]
    near[:, :-1] |= mask[:, 1:]
    return near


def expansion_counts(cells: Integers, lower: FloatArray, targets: Mask | Integers,
                     configuration: PlannerConfiguration, resolution: float) -> Integers:
    """Return g_t: the uncertified cells that each frontier cell might certify.

    Parameters
    ----------
    cells : (n, 2) int
        Row and column of the frontier cells.
    lower : (rows, columns) float [-], slip ratio
        Lower ends l_t of the confidence intervals.
    targets : (rows, columns) bool or int
        Cells that count, or how much each counts.

    Returns
    -------
    (n,) int [-], count of targets x' with l_t(x) + L |x - x'| <= h.

    Notes
    -----
    Jiang et al., Algorithm 1, which uses l_t. The text's r(x) has u_t in its place; with it every
    count is 0 as soon as the safe set is closed under its own rule, and nothing moves.
    """
    limit = lower.shape[0] ** 2 + lower.shape[1] ** 2
    radii = squared_radii(lower[cells[:, 0], cells[:, 1]], configuration.slip_threshold,
                          configuration.lipschitz_constant, resolution, limit)
    return count_in_discs(targets, cells, radii)
