# SPDX-License-Identifier: Apache-2.0
"""The whole command on short tasks: rows, resuming, replay, pictures and the page."""

import base64
import json
import re
import shutil
import sys
import types
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from paper_rows import SHORT
from PIL import Image

from psane_mapping.grid import Grid
from psane_sim import benchmark
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.paper import command as paper
from psane_sim.paper.html_report import Picture, Section, as_html, html_report
from psane_sim.paper.task import Robot
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.runs.animation import FRAME_TIME, SIZE, Posture, animate, map_picture, pixels_of
from psane_sim.runs.run_data import StoredRun
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.terrains.terrain import Terrain

TASKS = (replace(SHORT, duration=11.0),
         replace(SHORT, name='explore_short', has_goal=False, duration=11.0))

UNTIMED = {'timing': {'work_s': 0.0}}


def run(*arguments):
    with pytest.raises(SystemExit) as status:
        benchmark.main([str(argument) for argument in arguments])
    return status.value.code


@pytest.fixture(scope='module')
def experiment(tmp_path_factory):
    out = tmp_path_factory.mktemp('paper')
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paper, 'PAPER_TASKS', TASKS)
        assert run('paper', '--kinematic', '--trials', 1, '--strategies', 'psane_geodesic', 'ngh',
                   '--workers', 1, '--out', out) == 0
    return out


def rows_of(folder):
    return {path.stem: json.loads(path.read_text()) for path in (folder / 'rows').glob('*.json')}


def test_the_experiment_leaves_rows_tables_figures_and_a_page(experiment):
    assert set(rows_of(experiment)) == {
        f'{task.name}-{strategy}-0' for task in TASKS for strategy in ('psane_geodesic', 'ngh')}
    for name in ('table.md', 'table.tex', 'table.csv', 'trials.csv'):
        assert (experiment / name).stat().st_size > 200
    pictures = {path.name for path in experiment.glob('*.png')}
    assert pictures >= {'bars.png', 'paths_goal_short.png', 'paths_explore_short.png',
                        'coverage_explore_short.png', 'certified_explore_short.png',
                        'pipeline_goal_short.png'}


def test_every_picture_is_on_the_page_and_the_page_names_no_other_file(experiment):
    page = (experiment / 'report.html').read_text()
    assert page.count('<img ') == len(list(experiment.glob('*.png')))
    sources = re.findall(r'(?:src|href)="([^"]{0,40})', page)
    assert sources and all(source.startswith(('data:image/', '#')) for source in sources)
    assert not re.search(r'url\(|@import|<script|<link', page)


def test_an_experiment_that_was_broken_off_goes_on_and_keeps_its_rows(experiment, tmp_path,
                                                                       monkeypatch, capsys):
    monkeypatch.setattr(paper, 'PAPER_TASKS', TASKS)
    copy = tmp_path / 'copy'
    shutil.copytree(experiment, copy)
    missing = copy / 'rows' / 'goal_short-ngh-0.json'
    before = json.loads(missing.read_text())['summary']
    missing.unlink()
    kept = (copy / 'rows' / 'goal_short-psane_geodesic-0.json').read_bytes()
    assert run('paper', '--kinematic', '--trials', 1, '--strategies', 'psane_geodesic', 'ngh',
               '--workers', 1, '--out', copy) == 0
    assert '3 of 4 trials are there already' in capsys.readouterr().err
    assert (copy / 'rows' / 'goal_short-psane_geodesic-0.json').read_bytes() == kept
    assert json.loads(missing.read_text())['summary'] == before


def test_rows_of_another_configuration_are_not_mixed_in(experiment, monkeypatch, capsys):
    monkeypatch.setattr(paper, 'PAPER_TASKS', TASKS)
    assert run('paper', '--kinematic', '--preset', 'published', '--trials', 1, '--out',
               experiment) == 2
    assert 'another configuration' in capsys.readouterr().err


def test_a_replayed_row_has_the_same_summary_byte_for_byte(experiment, tmp_path, capsys):
    picture = tmp_path / 'pipeline.png'
    assert run('replay', experiment, 'goal_short-psane_geodesic-0', '--at', 6, '--out',
               picture) == 0
    assert 'byte for byte' in capsys.readouterr().out
    assert picture.stat().st_size > 20_000


def test_a_row_that_was_tampered_with_is_told_from_its_replay(experiment, tmp_path, capsys):
    copy = tmp_path / 'copy'
    shutil.copytree(experiment, copy)
    path = copy / 'rows' / 'explore_short-ngh-0.json'
    row = json.loads(path.read_text())
    row['summary']['contacts'] += 1
    path.write_text(json.dumps(row))
    assert run('replay', copy, 'explore_short-ngh-0') == 1
    assert 'contacts: ' in capsys.readouterr().out


