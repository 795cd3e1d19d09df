# SPDX-License-Identifier: Apache-2.0
"""Stances that a leg might have felt, with ground of known strength and known errors."""

import numpy as np

from psane_mapping.contact import LegContact


def arc_force(depth, phase):
    """Return (n, 3) forces [N] of a shallow arc at strength 1, at depths [m] and phases 0..1."""
    vertical = 4.0e3 * np.maximum(depth, 0.0) ** 1.4
    return np.column_stack((0.5 * np.cos(np.pi * phase) * vertical, vertical,
                            0.6 * np.sin(np.pi * phase) * vertical))


def stance(strength=0.3, deepest=0.05, samples=80, seed=0, height_bias=0.0, noise=1.0,
           point=(5.0, 5.0), time=1.0, has_velocity=True, point_deviation=0.01, leg=0):
    """Return one stance; `noise` scales force noise of 1 N + 3 %."""
    rng = np.random.default_rng(seed)
    phase = np.linspace(0.0, 1.0, samples)
    depth = deepest * np.sin(np.pi * phase)
    force = strength * arc_force(depth + height_bias, phase)
    deviation = 1.0 + 0.03 * np.abs(force)
    measured = force + noise * deviation * rng.normal(size=force.shape)
    return LegContact(leg=leg, touch_down=time - 0.7, lift_off=time, point=np.array(point),
                      point_deviation=point_deviation, depth=depth, measured=measured,
                      response=arc_force(depth, phase), deviation=deviation,
                      has_velocity=has_velocity)
