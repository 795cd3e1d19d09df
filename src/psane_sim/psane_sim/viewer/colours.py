# SPDX-License-Identifier: Apache-2.0
"""Colours of the live view: maps as pictures, values as points, and the bar that explains them."""

import matplotlib
import numpy as np
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray

Picture = NDArray[np.uint8]

OPACITY = 235
"""Of a map where it knows something, 0..255; elsewhere it is not to be seen."""

CERTIFIED = (0, 190, 140)
REGION = (0, 120, 85)
SUBGOAL = (123, 51, 148)
GOAL = (255, 200, 0)
PATH = (25, 25, 25)
FORCE = (215, 25, 28)


def table_of(name: str) -> Picture:
    """Return the 256 colours (256, 3) of a colour map of matplotlib."""
    shades = np.asarray(matplotlib.colormaps[name](np.linspace(0.0, 1.0, 256)))
    return np.asarray(np.round(255.0 * shades[:, :3]), dtype=np.uint8)


def shades_of(values: FloatArray, name: str, top: float) -> Picture:
    """Return the colours (..., 3) of values between 0 and `top`; what is not finite is black."""
    known = np.isfinite(values)
    share = np.clip(np.where(known, values, 0.0) / top, 0.0, 1.0)
    shades = table_of(name)[np.round(255.0 * share).astype(np.int64)]
    shades[~known] = 0
    return shades


def picture_of(values: FloatArray, name: str, top: float) -> Picture:
    """Return a map (rows, columns) as a picture (rows, columns, 4), its first row at the bottom.

    What is not finite is left open.
    """
    picture = np.empty((*values.shape, 4), dtype=np.uint8)
    picture[..., :3] = shades_of(values, name, top)
    picture[..., 3] = np.where(np.isfinite(values), OPACITY, 0)
    return picture[::-1]


def tint_of(mask: NDArray[np.bool_], colour: tuple[int, int, int], opacity: int) -> Picture:
    """Return a mask (rows, columns) as a see-through picture, its first row at the bottom."""
    picture = np.zeros((*mask.shape, 4), dtype=np.uint8)
    picture[mask] = (*colour, opacity)
    return picture[::-1]


def bar(name: str, low: str, high: str, meaning: str) -> str:
    """Return a colour bar in HTML, with the words at its ends and what it means."""
    stops = ', '.join(f'rgb({r},{g},{b})' for r, g, b in table_of(name)[::51].tolist())
    return (f'<div style="margin:2px 14px 8px 14px;font-size:12px">'
            f'<div style="height:10px;background:linear-gradient(to right, {stops})"></div>'
            f'<div style="display:flex;justify-content:space-between"><span>{low}</span>'
            f'<span>{meaning}</span><span>{high}</span></div></div>')
