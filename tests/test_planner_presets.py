# SPDX-License-Identifier: Apache-2.0
"""The shipped presets: each sets every parameter, none that is unknown, and to what it says."""

from dataclasses import asdict

import pytest
import yaml
from source_tree import ROOT

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.parameters import from_mapping
from psane_planner.configuration import PlannerConfiguration
from psane_planner.presets import PRESETS, write_presets

FOLDER = ROOT / 'src' / 'psane_planner' / 'config'


def values_in(name):
    content = yaml.safe_load((FOLDER / f'{name}.yaml').read_text())
    assert set(content) == {'/**/terrain_mapper', '/**/safe_planner'}
    return {node.split('/')[-1]: part['ros__parameters'] for node, part in content.items()}


@pytest.mark.parametrize('name', PRESETS)
def test_a_preset_s_file_sets_every_parameter_with_its_type_and_none_that_is_unknown(name):
    values = values_in(name)
    for node, kind, preset in (
            ('terrain_mapper', MappingConfiguration, PRESETS[name].mapping),
            ('safe_planner', PlannerConfiguration, PRESETS[name].planner)):
        assert from_mapping(kind, values[node]) == preset
        expected = asdict(preset)
        assert values[node] == expected
        assert {key: type(value) for key, value in values[node].items()} == {
            key: type(value) for key, value in expected.items()}


def test_the_default_preset_is_the_defaults():
    assert PRESETS['default'].planner == PlannerConfiguration()
    assert PRESETS['default'].mapping == MappingConfiguration()


def test_the_published_preset_has_the_published_numbers():
    mapping, planner = PRESETS['published'].mapping, PRESETS['published'].planner
    assert (planner.confidence_scale, planner.slip_threshold, planner.lipschitz_constant,
            planner.expansion_rate, planner.goal_decay) == (3.0, 0.5, 2.0, 0.1, 0.1)
    assert (mapping.lengthscale, mapping.slip_prior_deviation) == (0.6, 0.5)
    assert planner.strategy == 'psane'


def test_the_files_are_what_the_command_writes(tmp_path):
    write_presets(tmp_path)
    for name in PRESETS:
        assert (tmp_path / f'{name}.yaml').read_text() == (FOLDER / f'{name}.yaml').read_text(), (
            'run: python -m psane_planner.presets')
