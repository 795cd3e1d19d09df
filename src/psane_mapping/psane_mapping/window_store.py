# SPDX-License-Identifier: Apache-2.0
"""The windows of a map: made when first reached, let go when long unused, brought back exactly."""

from array import array
from collections import OrderedDict

import numpy as np

from psane_mapping.basis import RectangleBasis
from psane_mapping.kernels import Kernel, RadialBasis
from psane_mapping.tiling import Tiling
from psane_mapping.windows import DenseWindow, Evidence, SpectralWindow, Window

_MERGE_SHARE = 0.1
_RESIDENT_BYTES = 50e6
_FEWEST_RESIDENT = 12
_NUMBERS = 4

Index = tuple[int, int]


class WindowStore:
    """Windows by the index of their block.

    A window that was let go is rebuilt by telling it its measurements again, in their order, which
    gives the same window to the last bit. Those that heard of more measurements than they
    have modes stay, because to tell them again would take too long (tens of milliseconds).

    Parameters
    ----------
    kernel : Kernel
    tiling : Tiling
    tolerance : float
        See `GridPosterior`.
    """

    def __init__(self, kernel: Kernel, tiling: Tiling, tolerance: float) -> None:
        self._kernel = kernel
        self._tiling = tiling
        self._merge_distance = _MERGE_SHARE * kernel.lengthscale if tolerance > 0.0 else 0.0
        self._basis: RectangleBasis | None = None
        if isinstance(kernel, RadialBasis):
            self._basis = RectangleBasis.spanning(
                tiling.window_size, tiling.cells_in_window(), kernel.lengthscale,
                tiling.floor(tolerance))
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._windows: OrderedDict[Index, Window] = OrderedDict()
        self._records: dict[Index, array[float]] = {}

    @property
    def resident(self) -> int:
        """Windows in memory [count]."""
        return len(self._windows)

    def observe(self, index: Index, x: float, y: float, value: float,
                variance: float) -> Evidence:
        """Tell a window of a measurement at a point from its corner [m]; the prior mean is 0."""
        evidence = self._window(index).observe(x, y, value, variance)
        self._record(index, (x, y, value, variance))
        return evidence

    def regrid(self, tiling: Tiling, added: Index) -> None:
        """Take over a tiling with `added` more blocks before the first ones."""
        self._tiling = tiling
        south, west = added
        self._windows = OrderedDict(((row + south, column + west), window)
                                    for (row, column), window in self._windows.items())
        self._records = {(row + south, column + west): records
                         for (row, column), records in self._records.items()}

    def _window(self, index: Index) -> Window:
        """Return a window, made or rebuilt if need be, as the most recently used."""
        window = self._windows.get(index)
        if window is None:
            window = self._windows[index] = self._new_window(index)
            records = self._records.get(index)
            if records and isinstance(window, SpectralWindow):
                window.restore(np.array(records).reshape(-1, _NUMBERS))
            self._let_go()
        self._windows.move_to_end(index)
        return window

    def _new_window(self, index: Index) -> Window:
        shape = self._tiling.tile(index).shape
        if self._basis is not None:
            return SpectralWindow(self._basis, self._kernel.deviation, shape)
        along_y, along_x = self._tiling.cells_in_window()
        y, x = np.meshgrid(along_y[:shape[0]], along_x[:shape[1]], indexing='ij')
        cells = np.column_stack((x.ravel(), y.ravel()))
        return DenseWindow(self._kernel, cells, shape, self._merge_distance)

    def _record(self, index: Index, record: tuple[float, float, float, float]) -> None:
        """Remember what a window was told, up to one measurement more than it may be retold."""
        if self._basis is None or self._tiling.is_whole:
            return
        records = self._records.setdefault(index, array('d'))
        if len(records) <= _NUMBERS * self._basis.count:
            records.extend(record)

    def _let_go(self) -> None:
        """Drop the longest unused windows that can be rebuilt from their records."""
        if self._basis is None or self._tiling.is_whole:
            return
        modes = self._basis.count
        most = max(_FEWEST_RESIDENT, int(_RESIDENT_BYTES / (4 * modes * (modes + 1))))
        for index in list(self._windows)[:-_FEWEST_RESIDENT]:
            if len(self._windows) <= most:
                return
            if len(self._records.get(index, ())) <= _NUMBERS * modes:
                del self._windows[index]
