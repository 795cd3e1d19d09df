# SPDX-License-Identifier: Apache-2.0
"""The live view in a browser: nothing from outside, a robot that moves, goals by click."""

import time
from types import SimpleNamespace

import numpy as np
import pytest
from browser_page import (
    CHROMIUM,
    HEIGHT,
    PATIENCE,
    SOFTWARE_GRAPHICS,
    WIDTH,
    WITHOUT,
    Page,
    changed,
    drawn_by,
    pixel_of,
)
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry

from psane_mapping.conversions import occupancy_message
from psane_mapping.grid import Grid
from psane_mapping.leg import RobotModel
from psane_mapping.quality_of_service import DEFAULT, LATCHED, ODOMETRY

pytest.importorskip('viser')
playwright = pytest.importorskip('playwright.sync_api')
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason=WITHOUT)

GRID = Grid.over_workspace(0.0, 0.0, 10.0, 10.0, 0.1)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
HERE, THERE = np.array([3.0, 3.0, 0.12]), np.array([5.5, 5.5, 0.12])
MIDDLE = np.array([5.0, 5.0, 0.12])
SIZE = (480, 320)
NEAR = 25
"""Pixels around a robot's place on the picture within which it is drawn; it is 15 long."""


@pytest.fixture(scope='module')
def browser():
    with playwright.sync_playwright() as player:
        opened = player.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE_GRAPHICS)
        yield opened
        opened.close()


@pytest.fixture
def open_page(browser):
    """Open addresses; the pages are closed at the end."""
    pages = []

    def opened(address):
        pages.append(Page(browser, address))
        return pages[-1]

    yield opened
    for page in pages:
        page.page.close()


@pytest.fixture
def scene():
    """A live view of one robot on a map, as a server in this process."""
    from psane_sim.viewer.live_view import LiveView
    from psane_sim.viewer.server import address_of, open_server
    server = open_server()
    view = LiveView(server, [''], RobotModel(), record=True)
    view.take_map('slip', GRID, np.full(GRID.shape, 0.2))
    view.robot('').take_pose(HERE, LEVEL)
    view.take_time(time.monotonic(), 0.0)
    view.draw(time.monotonic())
    yield SimpleNamespace(server=server, view=view, address=address_of(server))
    server.stop()


def client_of(page, server):
    """Wait until the page has said where its camera is."""
    page.wait(server.get_clients)
    return next(iter(server.get_clients().values()))


def share_near(mask, *places):
    """Return which share of the marked dots is near one of some places on the picture."""
    marked = np.argwhere(mask)[:, ::-1]
    away = np.min([np.hypot(*(marked - place).T) for place in places], axis=0)
    return float((away < NEAR).mean())


def settled(page, client):
    """Return what a page draws once it has drawn the same twice."""
    drawn = [drawn_by(client, *SIZE)]

    def is_settled():
        drawn.append(drawn_by(client, *SIZE))
        return not changed(*drawn[-2:]).any() and drawn[-1].std() > 0.02

    page.wait(is_settled)
    return drawn[-1]


def drawn_anew(page, client, before):
    """Return what a page draws once it differs from an earlier picture."""
    page.wait(lambda: changed(before, drawn_by(client, *SIZE)).any())
    return settled(page, client)


def test_the_robot_is_where_it_should_be_and_moves_and_nobody_else_is_asked(open_page, scene):
    page = open_page(scene.address)
    client = client_of(page, scene.server)
    before = settled(page, client)
    scene.view.robot('').take_pose(THERE, LEVEL)
    scene.view.draw(time.monotonic())
    after = drawn_anew(page, client, before)
    difference = changed(before, after)
    here, there = (pixel_of(client.camera, place, *SIZE) for place in (HERE, THERE))
    assert np.hypot(*(here - there)) > 2.0 * NEAR
    assert share_near(difference, here, there) > 0.95
    for place in (here, there):
        x, y = np.round(place).astype(int)
        assert difference[y - 5:y + 6, x - 5:x + 6].any()
    scene.view.robot('').take_joints(np.full(6, np.pi))
    scene.view.draw(time.monotonic())
    legs = changed(after, drawn_anew(page, client, after))
    assert share_near(legs, there) > 0.95
    assert len(page.requests) >= 2
    assert not page.outside_requests(scene.address, scene.address.replace('http', 'ws'))


