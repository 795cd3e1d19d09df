# SPDX-License-Identifier: Apache-2.0
"""What is made from the declarations of parameters is current, and every YAML file fits them."""

from dataclasses import fields

import pytest
import yaml
from source_tree import ROOT

from psane_sim.generated_text import PARAMETERS, stale

YAML_FILES = sorted(ROOT.glob('src/*/config/*.yaml'))


def test_the_readme_and_the_parameter_files_are_current():
    hint = 'run: ./psane shell python -m psane_sim.generated_text .'
    assert not stale(ROOT), hint


@pytest.mark.parametrize(('package', 'node'), PARAMETERS)
def test_the_parameter_file_of_a_node_sets_every_parameter_to_its_default(package, node):
    path = ROOT / 'src' / package / 'config' / f'{node}.yaml'
    values = yaml.safe_load(path.read_text())[f'/**/{node}']['ros__parameters']
    expected = {entry.name: entry.default for kind in PARAMETERS[package, node]
                for entry in fields(kind)}
    assert values == expected
    for name, value in values.items():
        assert type(value) is type(expected[name]), name
    for kind in PARAMETERS[package, node]:
        kind(**{entry.name: values[entry.name] for entry in fields(kind)})


@pytest.mark.parametrize('path', YAML_FILES, ids=lambda path: path.name)
def test_no_shipped_parameter_file_sets_an_unknown_or_impossible_parameter(path):
    content = yaml.safe_load(path.read_text())
    for scope, part in content.items():
        if not isinstance(part, dict) or 'ros__parameters' not in part:
            continue
        node = scope.split('/')[-1]
        kinds = next(kinds for (_, name), kinds in PARAMETERS.items() if name == node)
        known = {entry.name for kind in kinds for entry in fields(kind)}
        values = part['ros__parameters']
        assert set(values) <= known
        for kind in kinds:
            kind(**{entry.name: values[entry.name] for entry in fields(kind)
                    if entry.name in values})
