# SPDX-License-Identifier: Apache-2.0
"""From a trial to the configuration of every part, and to the words that are stored of it."""

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from enum import Enum
from typing import Any

from psane_mapping.errors import ParameterError
from psane_planner.presets import PRESETS
from psane_reactive.configuration import ReactiveConfiguration
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.paper.task import PaperTrial, Robot
from psane_sim.runs.closed_loop import Settings
from psane_sim.runs.kinematic_loop import KinematicSettings
from psane_sim.runs.simulated_touch import SimulatedTouchConfiguration
from psane_sim.touch.method import TouchMethod

NOISE = 'noise'
"""Change that multiplies all noise of the sensors by its value."""

TOUCH_METHOD = 'touch_method'
"""Change that names a `TouchMethod` (physics only)."""

THRESHOLD = 'planner.slip_threshold'

KINEMATIC_STEERING = ReactiveConfiguration(mesh_edge=0.2)
KINEMATIC_PLAN_PERIOD = 0.4
KINEMATIC_TOLERANCE = 1e-4
"""Hundreds of kinematic explorations are for statistics: coarser meshes, half of the plans [s]
(new ground is felt every 0.7 s), and no modes of the map that hold less than a hundredth of a per
cent of the prior variance, far below what a cell of an OccupancyGrid can show."""


@dataclass(frozen=True, kw_only=True)
class PaperSettings:
    """What all trials of an experiment share.

    Parameters
    ----------
    preset : str
        Name among `PRESETS`.
    """

    preset: str = 'default'


def loop_settings(trial: PaperTrial, shared: PaperSettings) -> Settings | KinematicSettings:
    """Return the configurations of all parts of a trial.

    Raises
    ------
    ParameterError
        For a change of something that does not exist, or to a bad value.
    """
    preset = PRESETS[shared.preset]
    parts: dict[str, Any] = {
        'planner': replace(preset.planner, strategy=trial.strategy), 'mapping': preset.mapping}
    noise, method = 1.0, TouchMethod.FORCE_AND_TORQUE
    for name, value in trial.changes:
        part, _, field = name.partition('.')
        if name == NOISE and isinstance(value, float):
            noise = value
        elif name == TOUCH_METHOD:
            method = TouchMethod(value)
        elif part in parts and hasattr(parts[part], field):
            parts[part] = replace(parts[part], **{field: value})
        else:
            raise ParameterError(name, value, 'a parameter of planner or mapping, '
                                 f'{NOISE} or {TOUCH_METHOD}')
    if trial.robot is Robot.PHYSICS:
        return Settings(simulator=SimulatorConfiguration(noise_scale=noise),
                        touch_method=method, **parts)
    if method is not TouchMethod.FORCE_AND_TORQUE:
        raise ParameterError(TOUCH_METHOD, method.value, 'the physics: the kinematic robot has '
                             'no forces to choose among')
    parts['mapping'] = replace(parts['mapping'], tolerance=KINEMATIC_TOLERANCE)
    return KinematicSettings(touch=SimulatedTouchConfiguration().times(noise),
                             reactive=KINEMATIC_STEERING, plan_period=KINEMATIC_PLAN_PERIOD,
                             **parts)


def threshold_of(settings: Settings | KinematicSettings) -> float:
    """Return the slip above which ground is unsafe [-]."""
    return settings.planner.slip_threshold


def document_of(trial: PaperTrial, shared: PaperSettings) -> dict[str, Any]:
    """Return all that a trial is made of, as JSON can hold it."""
    made: dict[str, Any] = json.loads(json.dumps({
        'preset': shared.preset, 'trial': asdict(trial),
        'settings': asdict(loop_settings(trial, shared))}, default=_plain))
    return made


def fingerprint_of(document: dict[str, Any]) -> str:
    """Return short text that is the same for the same document only."""
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()[:16]


def _plain(value: object) -> object:
    if isinstance(value, Enum):
        return value.value
    if hasattr(value, 'tolist'):
        return value.tolist()
    raise TypeError(f'{value!r} cannot be stored')
