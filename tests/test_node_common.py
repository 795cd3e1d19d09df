# SPDX-License-Identifier: Apache-2.0
"""What all five nodes have in common: a report a second, and parameters that mind their range."""

from dataclasses import fields

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from node_process import NodeProcess
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from source_tree import ROOT

from psane_mapping.parameters import declaration_of, kind_of
from psane_mapping.quality_of_service import DEFAULT
from psane_sim.generated_text import PARAMETERS


@pytest.fixture(scope='module')
def all_nodes(tmp_path_factory):
    logs = tmp_path_factory.mktemp('nodes')
    started = [NodeProcess(ROOT / 'install', package, executable, (), logs / f'{executable}.log')
               for package, executable in PARAMETERS]
    yield
    for process in started:
        process.stop()


def declared(name):
    """Return the fields of a node's parameters, by name."""
    kinds = next(kinds for (_, executable), kinds in PARAMETERS.items() if executable == name)
    return {entry.name: entry for kind in kinds for entry in fields(kind)}


def call(probe, kind, service, request):
    client = probe.node.create_client(kind, service)
    probe.until(client.service_is_ready)
    future = client.call_async(request)
    probe.until(future.done)
    probe.node.destroy_client(client)
    return future.result()


def put(probe, node, **values):
    """Set parameters together; return whether that was taken, and what was said."""
    parameters = [Parameter(name, value=value).to_parameter_msg()
                  for name, value in values.items()]
    result = call(probe, SetParametersAtomically, f'/{node}/set_parameters_atomically',
                  SetParametersAtomically.Request(parameters=parameters)).result
    return result.successful, result.reason


def values_of(probe, node, names):
    answer = call(probe, GetParameters, f'/{node}/get_parameters',
                  GetParameters.Request(names=list(names)))
    return dict(zip(names, map(Parameter.from_parameter_msg, (
        _named(name, value) for name, value in zip(names, answer.values, strict=True))),
        strict=True))


def _named(name, value):
    from rcl_interfaces.msg import Parameter as Message
    return Message(name=name, value=value)


def test_every_node_reports_on_diagnostics(all_nodes, probe):
    probe.listen(DiagnosticArray, '/diagnostics', DEFAULT)

    def reports():
        return {status.name: status for array in probe.heard['/diagnostics']
                for status in array.status}
    wanted = {f'/{executable}' for _, executable in PARAMETERS}
    probe.until(lambda: wanted <= set(reports()))
    for name in wanted:
        assert reports()[name].message and reports()[name].hardware_id == 'psane'


@pytest.mark.parametrize('node', [executable for _, executable in PARAMETERS])
def test_every_parameter_has_its_default_until_it_is_set(all_nodes, probe, node):
    entries = declared(node)
    values = values_of(probe, node, entries)
    assert {name: value.value for name, value in values.items()} == {
        name: entry.default for name, entry in entries.items()}


@pytest.mark.parametrize('node', [executable for _, executable in PARAMETERS])
def test_what_may_change_changes_and_what_is_fixed_or_out_of_range_does_not(
        all_nodes, probe, node):
    entries = declared(node)
    changed = 0
    for name, entry in entries.items():
        rules = declaration_of(entry)
        if rules.read_only:
            other = not entry.default if kind_of(entry) is bool else entry.default
            if kind_of(entry) in (int, float):
                other = entry.default + 1
            elif kind_of(entry) is str:
                other = f'{entry.default}x'
            assert not put(probe, node, **{name: other})[0], name
            continue
        assert put(probe, node, **{name: entry.default}) == (True, ''), name
        if kind_of(entry) is float and rules.high is not None:
            taken, said = put(probe, node, **{name: 2.0 * abs(rules.high) + 1.0})
            assert not taken and said, name
        if kind_of(entry) is float and rules.low is not None and rules.high is not None:
            near = entry.default + 1e-6 * (rules.high - entry.default)
            if put(probe, node, **{name: near})[0]:
                changed += 1
                assert values_of(probe, node, [name])[name].value == near
                assert put(probe, node, **{name: entry.default})[0]
    if any(not declaration_of(entry).read_only and kind_of(entry) is float
           for entry in entries.values()):
        assert changed > 0
