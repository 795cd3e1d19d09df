# SPDX-License-Identifier: Apache-2.0
"""How well commanded Twists are followed on firm ground, and the feed-forward centred on that."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from psane_sim.calibration.ladder import Stride


@dataclass(frozen=True)
class Tracking:
    """How far one kind of Twist was missed on firm ground, at worst, as a share of the command.

    Parameters
    ----------
    kind : str
        'forward', 'backward' or 'spot'.
    speed, turn : (low, high) [-]
        Smallest and largest ratio of what was walked to what was asked, less 1.
    """

    kind: str
    speed: tuple[float, float]
    turn: tuple[float, float]


def tracking_of(found: Mapping[Any, Stride]) -> list[Tracking]:
    """Judge walks that have a `purpose` of 'twist' and a Twist, `linear` and `angular`."""
    kinds: dict[str, tuple[list[float], list[float]]] = {}
    for walk, stride in found.items():
        if walk.purpose != 'twist':
            continue
        kind = 'spot' if walk.linear == 0.0 else 'forward' if walk.linear > 0.0 else 'backward'
        speed, turn = kinds.setdefault(kind, ([], []))
        if walk.linear != 0.0:
            speed.append(stride.speed / walk.linear - 1.0)
        if walk.angular != 0.0:
            turn.append(stride.yaw_rate / walk.angular - 1.0)
    return [Tracking(kind, (min(speed, default=0.0), max(speed, default=0.0)),
                     (min(turn, default=0.0), max(turn, default=0.0)))
            for kind, (speed, turn) in kinds.items()]


def centred(simulator: dict[str, float], tracking: Sequence[Tracking]) -> dict[str, float]:
    """Return the feed-forward scaled so that Twists are missed as far above as below."""
    found = dict(simulator)
    by_kind = {entry.kind: entry for entry in tracking}
    for kind, ratios, names in (
            ('forward', 'speed', ('speed_per_sweep', 'speed_per_turn')),
            ('forward', 'turn', ('turn_per_sweep', 'turn_gain')),
            ('backward', 'speed', ('backward_speed_per_sweep',)),
            ('backward', 'turn', ('backward_turn_per_sweep',)),
            ('spot', 'turn', ('spot_turn_per_sweep',))):
        if kind in by_kind:
            low, high = getattr(by_kind[kind], ratios)
            for name in names:
                found[name] *= max(0.1, 1.0 + 0.5 * (low + high))
    return found
