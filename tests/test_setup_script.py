# SPDX-License-Identifier: Apache-2.0
"""`./psane` sets up once, builds only what changed, and says what is wrong.

The script runs in a workspace of its own whose path holds a blank; uv, colcon and the compiler are
stand-ins that note that they were called.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from source_tree import ROOT

UV = """#!/bin/bash
case "$1 $2" in
  '--version '*) echo uv 1 ;;
  'python find') echo "$BASE_PYTHON" ;;
  'venv --python') echo "uv $1" >>"$CALLS"; mkdir -p "$4/bin"; ln -s "$3" "$4/bin/python" ;;
  'pip sync') echo "uv $*" >>"$CALLS" ;;
  *) exit 1 ;;
esac
"""
COLCON = """#!/bin/bash
echo colcon >>"$CALLS"
[[ ! -f break ]] || { echo 'a message is wrong'; exit 1; }
sleep 0.3
mkdir -p install/psane_sim/lib/psane_sim build/psane_msgs
echo 'export FROM_WORKSPACE=yes; unset NOT_THERE; : $NOT_THERE' >install/local_setup.bash
cat >install/psane_sim/lib/psane_sim/demo <<'PYTHON'
#!/wrong/python
import os
import sys
print(sys.argv[1:], os.environ['FROM_WORKSPACE'], os.getcwd())
sys.exit(7)
PYTHON
chmod +x install/psane_sim/lib/psane_sim/demo
"""


class Workspace:
    """A copy of the script beside sources of its own."""

    def __init__(self, place: Path) -> None:
        self.root = place / 'a work space'
        self.calls_file = place / 'calls'
        self._commands = place / 'commands'
        self._commands.mkdir()
        for name, text in (('uv', UV), ('colcon', COLCON), ('cc', '#!/bin/true\n'),
                           ('c++', '#!/bin/true\n')):
            (self._commands / name).write_text(text)
            (self._commands / name).chmod(0o755)
        for name in ('psane', 'setup', 'cmake', 'src/psane_msgs', 'src/psane_sim/setup.py',
                     'src/psane_sim/psane_sim/__init__.py', 'requirements.lock'):
            self._copy(name)

    def _copy(self, name: str) -> None:
        source, target = ROOT / name, self.root / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, target)
        else:
            shutil.copy(source, target)

    def start(self, *arguments: str, **settings: str) -> 'subprocess.Popen[str]':
        """Start the script in another folder than its own."""
        environment = {'PATH': f'{self._commands}:/usr/bin:/bin', 'HOME': str(self._commands),
                       'CALLS': str(self.calls_file),
                       'BASE_PYTHON': os.path.realpath(sys.executable), **settings}
        return subprocess.Popen([self.root / 'psane', *arguments], cwd='/', env=environment,
                                text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def run(self, *arguments: str, **settings: str) -> tuple[int, str, str]:
        """Return exit status, standard output and standard error."""
        process = self.start(*arguments, **settings)
        output, errors = process.communicate(timeout=240)
        return process.returncode, output, errors

    def calls(self) -> list[str]:
        """Return which of the stand-ins were called since the last time."""
        lines = self.calls_file.read_text().splitlines() if self.calls_file.exists() else []
        self.calls_file.unlink(missing_ok=True)
        return [' '.join(line.split()[:2]) for line in lines]


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path)


@pytest.fixture
def built(workspace):
    status, _, said = workspace.run('build')
    assert status == 0, said
    assert workspace.calls() == ['uv venv', 'uv pip', 'colcon']
    return workspace


def touch(path, text='# more\n'):
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open('a') as file:
        file.write(text)


def test_help_needs_nothing_and_names_every_command(workspace):
    for arguments in ((), ('--help',), ('help',), ('-h',), ('run', '--help')):
        status, output, _ = workspace.run(*arguments)
        assert status == 0
        for command in ('demo', 'test', 'build', 'run', 'shell', 'bench'):
            assert f'\n  {command} ' in output
    assert not workspace.calls()


def test_an_unknown_command_is_refused_with_the_list(workspace):
    status, output, errors = workspace.run('dance')
    assert (status, output) == (2, '')
    assert "unknown command 'dance'" in errors and 'bench' in errors


def test_an_unknown_choice_of_ros_is_refused(workspace):
    status, _, errors = workspace.run('build', PSANE_ROS='2')
    assert status == 1 and "PSANE_ROS = '2', expected apt or wheels" in errors


def test_a_second_start_installs_and_builds_nothing(built):
    assert built.run('build')[0] == 0
    assert built.run('shell', 'true')[0] == 0
    assert built.calls() == []


@pytest.mark.parametrize(('changed', 'calls'), [
    ('src/psane_msgs/msg/Ring.msg', ['colcon']),
    ('src/psane_msgs/msg/New.msg', ['colcon']),
    ('src/psane_sim/setup.py', ['colcon']),
    ('src/psane_sim/config/new.yaml', ['colcon']),
    ('cmake/fix_wheel_paths.cmake', ['colcon']),
    ('requirements.lock', ['uv venv', 'uv pip', 'colcon']),
    ('src/psane_sim/psane_sim/__init__.py', []),
    ('src/psane_sim/psane_sim/new.py', []),
])
def test_only_what_depends_on_a_change_is_made_again(built, changed, calls):
    touch(built.root / changed)
    assert built.run('build')[0] == 0
    assert built.calls() == calls
    assert built.run('build')[0] == 0
    assert built.calls() == []


def test_a_workspace_that_was_moved_is_made_anew(built):
    moved = built.root.with_name('another place')
    built.root.rename(moved)
    built.root = moved
    assert built.run('build')[0] == 0
    assert built.calls() == ['uv venv', 'uv pip', 'colcon']


def test_a_forced_build_builds_although_nothing_changed(built):
    assert built.run('build', '--force')[0] == 0
    assert built.calls() == ['colcon']


def test_a_failed_build_shows_its_log_and_is_tried_again(built):
    touch(built.root / 'break')
    touch(built.root / 'src/psane_msgs/msg/Ring.msg')
    for _ in range(2):
        status, _, errors = built.run('demo')
        assert status == 1
        assert 'a message is wrong' in errors and '.psane/logs/build.log' in errors
        assert built.calls() == ['colcon']
    (built.root / 'break').unlink()
    assert built.run('build')[0] == 0


def test_after_a_failed_build_an_undone_change_is_built_again(built):
    message = built.root / 'src/psane_msgs/msg/Ring.msg'
    before = message.read_text()
    touch(built.root / 'break')
    touch(message)
    assert built.run('build')[0] == 1
    (built.root / 'break').unlink()
    message.write_text(before)
    assert built.run('build')[0] == 0
    assert built.calls() == ['colcon', 'colcon']


def test_two_starts_at_once_build_once(workspace):
    started = [workspace.start('build') for _ in range(3)]
    said = [process.communicate(timeout=240)[1] for process in started]
    assert [process.returncode for process in started] == [0, 0, 0], said
    assert sorted(workspace.calls()) == ['colcon', 'uv pip', 'uv venv']


def test_an_executable_gets_its_arguments_and_gives_its_status(built):
    for command in (('demo',), ('run', 'psane_sim', 'demo')):
        status, output, _ = built.run(*command, '--goal', 'a b')
        assert (status, output) == (7, "['--goal', 'a b'] yes /\n")


def test_what_is_said_of_the_set_up_leaves_standard_output_alone(workspace):
    status, output, errors = workspace.run('demo')
    assert (status, output) == (7, '[] yes /\n')
    assert 'building the workspace' in errors


@pytest.mark.parametrize('asked', [('psane_sim', 'dmo'), ('psane_sim',), ('nothing', 'demo')])
def test_an_unknown_executable_is_refused_with_the_list(built, asked):
    status, output, errors = built.run('run', *asked)
    assert (status, output) == (2, '')
    assert 'unknown executable' in errors and '  psane_sim demo\n' in errors


def test_another_ros_does_not_leak_into_the_wheels(built):
    status, output, _ = built.run(
        'shell', 'env', ROS_DISTRO='humble', PYTHONPATH='/opt/ros/humble/lib', ROS_DOMAIN_ID='7',
        LD_LIBRARY_PATH='/opt/ros/humble/lib:/opt/mine', RMW_IMPLEMENTATION='rmw_other')
    seen = dict(line.split('=', 1) for line in output.splitlines() if '=' in line)
    assert status == 0 and 'PYTHONPATH' not in seen
    assert (seen['ROS_DISTRO'], seen['ROS_DOMAIN_ID']) == ('jazzy', '7')
    assert seen['LD_LIBRARY_PATH'] == '/opt/mine'
    assert seen['RMW_IMPLEMENTATION'] == 'rmw_fastrtps_cpp'


def test_the_settings_of_the_user_win_over_ours(built):
    _, output, _ = built.run('shell', 'env', OMP_NUM_THREADS='4')
    assert 'OMP_NUM_THREADS=4\n' in output and 'OPENBLAS_NUM_THREADS=1\n' in output


def numba_cache(workspace, **settings):
    status, output, _ = workspace.run('shell', 'printenv', 'NUMBA_CACHE_DIR', **settings)
    assert status == 0
    return Path(output.rstrip('\n'))


def test_machine_code_is_kept_until_a_compiled_source_changes(built):
    compiled = built.root / 'src/psane_sim/psane_sim/soils/soil.py'
    touch(compiled, '@njit\ndef f(): ...\n')
    first = numba_cache(built)
    assert first.parent == built.root / '.psane/numba' and first.is_dir()
    touch(built.root / 'src/psane_sim/psane_sim/plain.py')
    assert numba_cache(built) == first
    touch(compiled)
    assert numba_cache(built, NUMBA_CACHE_DIR=str(first)) not in (first, first.parent)
    assert numba_cache(built, NUMBA_CACHE_DIR='/elsewhere') == Path('/elsewhere')


def test_machine_code_that_nobody_used_for_a_day_is_removed(built):
    current = numba_cache(built)
    old, recent = current.with_name('old'), current.with_name('recent')
    old.mkdir()
    recent.mkdir()
    os.utime(old, (0, 0))
    os.utime(current, (0, 0))
    assert numba_cache(built) == current
    assert current.is_dir() and recent.is_dir() and not old.exists()
