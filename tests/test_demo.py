# SPDX-License-Identifier: Apache-2.0
"""The demo: its command line, what it leaves behind, and that it ends well whatever happens."""

import json
import os
import signal
import time
from pathlib import Path

import pytest
from node_process import PATIENCE

from psane_sim.demo.command import BAD_ARGUMENT, NO_SUCCESS, NODE_DIED, main
from psane_sim.runs.truth_log import read_truth

NODES = ('hexapod_sim', 'contact_sensor', 'terrain_mapper', 'safe_planner', 'reactive_controller')
STANDING = 0.04
"""A body slower than this stands [m/s]; it may still sway for a moment. It walks at 0.3."""


def status_of(*arguments):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    return ended.value.code


# --- the command line

@pytest.mark.parametrize(('arguments', 'sentence'), [
    (['--terrain', 'mars2'], "unknown terrain 'mars2'; available: ["),
    (['--goal', '20', '3'], '--goal 20 3: expected a point in [0.3, 9.7]'),
    (['--goal', '0.1', '3'], 'the border of 0.3 m'),
    (['--start', 'nan', '3'], '--start nan 3: expected a point'),
    (['--threshold', '7'], 'slip_threshold = 7.0, expected'),
    (['--duration', '-1'], '--duration -1: expected a value in'),
    (['--seed', '-3'], '--seed -3: expected a value in'),
])
def test_a_bad_argument_gets_a_sentence(arguments, sentence, capsys, tmp_path):
    out = tmp_path / 'out'
    assert status_of('--in-process', *arguments, '--out', str(out)) == BAD_ARGUMENT
    assert sentence in capsys.readouterr().err


def test_a_malformed_terrain_file_is_reported_with_line_and_column(capsys, tmp_path):
    path = tmp_path / 'broken.csv'
    path.write_text('gaussian_x,gaussian_y,std_x,std_y,rotation,amplitude\n'
                    '0.5,0.5,0.1,0.1,0.0,0.9\n0.5,0.5,0.1,wide,0.0,0.9\n')
    assert status_of('--in-process', '--terrain', str(path)) == BAD_ARGUMENT
    said = capsys.readouterr().err
    assert 'line 3' in said
    assert 'wide' in said


def test_help_is_there(capsys):
    assert status_of('--help') == 0
    assert '--in-process' in capsys.readouterr().out


def test_a_goal_in_soft_ground_is_announced_before_the_run(capsys, tmp_path):
    # The middle of a soft hill of env1.
    status = status_of('--in-process', '--goal', '3.75', '3.75', '--duration', '2',
                       '--out', str(tmp_path))
    assert status == NO_SUCCESS
    assert 'cannot be reached over safe ground' in capsys.readouterr().err


# --- what it leaves behind

def test_a_run_leaves_a_summary_and_a_picture(tmp_path):
    assert status_of('--in-process', '--duration', '3', '--out', str(tmp_path)) == NO_SUCCESS
    summary = json.loads((tmp_path / 'summary.json').read_text())
    assert summary['reason'] == 'TIMEOUT'
    assert summary['time_s'] == pytest.approx(3.0, abs=0.01)
    assert (tmp_path / 'run.png').stat().st_size > 50_000


# --- on the graph

def children_of(pid):
    """Return the processes that a process started, with the name of their node."""
    found = {}
    for folder in Path('/proc').iterdir():
        try:
            parent = int((folder / 'stat').read_text().rpartition(')')[2].split()[1])
            words = (folder / 'cmdline').read_bytes().split(b'\0')
        except (OSError, ValueError, IndexError):
            continue
        if parent == pid:
            name = next((Path(w.decode()).name for w in words if b'/lib/psane_' in w), '')
            found[name] = int(folder.name)
    return found


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def simulated_time(out):
    entries = read_truth(out / 'truth.csv') if (out / 'truth.csv').is_file() else []
    return entries[-1].time if entries else 0.0


def start_demo(start_node, out, *arguments):
    """Start the demo on a graph and wait until its robot has walked for a while."""
    demo = start_node('psane_sim', 'demo', '--out', str(out), '--pace', '1.5', *arguments)
    deadline = time.monotonic() + 2.0 * PATIENCE
    while simulated_time(out) < 6.0:
        assert demo.is_running, demo.output
        assert time.monotonic() < deadline, demo.output
        time.sleep(0.1)
    return demo


def test_the_whole_graph_certifies_new_ground_and_moves(start_node, tmp_path):
    demo = start_demo(start_node, tmp_path, '--duration', '25')
    nodes = children_of(demo.pid)
    assert set(NODES) <= set(nodes)
    assert demo.wait() == NO_SUCCESS
    summary = json.loads((tmp_path / 'summary.json').read_text())
    assert summary['reason'] == 'TIMEOUT'
    assert summary['contacts'] > 30
    # One square metre is certified on the first steps; more is won only by walking.
    assert summary['certified_cells'] > 200
    assert summary['path_m'] > 0.8
    assert summary['unsafe_time_s'] == 0.0
    assert summary['false_certified_cells'] == 0
    assert not [name for name, pid in nodes.items() if is_alive(pid)]


def test_the_robot_stands_half_a_second_after_its_controller_was_killed(start_node, tmp_path):
    demo = start_demo(start_node, tmp_path)
    nodes = children_of(demo.pid)
    os.kill(nodes['reactive_controller'], signal.SIGKILL)
    killed = simulated_time(tmp_path)
    assert demo.wait() == NODE_DIED
    assert 'reactive_controller was killed by SIGKILL' in demo.output
    entries = read_truth(tmp_path / 'truth.csv')
    walking = [entry.speed for entry in entries if killed - 3.0 < entry.time < killed]
    # 0.1 s: the log has an entry every 0.05 s, and time went on while it was read.
    after = [entry.speed for entry in entries if entry.time > killed + 0.5 + 0.1]
    assert max(walking) > 5.0 * STANDING
    assert after
    assert max(after) < STANDING
    assert not [name for name, pid in nodes.items() if is_alive(pid)]


@pytest.mark.parametrize('victim', ['terrain_mapper', 'hexapod_sim'])
def test_a_dead_node_is_named_and_nothing_is_left_running(start_node, tmp_path, victim):
    demo = start_demo(start_node, tmp_path)
    nodes = children_of(demo.pid)
    os.kill(nodes[victim], signal.SIGKILL)
    assert demo.wait() == NODE_DIED
    assert f'{victim} was killed by SIGKILL' in demo.output
    assert json.loads((tmp_path / 'summary.json').read_text())['reason'] == 'NODE_DIED'
    assert not [name for name, pid in nodes.items() if is_alive(pid)]


def test_an_interrupt_stops_everything_and_keeps_the_summary(start_node, tmp_path):
    demo = start_demo(start_node, tmp_path)
    nodes = children_of(demo.pid)
    demo.send(signal.SIGINT)
    assert demo.wait() == NO_SUCCESS
    summary = json.loads((tmp_path / 'summary.json').read_text())
    assert summary['reason'] == 'INTERRUPTED'
    assert summary['path_m'] > 0.0
    assert not [name for name, pid in nodes.items() if is_alive(pid)]


def test_nodes_end_when_the_demo_is_killed_without_warning(start_node, tmp_path):
    demo = start_demo(start_node, tmp_path)
    nodes = children_of(demo.pid)
    demo.send(signal.SIGKILL)
    deadline = time.monotonic() + PATIENCE
    while any(map(is_alive, nodes.values())):
        assert time.monotonic() < deadline
        time.sleep(0.1)
