# SPDX-License-Identifier: Apache-2.0
"""Sets of parameters with a name: this project's defaults, and those of the published runs."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.parameters import Configuration
from psane_planner.configuration import PlannerConfiguration


@dataclass(frozen=True, kw_only=True)
class Preset:
    """Parameters of the map and of the planner, with what they are for in one sentence."""

    meaning: str
    mapping: MappingConfiguration
    planner: PlannerConfiguration


PRESETS: Mapping[str, Preset] = MappingProxyType({
    'default': Preset(
        meaning='Defaults of map and planner.',
        mapping=MappingConfiguration(), planner=PlannerConfiguration()),
    'published': Preset(
        meaning='The published runs (Jiang et al.): beta 3, k_e = k_g = 0.1, l 0.6, sigma_f 0.5, '
        'h 0.5, L 2; certificates are not revoked and the map alone is trusted.',
        mapping=MappingConfiguration(lengthscale=0.6, slip_prior_deviation=0.5,
                                     slip_prior_mean=0.0, surprise_reach=0.0),
        planner=PlannerConfiguration(
            strategy='psane', slip_threshold=0.5, confidence_scale=3.0, lipschitz_constant=2.0,
            expansion_rate=0.1, goal_decay=0.1, revocation_scale=0.0, felt_slope=0.0,
            stride_prior_deviation=0.0)),
})


def yaml_of(preset: Preset) -> str:
    """Return a ROS parameter file that sets every parameter of both nodes' cores."""
    lines = ['# SPDX-License-Identifier: Apache-2.0', f'# {preset.meaning}']
    for node, configuration in (('terrain_mapper', preset.mapping),
                                ('safe_planner', preset.planner)):
        lines += [f'/**/{node}:', '  ros__parameters:', *_lines(configuration)]
    return '\n'.join(lines) + '\n'


def _lines(configuration: Configuration) -> list[str]:
    return [f'    {entry.name}: {_shown(getattr(configuration, entry.name))}'
            for entry in fields(configuration)]


def _shown(value: Any) -> str:
    """Return a value as YAML that keeps its type."""
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, float):
        text = repr(value)
        # YAML 1.1 takes 1e-08 for text: the mantissa needs its dot.
        return text if '.' in text else text.replace('e', '.0e')
    return f"'{value}'" if isinstance(value, str) else str(value)


def write_presets(folder: Path) -> None:
    """Write one file for each preset: ``python -m psane_planner.presets`` in the repository."""
    for name, preset in PRESETS.items():
        (folder / f'{name}.yaml').write_text(yaml_of(preset))


if __name__ == '__main__':
    write_presets(Path(__file__).parents[1] / 'config')
