# SPDX-License-Identifier: Apache-2.0
"""The image is built by the very steps that the README gives for apt."""

import os
import re
import signal
import subprocess
import sys

import yaml
from source_tree import PACKAGES, ROOT, modules_of


def section(text, begin, end):
    return text[text.index(begin) + len(begin):text.index(end)]


def apt_packages(text):
    """Return the packages of the first `apt-get install` in a text."""
    command = re.search(r'apt-get install -y --no-install-recommends((?:[^\n]*\\\n)*[^\n]*)', text)
    words = command.group(1).replace('\\\n', ' ').split('&&')[0].split()
    return sorted(words)


def pip_packages(text):
    return sorted(re.findall(r"'([a-z][a-z0-9-]*==[\d.]+)'", text))


def test_readme_and_dockerfile_install_the_same():
    readme = section((ROOT / 'README.md').read_text(), '<!-- apt:begin -->', '<!-- apt:end -->')
    dockerfile = (ROOT / 'docker' / 'Dockerfile').read_text()
    assert len(apt_packages(readme)) > 5
    assert apt_packages(readme) == apt_packages(dockerfile)
    assert len(pip_packages(readme)) == 7
    assert pip_packages(readme) == pip_packages(dockerfile)
    for step in ('source /opt/ros/jazzy/setup.bash', './psane build'):
        assert step in readme
        assert step in dockerfile


def services():
    return yaml.safe_load((ROOT / 'docker' / 'compose.yaml').read_text())['services']


def nodes():
    """Return (package, executable) of each node, as its file says."""
    found = [path for package in PACKAGES for path in modules_of(package)
             if path.name.endswith('_node.py')]
    return {(path.parts[-2], path.name.removesuffix('_node.py')) for path in found}


def test_there_is_one_service_for_each_node_and_one_for_the_demo():
    running = {name: service['command'] for name, service in services().items()}
    assert running.pop('demo')[0] == 'demo'
    assert sorted((command[1], command[2]) for command in running.values()) == sorted(nodes())
    assert {command[0] for command in running.values()} == {'run'}


def test_each_service_of_a_node_asks_for_the_health_of_that_node():
    for name, service in services().items():
        if name == 'demo':
            continue
        how, entrypoint, script, node = service['healthcheck']['test']
        assert (how, entrypoint) == ('CMD', '/ros_entrypoint.sh')
        assert os.access(ROOT / script, os.X_OK)
        assert node == service['command'][2]


def test_every_node_but_the_simulator_runs_on_its_clock():
    for service in services().values():
        if service['command'][0] == 'run':
            is_simulator = service['command'][2] == 'hexapod_sim'
            assert ('use_sim_time:=true' in service['command']) != is_simulator


def test_the_image_does_not_run_as_root_and_may_write_where_it_must():
    lines = (ROOT / 'docker' / 'Dockerfile').read_text().splitlines()
    users = [line.split()[1] for line in lines if line.startswith('USER ')]
    assert users == ['1000:1000']
    at = lines.index('USER 1000:1000')
    assert not any('apt-get' in line or 'pip3' in line for line in lines[at:])
    assert all('--chown=1000:1000' in line for line in lines if line.startswith('COPY '))
    made = next(line for line in lines if 'install -d -o 1000 -g 1000' in line)
    assert {'/psane', '/out'} <= set(made.split())


def health_of(node, patience):
    script = ROOT / 'docker' / 'is_healthy.py'
    return subprocess.run([sys.executable, str(script), node, '--patience', str(patience)],
                          check=False).returncode


def test_a_running_node_is_healthy_and_one_that_is_not_there_is_not(start_node):
    mapper = start_node('psane_mapping', 'terrain_mapper')
    assert health_of('terrain_mapper', 90.0) == 0
    assert health_of('safe_planner', 3.0) == 1
    mapper.send(signal.SIGSTOP)
    try:
        assert health_of('terrain_mapper', 3.0) == 1
    finally:
        mapper.send(signal.SIGCONT)
