# SPDX-License-Identifier: Apache-2.0
"""Whether new contacts are as far from their predictions as the map says that they may be."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from psane_mapping.gaussian_process import Innovation

_FEWEST = 30


@dataclass(frozen=True)
class InnovationSummary:
    """Normalised innovations of the latest contacts.

    Parameters
    ----------
    count : int
        How many they are [count].
    mean : float
        About 0 for an unbiased model [-].
    rms : float
        About 1 for an honest one, above when it is over-confident [-].
    """

    count: int
    mean: float
    rms: float

    def is_over_confident(self, most: float) -> bool:
        """Tell whether the root mean square is above `most`, and from enough contacts to say so.

        Of 30 contacts of an honest model, one root mean square in 100 000 is above 1.5.
        """
        return self.count >= _FEWEST and self.rms > most


class InnovationMonitor:
    """Keeps the latest innovations, each divided by its deviation.

    Parameters
    ----------
    length : int
        How many are kept [count].
    """

    def __init__(self, length: int) -> None:
        self._ratios: deque[float] = deque(maxlen=length)

    def add(self, innovation: Innovation) -> None:
        """Take in the innovation of one contact."""
        ratio = innovation.value / innovation.deviation
        if math.isfinite(ratio):
            self._ratios.append(ratio)

    def clear(self) -> None:
        """Forget all."""
        self._ratios.clear()

    def summary(self) -> InnovationSummary:
        """Return the statistics of the latest contacts."""
        ratios = np.array(self._ratios)
        if not ratios.size:
            return InnovationSummary(0, 0.0, 0.0)
        return InnovationSummary(ratios.size, float(ratios.mean()),
                                 float(np.sqrt(np.mean(ratios**2))))
