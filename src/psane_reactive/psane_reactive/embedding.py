# SPDX-License-Identifier: Apache-2.0
"""Place the vertices of a mesh with holes in the unit disk, one to one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from psane_mapping.grid import FloatArray, IndexArray
from psane_reactive.errors import MapError
from psane_reactive.mesh import Mesh

# Weights of slivers are limited to this range around the vertex' largest: any positive weight
# keeps the map one to one, and the linear system stays well conditioned.
_WEIGHT_RANGE = 1e4


@dataclass(frozen=True)
class Embedding:
    """The mesh with its holes filled, and where its vertices lie in the disk.

    Parameters
    ----------
    model : (n + h, 2) float, unit disk [-]
        Images of the n mesh vertices, then of one hub per hole.
    triangles : (m + f, 3) int
        The m triangles of the mesh, then the f of the fans between holes and hubs.
    doubled_area : (m + f,) float
        Twice the signed area of each image; all positive where the map is one to one [-].
    """

    model: FloatArray
    triangles: IndexArray
    doubled_area: FloatArray


def embed(mesh: Mesh, stiffness: float, is_uniform: bool = False) -> Embedding:
    """Map a mesh onto the unit disk with each hole shrunk around a hub of its own.

    Parameters
    ----------
    stiffness : float
        Pull of each hub on the border of its hole, relative to that of the mesh [-].
    is_uniform : bool
        Equal weights (Tutte 1963) instead of mean-value weights (Floater 2003).

    Raises
    ------
    MapError
        When the linear system cannot be solved.

    Notes
    -----
    The outer ring goes to the circle by arc length, every other vertex to a positive average of
    its neighbours, so the filled mesh is mapped one to one (Floater 1997). A hole's image is
    star-shaped around its hub, since no triangle of its fan is turned over. A hole contracted
    to exactly one point would flatten the triangles on its border; a finite pull does not.
    """
    count = len(mesh.vertices)
    total = count + len(mesh.rings) - 1
    rows, columns, weights = (_uniform_weights if is_uniform else mean_value_weights)(
        mesh.vertices, mesh.triangles)
    fans, hub_rows, hub_columns, hub_weights = _hubs(mesh, stiffness)
    sums = np.bincount(rows, weights, minlength=total)
    weights = weights / sums[rows]
    rows = np.concatenate((rows, hub_rows))
    columns = np.concatenate((columns, hub_columns))
    weights = np.concatenate((weights, hub_weights))
    model = np.zeros((total, 2))
    outer = mesh.rings[0]
    angle = _arc_length_angles(mesh.vertices[outer])
    model[outer] = np.column_stack((np.cos(angle), np.sin(angle)))
    is_free = np.ones(total, dtype=bool)
    is_free[outer] = False
    _solve(model, is_free, rows, columns, weights)
    triangles = np.concatenate((mesh.triangles, *fans))
    return Embedding(model, triangles, doubled_areas(model, triangles))


def doubled_areas(points: FloatArray, triangles: IndexArray) -> FloatArray:
    """Twice the signed areas of triangles, (m,)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    areas: FloatArray = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    return areas


def mean_value_weights(vertices: FloatArray, triangles: IndexArray,
                       ) -> tuple[IndexArray, IndexArray, FloatArray]:
    """Weights of Floater (2003), w_ij = (tan(a/2) + tan(b/2)) / |x_i - x_j|.

    Returns
    -------
    Row i, column j and weight, one entry per triangle corner and side; entries of the same pair
    add up.
    """
    rows, columns, weights = [], [], []
    for k in range(3):
        i, j, m = (triangles[:, (k + step) % 3] for step in range(3))
        to_j, to_m = vertices[j] - vertices[i], vertices[m] - vertices[i]
        length_j, length_m = np.hypot(*to_j.T), np.hypot(*to_m.T)
        sine = to_j[:, 0] * to_m[:, 1] - to_j[:, 1] * to_m[:, 0]
        cosine = np.einsum('ij,ij->i', to_j, to_m)
        half_tangent = np.hypot(sine, cosine) - cosine
        half_tangent = np.maximum(half_tangent, 1e-12) / np.maximum(sine, 1e-12)
        rows += [i, i]
        columns += [j, m]
        weights += [half_tangent / length_j, half_tangent / length_m]
    row, column = np.concatenate(rows), np.concatenate(columns)
    weight = np.concatenate(weights)
    largest = np.zeros(len(vertices))
    np.maximum.at(largest, row, weight)
    return row, column, np.maximum(weight, largest[row] / _WEIGHT_RANGE)


