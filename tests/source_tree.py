# SPDX-License-Identifier: Apache-2.0
"""The source files, what each imports, and which of them may know ROS."""

import ast
import tomllib
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ('psane_mapping', 'psane_planner', 'psane_reactive', 'psane_sim')

# The only files that may import rclpy or a message package. Every other file is core. A new name
# belongs here only when the file converts messages, or wires or starts nodes.
ROS_FILES = (
    '*/*_node.py', '*/ros_*.py', '*/conversions.py', '*/markers.py', '*/trail.py',
    'psane_mapping/quality_of_service.py', 'psane_mapping/running.py',
    'psane_sim/demo/graph_run.py', 'psane_sim/demo/observer.py', 'psane_sim/processes.py',
    'psane_sim/transforms.py',
)

# What a user starts: core itself, but it hands over to files that know ROS.
ENTRY_SCRIPTS = ('psane_sim/bench.py', 'psane_sim/check/command.py', 'psane_sim/demo/command.py',
                 'psane_sim/demo/team_demo.py', 'psane_sim/viewer/command.py',
                 'psane_sim/bags/record.py', 'psane_sim/bags/record_test_bags.py',
                 'psane_sim/bags/replay.py')


def modules_of(package: str) -> list[Path]:
    """Return the Python files of a package."""
    return sorted((ROOT / 'src' / package / package).rglob('*.py'))


def all_modules() -> list[Path]:
    """Return the Python files of all packages."""
    return [path for package in PACKAGES for path in modules_of(package)]


def is_ros_file(path: Path) -> bool:
    """Tell whether a file may know ROS, from its name alone."""
    return any(fnmatch(name_in_package(path), pattern) for pattern in ROS_FILES)


def name_in_package(path: Path) -> str:
    """Return ``package/file.py`` of a source file."""
    return '/'.join(path.relative_to(ROOT / 'src').parts[1:])


def core_modules() -> list[Path]:
    """Return the files that may not know ROS."""
    return [path for path in all_modules() if not is_ros_file(path)]


def imports_of(path: Path) -> set[str]:
    """Return the dotted names that a file imports, inside of functions too."""
    package = path.relative_to(ROOT / 'src').parts[1:-1]
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = '.'.join(package[:len(package) - node.level + 1]) if node.level else ''
            origin = '.'.join(part for part in (base, node.module) if part)
            names.update(f'{origin}.{alias.name}' for alias in node.names)
    return names


def top_level(names: set[str]) -> set[str]:
    """Return the first parts of dotted names."""
    return {name.split('.')[0] for name in names}


def text_files() -> list[Path]:
    """Return every file that is source: what a licence line belongs in."""
    kinds = ('*.py', '*.msg', '*.srv', '*.action', '*.cmake', '*.sh', '*.yaml', '*.cfg',
             'package.xml', 'CMakeLists.txt')
    found = {path for folder in ('src', 'tests', 'cmake', 'setup', 'docker', 'examples')
             for kind in kinds for path in (ROOT / folder).rglob(kind)}
    named = {ROOT / name for name in ('psane', '.ci/run', 'pyproject.toml', 'docker/Dockerfile')}
    return sorted(path for path in found | named
                  if '.egg-info' not in str(path) and ROOT / 'tests' / 'data' not in path.parents)


def project_settings() -> dict[str, dict[str, object]]:
    """Return the tools' settings in pyproject.toml."""
    with (ROOT / 'pyproject.toml').open('rb') as file:
        settings: dict[str, dict[str, object]] = tomllib.load(file)['tool']
    return settings
