# SPDX-License-Identifier: Apache-2.0
"""What keeps the split between core and ROS, and the one direction of imports, from rotting."""

import ast
import re
import sys
import xml.etree.ElementTree as ElementTree

import pytest
from source_tree import (
    ENTRY_SCRIPTS,
    PACKAGES,
    ROOT,
    all_modules,
    core_modules,
    imports_of,
    is_ros_file,
    modules_of,
    name_in_package,
    text_files,
    top_level,
)

MAY_IMPORT = {
    'psane_mapping': {'psane_mapping', 'psane_msgs'},
    'psane_planner': {'psane_planner', 'psane_mapping', 'psane_msgs'},
    'psane_reactive': {'psane_reactive', 'psane_mapping', 'psane_msgs'},
    'psane_sim': {'psane_sim', 'psane_reactive', 'psane_planner', 'psane_mapping', 'psane_msgs'},
}
ROS_PACKAGES = re.compile(
    r'rclpy|rcl_interfaces|builtin_interfaces|ament_index_python|tf2_.*|.*_msgs')
SHAPELESS_NAMES = {'utils', 'util', 'helpers', 'helper', 'common', 'core', 'misc', 'tools'}

# Name of an import -> rosdep key of what brings it, where the two differ.
ROSDEP_KEYS = {
    'contourpy': 'python3-matplotlib', 'cv2': 'python3-opencv',
    'matplotlib': 'python3-matplotlib', 'PIL': 'python3-pil', 'numba': 'python3-numba',
    'numpy': 'python3-numpy', 'pybullet': 'python3-pybullet-pip', 'scipy': 'python3-scipy',
    'pybullet_data': 'python3-pybullet-pip', 'shapely': 'python3-shapely',
    'sklearn': 'python3-sklearn', 'yaml': 'python3-yaml',
}
# Looked for at run time, done without where missing.
OPTIONAL_IMPORTS = {'GPy', 'distributed', 'gpytorch', 'mcap', 'rasterio', 'rosbags', 'tf2_msgs',
                    'tf2_ros', 'torch', 'viser'}


def manifest(package):
    return ElementTree.parse(ROOT / 'src' / package / 'package.xml').getroot()


def entry_points(package):
    tree = ast.parse((ROOT / 'src' / package / 'setup.py').read_text())
    return [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)
            and isinstance(node.value, str) and re.fullmatch(r'\w+ = [\w.]+:\w+', node.value)]


def test_the_source_tree_was_found():
    assert all(len(modules_of(package)) > 1 for package in PACKAGES)
    assert any(is_ros_file(path) for path in all_modules())


@pytest.mark.parametrize('path', core_modules(), ids=lambda path: str(path.relative_to(ROOT)))
def test_a_core_module_imports_no_ros(path):
    offending = {name for name in top_level(imports_of(path)) if ROS_PACKAGES.fullmatch(name)}
    assert not offending, f'{path.name} is core, but imports {sorted(offending)}'


def imports_among(paths, files):
    """Return which of the files import which of the modules at `paths`."""
    modules = {name_in_package(path).removesuffix('.py').replace('/', '.') for path in paths}
    return {(path.name, name) for path in files for name in imports_of(path)
            for module in modules if name == module or name.startswith(f'{module}.')}


def test_a_core_module_imports_no_file_that_knows_ros():
    core = [path for path in core_modules() if name_in_package(path) not in ENTRY_SCRIPTS]
    assert not imports_among(filter(is_ros_file, all_modules()), core)


@pytest.mark.parametrize('package', PACKAGES)
def test_imports_run_one_way_between_packages(package):
    for path in modules_of(package):
        ours = {name for name in top_level(imports_of(path)) if name.startswith('psane_')}
        assert ours <= MAY_IMPORT[package], f'{path} imports {sorted(ours - MAY_IMPORT[package])}'


def test_only_the_simulation_knows_the_simulator():
    knowing = {name_in_package(path).split('/')[0] for path in all_modules()
               if {'pybullet', 'pybullet_data'} & top_level(imports_of(path))}
    assert knowing == {'psane_sim'}


def test_no_module_imports_a_node():
    nodes = [path for path in all_modules() if path.name.endswith('_node.py')]
    assert not imports_among(nodes, all_modules())


def test_no_file_has_a_name_that_says_nothing():
    assert not [path for path in text_files() if path.stem in SHAPELESS_NAMES]


@pytest.mark.parametrize('path', text_files(), ids=lambda path: str(path.relative_to(ROOT)))
def test_every_source_file_names_its_licence(path):
    head = path.read_text(encoding='utf-8').splitlines()[:4]
    assert any('SPDX-License-Identifier: Apache-2.0' in line for line in head)


def test_all_packages_have_one_version():
    versions = {manifest(package).findtext('version') for package in (*PACKAGES, 'psane_msgs')}
    for package in PACKAGES:
        setup = (ROOT / 'src' / package / 'setup.py').read_text()
        versions |= set(re.findall(r"version='([^']+)'", setup))
    versions |= set(re.findall(r'^version: (\S+)$', (ROOT / 'CITATION.cff').read_text(), re.M))
    assert len(versions) == 1


@pytest.mark.parametrize('package', PACKAGES)
def test_every_import_is_a_dependency_of_the_package(package):
    declared = {entry.text for entry in manifest(package) if entry.tag.endswith('depend')}
    imported = {name for path in modules_of(package) for name in top_level(imports_of(path))}
    imported -= set(sys.stdlib_module_names) | OPTIONAL_IMPORTS | {package}
    needed = {ROSDEP_KEYS.get(name, name) for name in imported}
    assert needed <= declared, f'package.xml of {package} lacks {sorted(needed - declared)}'


@pytest.mark.parametrize(('package', 'entry'), [
    (package, entry) for package in PACKAGES for entry in entry_points(package)])
def test_every_executable_has_its_main(package, entry):
    module, function = entry.split(' = ')[1].split(':')
    path = ROOT / 'src' / package / (module.replace('.', '/') + '.py')
    defined = [node.name for node in ast.parse(path.read_text()).body
               if isinstance(node, ast.FunctionDef)]
    assert function in defined


def test_the_readme_names_every_package_executable_and_command():
    text = (ROOT / 'README.md').read_text()
    commands = re.findall(r'^  (\w+)  +\w', (ROOT / 'psane').read_text(), re.M)
    assert len(commands) == 6
    names = [*PACKAGES, 'psane_msgs', *(f'./psane {command}' for command in commands)]
    names += [entry.split(' = ')[0] for package in PACKAGES for entry in entry_points(package)]
    assert not [name for name in names if name not in text]