def test_the_layers_are_switched_on_the_page(open_page, scene):
    scene.view.take_map('uncertainty', GRID, np.full(GRID.shape, 0.45))
    scene.view.draw(time.monotonic() + 1.0)
    page = open_page(scene.address)
    client = client_of(page, scene.server)
    slip = settled(page, client)
    page.page.locator('input[value=slip]').first.click()
    page.page.get_by_role('option', name='uncertainty').click()
    uncertainty = drawn_anew(page, client, slip)
    x, y = np.round(pixel_of(client.camera, (1.5, 4.5, 0.0), *SIZE)).astype(int)
    # 0.2 of 1 is blue in the one colour map, 0.45 of 0.5 is yellow-green in the other.
    assert slip[y, x, 2] > slip[y, x, 0]
    assert uncertainty[y, x, 1] > uncertainty[y, x, 2] + 0.2


def test_the_exported_page_replays_the_run_and_asks_nobody(open_page, scene, tmp_path):
    for step in range(41):
        scene.view.take_time(time.monotonic(), 0.25 * step)
        scene.view.robot('').take_pose(MIDDLE + (THERE - MIDDLE) * step / 40.0, LEVEL)
        scene.view.draw(time.monotonic())
    page_file = tmp_path / 'run.html'
    scene.view.write(page_file)
    page = open_page(page_file.as_uri())
    timeline = page.page.locator('input').first
    timeline.fill('0.0', timeout=1e3 * PATIENCE)
    timeline.press('Enter')
    page.wait(lambda: page.picture().std() > 0.02)
    start = page.picture()
    timeline.fill('10.0')
    timeline.press('Enter')
    page.wait_for_change(start, dots=20)
    assert not page.outside_requests(page_file.as_uri())


def odometry_at(place):
    message = Odometry()
    message.header.frame_id = 'odom'
    position = message.pose.pose.position
    position.x, position.y, position.z = (float(value) for value in place)
    message.pose.pose.orientation.w = 1.0
    return message


def test_the_executable_shows_what_it_hears_and_a_click_sets_the_goal(
        open_page, start_node, probe, tmp_path):
    from psane_sim.viewer.server import free_port
    port, export = free_port(), tmp_path / 'run.html'
    viewer = start_node('psane_sim', 'viewer', '--port', str(port), '--export', str(export))
    probe.speak(OccupancyGrid, 'slip/mean', LATCHED)
    probe.speak(Odometry, 'odom', ODOMETRY)
    probe.listen(PoseStamped, 'goal_pose', DEFAULT)
    cells = np.full(GRID.shape, 20, dtype=np.int8)
    probe.publish('slip/mean', occupancy_message(GRID, cells, 0.0, 'map'))
    viewer.wait_for_output(f'http://127.0.0.1:{port}')
    probe.until(lambda: probe.is_heard_on('slip/mean') and probe.is_heard_on('odom'))
    probe.publish('odom', odometry_at(MIDDLE))
    probe.spin(1.0)
    page = open_page(f'http://127.0.0.1:{port}')
    page.wait(lambda: page.picture().std() > 0.02)
    before = page.picture()
    probe.publish('odom', odometry_at(THERE))
    page.wait_for_change(before, dots=20)
    # A new page looks at the middle of the ground, so the middle of the picture is that point.
    page.page.mouse.click(WIDTH // 2, HEIGHT // 2)
    probe.until(lambda: probe.heard['goal_pose'])
    goal = probe.last('goal_pose')
    assert goal.header.frame_id == 'map'
    assert (goal.pose.position.x, goal.pose.position.y) == pytest.approx((5.0, 5.0), abs=0.05)
    viewer.stop()
    assert f'wrote {export}' in viewer.output
    assert b'__VISER_EMBED_DATA__' in export.read_bytes()
