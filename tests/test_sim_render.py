# SPDX-License-Identifier: Apache-2.0
"""Pictures of the hexapod without a display."""

import numpy as np

from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.robot.render import Camera
from psane_sim.terrains.terrain import Terrain

SIZE = (160, 120)


def test_a_picture_shows_the_robot_and_the_ground_around_it():
    terrain = Terrain.from_slip('flat', np.full((201, 201), 0.1), (2.0, 2.0), (8.0, 8.0))
    above = Camera(pitch=1.3, distance=1.5)
    with HexapodSimulator(SimulatorConfiguration(), terrain, (5.0, 5.0, 0.3)) as simulator:
        picture = simulator.render(*SIZE, above)
        elsewhere = simulator.render(*SIZE, Camera(target=(8.0, 8.0, 0.0), pitch=1.3,
                                                   distance=1.5))
    assert picture.shape == (120, 160, 3)
    assert picture.dtype == np.uint8
    # The body is dark blue and in the middle; the ground beside it is not.
    middle = picture[55:65, 75:85].reshape(-1, 3).astype(float).mean(axis=0)
    ground = elsewhere[55:65, 75:85].reshape(-1, 3).astype(float).mean(axis=0)
    assert middle[2] > 1.5 * middle[0]
    assert np.abs(middle - ground).max() > 40.0


def test_the_same_scene_gives_the_same_picture_and_a_stride_changes_it():
    with HexapodSimulator(SimulatorConfiguration(), Terrain.uniform(1.0),
                          (5.0, 5.0, 0.0)) as simulator:
        fixed = Camera(target=(5.0, 5.0, 0.1))
        first, again = simulator.render(*SIZE, fixed), simulator.render(*SIZE, fixed)
        simulator.command(0.3, 0.0)
        simulator.step(900)
        later = simulator.render(*SIZE, fixed)
    np.testing.assert_array_equal(first, again)
    assert np.abs(later.astype(int) - first).max() > 40
