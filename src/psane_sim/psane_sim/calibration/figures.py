# SPDX-License-Identifier: Apache-2.0
"""Figures of a calibration: slip over strength, and how a commanded Twist is followed."""

from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from psane_mapping.slip import RotaryWalking
from psane_sim.calibration.calibration import Calibration, SlipFit
from psane_sim.calibration.ladder import Stride


class _Walk(Protocol):
    purpose: str
    strength: float
    linear: float
    angular: float


def draw_calibration(path: Path, found: dict[Any, Stride], calibration: Calibration,
                     fit: SlipFit, rotary: RotaryWalking) -> None:
    """Write a picture of what was measured and what was fitted to it."""
    import matplotlib

    matplotlib.use('Agg')
    from matplotlib import pyplot

    figure, (left, middle, right) = pyplot.subplots(1, 3, figsize=(13.5, 4.0),
                                                    constrained_layout=True)
    _draw_slip(left, found, calibration, fit, rotary)
    for axes, field, unit in ((middle, 'linear', 'forward speed [m/s]'),
                              (right, 'angular', 'yaw rate [rad/s]')):
        _draw_tracking(axes, found, field, unit)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def _draw_slip(axes: Any, found: dict[Any, Stride], calibration: Calibration,
               fit: SlipFit, rotary: RotaryWalking) -> None:
    pairs = [(walk.strength, 1.0 - stride.speed / calibration.rigid_speed)
             for walk, stride in found.items() if walk.purpose == 'slip']
    strength, slip = np.array(sorted(pairs)).T
    axes.fill_between(fit.strength, fit.low, fit.high, color='C0', alpha=0.2, lw=0,
                      label='90 % band')
    axes.plot(fit.strength, fit.curve.slip(fit.strength), 'C0', label='calibrated curve')
    for clipped, style in ((True, '--'), (False, ':')):
        axes.plot(fit.strength, replace(rotary, clipped=clipped).slip(fit.strength), f'C1{style}',
                  lw=1, label=f'rotary walking, {"clipped" if clipped else "raw"}')
    axes.plot(strength, slip, 'ko', ms=4, label='simulated')
    axes.set(xscale='log', xlabel='strength [-]', ylabel='slip [-]', ylim=(-0.45, 1.05))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7)


def _draw_tracking(axes: Any, found: dict[Any, Stride], field: str, unit: str) -> None:
    twists = [(walk, stride) for walk, stride in found.items() if walk.purpose == 'twist']
    for index, strength in enumerate(sorted({walk.strength for walk, _ in twists})):
        asked = [getattr(walk, field) for walk, _ in twists if walk.strength == strength]
        done = [stride.speed if field == 'linear' else stride.yaw_rate
                for walk, stride in twists if walk.strength == strength]
        axes.plot(asked, done, 'osd'[index % 3], ms=4, label=f'strength {strength:.2g}')
    low, high = axes.get_xlim()
    axes.plot((low, high), (low, high), 'k-', lw=0.5)
    for factor in (0.85, 1.15):
        axes.plot((low, high), (factor * low, factor * high), 'k:', lw=0.5)
    axes.set(xlabel=f'commanded {unit}', ylabel='walked')
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7)
