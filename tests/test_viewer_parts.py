# SPDX-License-Identifier: Apache-2.0
"""The parts of the live view that need no browser."""

import math
import socket

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from psane_mapping.leg import RobotModel
from psane_sim.robot.leg_mesh import half_circle
from psane_sim.viewer.colours import picture_of, shades_of
from psane_sim.viewer.command import BAD_ARGUMENT, main
from psane_sim.viewer.data import Situation
from psane_sim.viewer.series import MOST_POINTS, RealTimeFactor, Series
from psane_sim.viewer.shapes import (
    NEWTON,
    foot_points,
    force_arrows,
    ground_under,
    outline,
    rotation_of,
)
from psane_sim.viewer.words import headline, paragraph

coordinate = st.floats(-5.0, 5.0)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


@settings(deadline=None)
@given(st.tuples(coordinate, coordinate, st.floats(0.1, 20.0)), st.tuples(coordinate, coordinate))
def test_a_click_finds_the_point_of_the_ground_that_it_was_aimed_at(origin, target):
    eye = np.array(origin)
    direction = np.array([*target, 0.0]) - eye
    found = ground_under(eye, direction / np.linalg.norm(direction))
    assert found == pytest.approx(np.array(target), abs=1e-6)


@pytest.mark.parametrize('direction', [(0.0, 1.0, 0.0), (1.0, 0.0, 0.3)])
def test_a_click_at_the_sky_finds_nothing(direction):
    assert ground_under(np.array([1.0, 1.0, 3.0]), np.array(direction)) is None


@settings(deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(
    lambda q: np.linalg.norm(q) > 0.1))
def test_an_attitude_is_a_rotation(quaternion):
    matrix = rotation_of(np.array(quaternion))
    assert matrix @ matrix.T == pytest.approx(np.eye(3), abs=1e-9)
    assert np.linalg.det(matrix) == pytest.approx(1.0)


def test_a_leg_that_points_down_is_felt_at_its_tip_and_one_that_points_up_at_its_hip():
    model = RobotModel()
    down = foot_points(model, np.zeros(6), LEVEL)
    up = foot_points(model, np.full(6, math.pi), LEVEL)
    element = 2.0 * model.leg_radius * math.sin(math.pi / model.leg_elements)
    tip = model.hips[:, 2] - 2.0 * model.leg_radius
    assert down[:, 2] == pytest.approx(tip, abs=element)
    assert up[:, 2] == pytest.approx(model.hips[:, 2], abs=element)


def test_an_arrow_begins_at_the_foot_and_is_as_long_as_the_force_is_large():
    feet = np.arange(18.0).reshape(6, 3)
    forces = np.tile([0.0, 3.0, 4.0], (6, 1))
    begin, end = np.moveaxis(force_arrows(feet, forces), 1, 0)
    assert (begin == feet).all()
    assert np.linalg.norm(end - begin, axis=1) == pytest.approx(5.0 * NEWTON)


def test_an_outline_is_as_long_as_the_border_holes_included():
    region = Polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (1, 2), (2, 2), (2, 1)]])
    segments = outline(region, 0.1)
    lengths = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    assert lengths.sum() == pytest.approx(region.length)
    assert outline(None, 0.1).shape == (0, 2, 3)


def test_a_drawn_leg_lies_where_the_simulated_one_does():
    model = RobotModel()
    vertices, faces = half_circle(model)
    middle = vertices.reshape(-1, 4, 3).mean(axis=1)
    distance = np.hypot(middle[:, 0], middle[:, 2] + model.leg_radius)
    assert distance == pytest.approx(model.leg_radius, rel=1e-6)
    assert (middle[:, 0] <= 1e-12).all()
    assert faces.min() == 0
    assert faces.max() == len(vertices) - 1


def test_a_map_is_drawn_with_its_first_row_at_the_bottom_and_holes_where_nothing_is_known():
    values = np.array([[0.0, np.nan], [1.0, 0.5]])
    picture = picture_of(values, 'turbo', 1.0)
    assert picture.shape == (2, 2, 4)
    assert (picture[1, 0, :3] == shades_of(np.array(0.0), 'turbo', 1.0)).all()
    assert (picture[0, 0, :3] == shades_of(np.array(1.0), 'turbo', 1.0)).all()
    assert picture[1, 1, 3] == 0
    assert (picture[[0, 0, 1], [0, 1, 0], 3] > 0).all()


def test_a_long_series_stays_small_and_keeps_its_ends():
    series = Series(1)
    for step in range(20 * MOST_POINTS):
        series.add(0.1 * step, float(step))
    times, values = series.columns()
    assert len(times) <= MOST_POINTS
    assert times[0] == 0.0
    assert times[-1] > 0.99 * 0.1 * 20 * MOST_POINTS
    assert (np.diff(times) > 0.0).all()
    assert values == pytest.approx(10.0 * times)


def test_the_real_time_factor_is_that_of_the_last_seconds():
    factor = RealTimeFactor()
    assert math.isnan(factor.value)
    for step in range(100):
        factor.add(0.1 * step, 0.1 * step * (1.0 if step < 50 else 0.0) + (step >= 50) * 5.0)
    assert factor.value == pytest.approx(0.0, abs=1e-9)
    for step in range(100, 200):
        factor.add(0.1 * step, 5.0 + 0.2 * (step - 99))
    assert factor.value == pytest.approx(2.0)


def test_the_words_say_state_cause_remedy_and_what_is_left():
    said = paragraph('robot1', Situation(
        state='STALLED', cause='no way', remedy='another goal', strategy='psane', distance=2.0,
        area=3.5, subgoals=4, march=False))
    for part in ('robot1', 'STALLED', 'no way', 'another goal', '2.00 m', '3.50 m²', 'psane'):
        assert part in said
    exploring = Situation(state='SEEKING', cause='', remedy='', strategy='psane',
                          distance=math.nan, area=1.0, subgoals=0, march=True)
    assert 'to the goal' not in paragraph('', exploring)
    assert 'feels' in headline(exploring)


@pytest.mark.parametrize(('arguments', 'sentence'), [
    (['--port', '70000'], '--port 70000: expected a value in [0, 65535]'),
    (['--export', '/no/such/folder/run.html'], 'there is no folder /no/such/folder'),
    (['--robot', 'spider'], "unknown robot 'spider'; available: ["),
    (['--host', '203.0.113.7'], 'cannot listen on 203.0.113.7'),
])
def test_a_bad_argument_of_the_viewer_gets_a_sentence(arguments, sentence, capsys):
    pytest.importorskip('viser')
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == BAD_ARGUMENT
    assert sentence in capsys.readouterr().err


def test_only_this_machine_is_listened_to_and_a_taken_port_is_named():
    pytest.importorskip('viser')
    from psane_sim.viewer.server import ViewError, free_port, open_server
    port = free_port()
    server = open_server(port=port)
    try:
        with open('/proc/net/tcp', encoding='ascii') as table:
            listening = [line.split()[1] for line in table.readlines()[1:]
                         if line.split()[3] == '0A']
        hosts = {entry.split(':')[0] for entry in listening
                 if int(entry.split(':')[1], 16) == port}
        assert hosts == {'0100007F'}  # 127.0.0.1, its bytes in the order of the processor
        with socket.create_connection(('127.0.0.1', port), timeout=5.0):
            pass
        with pytest.raises(ViewError, match=f'cannot listen on 127.0.0.1:{port}'):
            open_server(port=port)
    finally:
        server.stop()