@pytest.mark.parametrize(('arguments', 'words'), [
    (('replay', 'no/such/folder', 'row'), 'is no folder'),
    (('paper', '--trials', 0), 'at least 1'),
    (('paper', '--terrain', 'mars2'), "unknown terrain 'mars2'")])
def test_bad_arguments_are_answered_in_words(arguments, words, capsys):
    assert run(*arguments) == 2
    assert words in capsys.readouterr().err


def test_an_unknown_row_is_answered_with_the_list(experiment, capsys):
    assert run('replay', experiment, 'goal_mars-psane-0') == 2
    assert 'goal_short-ngh-0' in capsys.readouterr().err


def test_a_report_of_a_part_runs_nothing_and_leaves_out_what_is_missing(experiment, tmp_path,
                                                                        monkeypatch, capsys):
    monkeypatch.setattr(paper, 'PAPER_TASKS', TASKS)
    copy = tmp_path / 'copy'
    shutil.copytree(experiment, copy)
    for path in (copy / 'rows').glob('*ngh*'):
        path.unlink()
    names = set(rows_of(copy))
    assert run('paper', '--kinematic', '--trials', 5, '--report-only', '--out', copy) == 0
    assert set(rows_of(copy)) == names
    assert '| ngh |' not in capsys.readouterr().out
    assert run('paper', '--kinematic', '--report-only', '--out', tmp_path / 'empty') == 2
    assert 'holds no trial yet' in capsys.readouterr().err


class FakeFuture:
    def __init__(self, value):
        self._value = value

    def result(self):
        return self._value


class FakeClient:
    """A cluster that runs everything at once, in this process."""

    def __init__(self, address, timeout):
        assert address == 'tcp://there:8786'

    def __enter__(self):
        return self

    def __exit__(self, *problem):
        return None

    def map(self, run_one, trials, shared, pure):
        return [FakeFuture(run_one(made, shared=shared)) for made in trials]


def test_rows_and_runs_that_a_cluster_made_are_written_here(tmp_path, monkeypatch):
    module = types.SimpleNamespace(Client=FakeClient, as_completed=iter)
    monkeypatch.setitem(sys.modules, 'distributed', module)
    monkeypatch.setattr(paper, 'PAPER_TASKS', TASKS[1:])
    assert run('paper', '--kinematic', '--trials', 2, '--strategies', 'ngh', '--scheduler',
               'tcp://there:8786', '--out', tmp_path) == 0
    assert set(rows_of(tmp_path)) == {'explore_short-ngh-0', 'explore_short-ngh-1'}
    assert len(list((tmp_path / 'runs').glob('*.npz'))) == 2


# --- terrains that make no sense

def test_a_senseless_terrain_is_reported_before_the_run(tmp_path, monkeypatch, capsys):
    slip = np.full((201, 201), 0.1)
    slip[90:110] = 1.0
    made = Terrain.from_slip('walled', slip, (5.0, 2.0), (5.0, 8.0))
    monkeypatch.setattr(paper, 'load_terrain', lambda name: made)
    monkeypatch.setattr(paper, 'PAPER_TASKS', TASKS[:1])
    monkeypatch.setattr(paper, '_run_missing', lambda *everything: {'some': UNTIMED})
    monkeypatch.setattr(paper, 'PaperReport', SilentReport)
    (tmp_path / 'table.md').write_text('')
    assert run('paper', '--out', tmp_path, '--tasks', TASKS[0].name) == 0
    assert 'cannot be reached over safe ground' in capsys.readouterr().err


class SilentReport:
    """Writes nothing of rows that a test has made up."""

    def __init__(self, *everything):
        pass

    def write(self):
        pass


def test_a_terrain_of_ones_own_is_a_further_task(tmp_path, monkeypatch):
    mine = tmp_path / 'my map.npy'
    np.save(mine, np.full((20, 20), 0.1))
    asked = []
    monkeypatch.setattr(paper, '_run_missing',
                        lambda trials, *rest: asked.extend(trials) or {'some': UNTIMED})
    monkeypatch.setattr(paper, 'PaperReport', SilentReport)
    (tmp_path / 'table.md').write_text('')
    assert run('paper', '--out', tmp_path, '--tasks', 'goal_env1', '--trials', 2, '--terrain',
               mine) == 0
    assert {(made.task.name, made.task.terrain) for made in asked} == {
        ('goal_env1', 'env1'), ('goal_my_map', str(mine))}
    assert len(asked) == 2 * 2 * 5


# --- the page

