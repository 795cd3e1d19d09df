# SPDX-License-Identifier: Apache-2.0
"""Evaluate a chain of purging transformations, compiled: image and Jacobian of a point."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray, IndexArray


class Chain(NamedTuple):
    """Convex pieces in the order in which they are purged.

    Parameters
    ----------
    centres : (n, 2) float, map frame [m]
    edges : (n, 3) float
        Unit normal of the edge onto which a piece goes and (point - centre) . normal [m]; for a
        root that becomes a disk 0, 0 and its radius [m].
    boxes : (n, 4) float [m]
        Least x, y and largest x, y of the collar.
    faces : (f, 3) float
        Unit inward normal and offset: inside where normal . x >= offset [m].
    piece_faces, collar_faces : (n, 2) int
        First face of a piece's free sides and one past the last; the same for its collar.
    is_exponential : bool
        Published switch instead of the scale-free one.
    width, decay_outside, decay_collar : float
        eps [m], mu_1 [m] and mu_2 [-] of the published switch.
    """

    centres: FloatArray
    edges: FloatArray
    boxes: FloatArray
    faces: FloatArray
    piece_faces: IndexArray
    collar_faces: IndexArray
    is_exponential: bool
    width: float
    decay_outside: float
    decay_collar: float


# Weight of the distance to the piece against that to the collar in the scale-free switch [-].
_KAPPA = 0.3
# Distance to a piece that composing hundreds of transformations may get wrong [m].
_ROUNDING = 1e-11


@njit(cache=True, error_model='numpy')  # type: ignore[misc]
def _power_20(value: float) -> float:
    fourth = value * value * value * value
    return fourth * fourth * fourth * fourth * fourth


@njit(cache=True, error_model='numpy')  # type: ignore[misc]
def conjunction(faces: FloatArray, first: int, last: int, x: float, y: float,
                ) -> tuple[float, float, float]:
    """Return f_1 ^ f_2 ^ ... of half-planes, and its gradient.

    Notes
    -----
    R-function f ^ g = f + g - (f^p + g^p)^(1/p) with p = 20 (Rimon & Koditschek 1992): positive
    inside, 0 on the border, smooth elsewhere, and concave like the half-planes it is made of.
    """
    f, fx, fy = faces[first, 0] * x + faces[first, 1] * y - faces[first, 2], \
        faces[first, 0], faces[first, 1]
    for k in range(first + 1, last):
        gx, gy = faces[k, 0], faces[k, 1]
        g = gx * x + gy * y - faces[k, 2]
        size, other = max(abs(f), abs(g)), min(abs(f), abs(g))
        if size == 0.0:
            return 0.0, fx, fy
        ratio = _power_20(other / size)
        norm = size * math.exp(math.log1p(ratio) / 20.0)
        # (|f| / norm)^19 by way of the 20th power, which keeps the sign of f.
        share_f, share_g = f / norm, g / norm
        slope_f = _power_20(share_f) / share_f if share_f != 0.0 else 0.0
        slope_g = _power_20(share_g) / share_g if share_g != 0.0 else 0.0
        f = f + g - norm
        fx = (1.0 - slope_f) * fx + (1.0 - slope_g) * gx
        fy = (1.0 - slope_f) * fy + (1.0 - slope_g) * gy
    return f, fx, fy


@njit(cache=True, error_model='numpy')  # type: ignore[misc]
def _scale_free(b: float, g: float) -> tuple[float, float, float]:
    """Return t^2 with t = g / (g + kappa b), and its derivatives by b and by g."""
    whole = g + _KAPPA * b
    t = g / whole
    return t * t, -2.0 * t * _KAPPA * g / (whole * whole), 2.0 * t * _KAPPA * b / (whole * whole)


@njit(cache=True, error_model='numpy')  # type: ignore[misc]
def _exponential(b: float, a: float, width: float, decay_outside: float, decay_collar: float,
                 ) -> tuple[float, float, float]:
    """Return the published switch s_g s_b / (s_g s_b + 1 - s_b), and its derivatives by b, a.

    Notes
    -----
    Vasilopoulos et al. (2020): s_b = exp(-mu_1 / (eps - b)) / exp(-mu_1 / eps) for b < eps, else
    0; s_g = exp(-mu_2 / a) with a = g / |x - x*|.
    """
    if b >= width or a <= 0.0:
        return 0.0, 0.0, 0.0
    s_b = math.exp(decay_outside / width - decay_outside / (width - b))
    s_g = math.exp(-decay_collar / a)
    ds_b = -s_b * decay_outside / (width - b) ** 2
    ds_g = s_g * decay_collar / (a * a)
    whole = s_g * s_b + 1.0 - s_b
    if whole <= 0.0:
        return 0.0, 0.0, 0.0
    return s_g * s_b / whole, s_g * ds_b / (whole * whole), s_b * (1.0 - s_b) * ds_g / whole**2


@njit(cache=True, error_model='numpy')  # type: ignore[misc]
def _switch(chain: Chain, k: int, x: float, y: float) -> tuple[float, float, float]:
    """Return sigma of piece k at a point, and its gradient."""
    g, gx, gy = conjunction(chain.faces, chain.collar_faces[k, 0], chain.collar_faces[k, 1], x, y)
    if g <= 0.0:
        return 0.0, 0.0, 0.0
    inside, bx, by = conjunction(chain.faces, chain.piece_faces[k, 0], chain.piece_faces[k, 1],
                                 x, y)
    # On the piece itself all is purged, and so near it that rounding may have put a point there.
    b, bx, by = max(0.0, -inside - _ROUNDING), -bx, -by
    if not chain.is_exponential:
        sigma, by_b, by_g = _scale_free(b, g)
        return sigma, by_b * bx + by_g * gx, by_b * by + by_g * gy
    dx, dy = x - chain.centres[k, 0], y - chain.centres[k, 1]
    away = math.hypot(dx, dy)
    sigma, by_b, by_a = _exponential(b, g / away, chain.width, chain.decay_outside,
                                     chain.decay_collar)
    ax, ay = gx / away - g * dx / away**3, gy / away - g * dy / away**3
    return sigma, by_b * bx + by_a * ax, by_b * by + by_a * ay


@njit(cache=True, error_model='numpy')  # type: ignore[misc]
def purge(chain: Chain, x: float, y: float, jacobian: FloatArray) -> tuple[float, float]:
    """Return the image of a point; its Jacobian is written to `jacobian` (2, 2).

    Notes
    -----
    h(x) = sigma (x* + nu (x - x*)) + (1 - sigma) x; nu = ((v_e - x*) . n_e) / ((x - x*) . n_e),
    and nu = radius / |x - x*| for a root that becomes a disk.
    """
    jacobian[0, 0], jacobian[0, 1], jacobian[1, 0], jacobian[1, 1] = 1.0, 0.0, 0.0, 1.0
    for k in range(chain.centres.shape[0]):
        if (x <= chain.boxes[k, 0] or y <= chain.boxes[k, 1]
                or x >= chain.boxes[k, 2] or y >= chain.boxes[k, 3]):
            continue
        sigma, sx, sy = _switch(chain, k, x, y)
        if sigma <= 0.0:
            continue
        dx, dy = x - chain.centres[k, 0], y - chain.centres[k, 1]
        nx, ny, reach = chain.edges[k, 0], chain.edges[k, 1], chain.edges[k, 2]
        if nx == 0.0 and ny == 0.0:
            square = dx * dx + dy * dy
            nu = reach / math.sqrt(square)
            nu_x, nu_y = -nu * dx / square, -nu * dy / square
        else:
            along = dx * nx + dy * ny
            nu = reach / along
            nu_x, nu_y = -nu * nx / along, -nu * ny / along
        drop = nu - 1.0
        # h - x = sigma (nu - 1) (x - x*).
        h00 = 1.0 + sigma * drop + dx * (sx * drop + sigma * nu_x)
        h01 = dx * (sy * drop + sigma * nu_y)
        h10 = dy * (sx * drop + sigma * nu_x)
        h11 = 1.0 + sigma * drop + dy * (sy * drop + sigma * nu_y)
        j00, j01, j10, j11 = jacobian[0, 0], jacobian[0, 1], jacobian[1, 0], jacobian[1, 1]
        jacobian[0, 0], jacobian[0, 1] = h00 * j00 + h01 * j10, h00 * j01 + h01 * j11
        jacobian[1, 0], jacobian[1, 1] = h10 * j00 + h11 * j10, h10 * j01 + h11 * j11
        x, y = x + sigma * drop * dx, y + sigma * drop * dy
    return x, y


@njit(cache=True)  # type: ignore[misc]
def purge_all(chain: Chain, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return images (n, 2) and Jacobians (n, 2, 2) of points (n, 2)."""
    images, jacobians = np.empty_like(points), np.empty((points.shape[0], 2, 2))
    for i in range(points.shape[0]):
        images[i] = purge(chain, points[i, 0], points[i, 1], jacobians[i])
    return images, jacobians