def _uniform_weights(vertices: FloatArray, triangles: IndexArray,
                     ) -> tuple[IndexArray, IndexArray, FloatArray]:
    """Return equal weights for both sides of each triangle corner (see `mean_value_weights`)."""
    row = np.concatenate([triangles[:, k] for k in range(3) for _ in range(2)])
    column = np.concatenate([triangles[:, (k + step) % 3] for k in range(3) for step in (1, 2)])
    return row, column, np.ones(len(row))


def _hubs(mesh: Mesh, stiffness: float,
          ) -> tuple[list[IndexArray], IndexArray, IndexArray, FloatArray]:
    """Return the fan triangles of all holes and the weights between borders and hubs."""
    fans: list[IndexArray] = []
    rows, columns, weights = [], [], []
    for number, ring in enumerate(mesh.rings[1:]):
        hub = np.full(len(ring), len(mesh.vertices) + number)
        following = np.roll(ring, -1)
        # The region is on the left of the ring's edges, so the fan is on their right.
        fans.append(np.column_stack((following, ring, hub)))
        lengths = np.hypot(*(mesh.vertices[following] - mesh.vertices[ring]).T)
        share = 0.5 * (lengths + np.roll(lengths, 1)) / lengths.sum()
        rows += [ring, hub]
        columns += [hub, ring]
        weights += [np.full(len(ring), stiffness), share]
    if not rows:
        nothing = np.empty(0, dtype=np.int64)
        return fans, nothing, nothing, np.empty(0)
    return fans, np.concatenate(rows), np.concatenate(columns), np.concatenate(weights)


def _arc_length_angles(ring: FloatArray) -> FloatArray:
    """Return the angle of each vertex of a closed ring, proportional to arc length (k,) [rad]."""
    lengths = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)
    along = np.concatenate(([0.0], np.cumsum(lengths)[:-1]))
    angles: FloatArray = 2.0 * np.pi * along / lengths.sum()
    return angles


def _solve(model: FloatArray, is_free: NDArray[np.bool_], rows: IndexArray, columns: IndexArray,
           weights: FloatArray) -> None:
    """Put every free vertex at the weighted average of its neighbours."""
    free = np.flatnonzero(is_free)
    if len(free) == 0:
        return
    number = np.full(len(model), -1)
    number[free] = np.arange(len(free))
    own = is_free[rows]
    rows, columns, weights = number[rows[own]], columns[own], weights[own]
    diagonal = np.bincount(rows, weights, minlength=len(free))
    inner = is_free[columns]
    index = np.concatenate((rows[inner], np.arange(len(free))))
    other = np.concatenate((number[columns[inner]], np.arange(len(free))))
    value = np.concatenate((-weights[inner], diagonal))
    matrix = coo_array((value, (index, other)), shape=(len(free), len(free))).tocsc()
    fixed = ~inner
    right = np.column_stack([
        np.bincount(rows[fixed], weights[fixed] * model[columns[fixed], axis],
                    minlength=len(free)) for axis in range(2)])
    try:
        model[free] = splu(matrix, permc_spec='MMD_AT_PLUS_A', diag_pivot_thresh=0.0,
                           options={'SymmetricMode': True}).solve(right)
    except RuntimeError as error:
        raise MapError('the equations of the map are singular; the region is not connected'
                       ) from error