def test_markdown_becomes_tables_lists_and_paragraphs_with_everything_escaped():
    made = as_html('### A & b\n\n| a | b |\n|---|---|\n| 1 < 2 | `x` |\n\n- one\n- two\n\n'
                   'some\ntext')
    assert '<h3>A &amp; b</h3>' in made and '<td>1 &lt; 2</td>' in made
    assert '<code>x</code>' in made and made.count('<li>') == 2 and '<p>some text</p>' in made


def chromium():
    return next((path for path in map(shutil.which, ('chromium', 'chromium-browser',
                                                     'google-chrome')) if path), None)


@pytest.mark.skipif(chromium() is None, reason='no chromium is installed')
def test_a_browser_shows_the_page_without_a_request_an_error_or_a_missing_picture(experiment):
    sync_api = pytest.importorskip('playwright.sync_api', reason='no playwright is installed')
    requests, said = [], []
    with sync_api.sync_playwright() as player:
        browser = player.chromium.launch(
            executable_path=chromium(), args=['--no-sandbox', '--disable-background-networking'])
        page = browser.new_page()
        page.on('request', lambda request: requests.append(request.url))
        page.on('console', lambda message: said.append(message.text))
        page.on('pageerror', lambda error: said.append(str(error)))
        page.goto((experiment / 'report.html').as_uri(), wait_until='load')
        widths = page.eval_on_selector_all('img', 'all => all.map(one => one.naturalWidth)')
        heading = page.inner_text('h1')
        rows = page.locator('table tbody tr').count()
        browser.close()
    assert len(widths) == len(list(experiment.glob('*.png'))) and min(widths) > 300
    assert {url for url in requests if not url.startswith('data:')} == {
        (experiment / 'report.html').as_uri()}
    assert said == []
    assert 'kinematic' in heading and rows >= 8


def test_the_page_forbids_its_browser_every_request():
    page = html_report('a title', [Section('one', 'text')])
    assert "default-src 'none'; img-src data:" in page


# --- the moving picture

@pytest.fixture(scope='module')
def walked():
    terrain = load_terrain('env1')
    postures = []
    with HexapodSimulator(SimulatorConfiguration(), terrain, (2.0, 5.0, 0.0)) as simulator:
        simulator.command(0.25, 0.0)
        for _ in range(6):
            simulator.step(200)
            truth = simulator.truth()
            postures.append((truth.time, *truth.position, *truth.quaternion, *truth.joint_angle))
    rows = np.array(postures, dtype=np.float32)
    nothing = np.empty((0, 3))
    return terrain, truth, StoredRun(
        grid=Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1), path=rows[:, :3], contacts=nothing,
        postures=rows, subgoals=nothing, coverage=nothing, certified=None, moments=())


def test_a_stored_posture_has_the_heading_of_the_truth(walked):
    _, truth, run_ = walked
    row = run_.postures[-1].astype(float)
    assert Posture(row[1:4], row[4:8], row[8:]).yaw == pytest.approx(truth.yaw, abs=1e-5)


def test_the_moving_picture_shows_the_robot_walk(walked, tmp_path):
    terrain, _, run_ = walked
    path = tmp_path / 'run.webp'
    animate(run_, terrain, 0.5, path)
    with Image.open(path) as picture:
        assert picture.n_frames == 6
        assert picture.size == (SIZE[0] + SIZE[1], SIZE[1])
        frames = []
        for index in range(picture.n_frames):
            picture.seek(index)
            frames.append(np.asarray(picture.convert('RGB'), dtype=int))
    for first, second in zip(frames, frames[1:], strict=False):
        assert np.abs(first - second).max() > 60, 'the legs move from frame to frame'
    assert FRAME_TIME > 0


def test_a_point_of_the_map_is_where_its_picture_says():
    size = 301
    corners = np.array([[0.0, 0.0], [10.0, 10.0], [5.0, 2.5]])
    np.testing.assert_array_equal(pixels_of(corners, size), [[0, 300], [300, 0], [150, 225]])
    terrain = load_terrain('env1')
    picture = map_picture(terrain, 0.5, size)
    column, row = pixels_of(np.array([terrain.goal]), size)[0]
    assert tuple(picture[row, column]) == (255, 200, 0)


def test_the_report_of_the_kinematic_robot_has_no_moving_picture(experiment):
    assert not list(experiment.glob('*.webp'))
    assert all(row['robot'] == Robot.KINEMATIC.value for row in rows_of(experiment).values())


def test_a_picture_is_inlined_whole(tmp_path):
    path = Path(tmp_path / 'dot.png')
    path.write_bytes(b'\x89PNG and so on')
    page = html_report('t', [Section('s', '', [Picture(path, 'a "dot" & more')])])
    data = re.search(r'base64,([^"]+)"', page)
    assert data and base64.b64decode(data[1]) == path.read_bytes()
    assert 'a &quot;dot&quot; &amp; more' in page
