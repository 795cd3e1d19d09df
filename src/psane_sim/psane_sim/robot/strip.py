# SPDX-License-Identifier: Apache-2.0
"""A strip of pictures: a stride on firm ground, one on soft ground, and a robot that sinks.

``python -m psane_sim.robot.strip OUT.png`` draws it.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.robot.render import Camera
from psane_sim.terrains.terrain import Terrain

Picture = NDArray[np.uint8]

ROWS = ((1.0, 'firm'), (0.09, 'soft'), (0.02, 'sinking'))
"""Strength [-] and name of each row."""

FRAMES = 5
SIZE = (300, 190)
_SHADE = 24
_SIDE = Camera(distance=1.15, yaw=-1.35, pitch=0.28, field_of_view=0.62)


def stride_pictures(strength: float, name: str) -> list[Picture]:
    """Return pictures of one stride, after the robot has walked for three."""
    config = SimulatorConfiguration(footprints=True)
    stride = 1.0 / config.stride_frequency
    terrain = Terrain.uniform(strength)
    pictures = []
    with HexapodSimulator(config, terrain, (5.0, 5.0, 0.0)) as simulator:
        simulator.command(0.29, 0.0)
        simulator.step(round(3.0 * stride / config.time_step))
        for frame in range(FRAMES):
            truth = simulator.truth()
            picture = np.ascontiguousarray(simulator.render(*SIZE, _SIDE))
            lines = (f'{name}, strength {strength:g}' if frame == 0 else '',
                     f'{truth.time:.2f} s  x {truth.position[0] - 5.0:.2f} m  '
                     f'deepest {1e3 * max(0.0, truth.foot_depth.max()):.0f} mm')
            for line, text in enumerate(lines):
                cv2.putText(picture, text, (6, 16 + 158 * line), cv2.FONT_HERSHEY_SIMPLEX, 0.42,
                            (255, 255, 255) if line else (0, 0, 0), 1, cv2.LINE_AA)
            pictures.append(picture)
            simulator.step(round(stride / FRAMES / config.time_step))
    return pictures


def strip() -> Picture:
    """Return the pictures of all rows as one, red green blue, in few shades to be small."""
    rows = np.vstack([np.hstack(stride_pictures(strength, name)) for strength, name in ROWS])
    return np.asarray(rows // _SHADE * _SHADE + _SHADE // 2)


def main(arguments: Sequence[str] | None = None) -> None:
    """Draw the strip."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument('out', type=Path, help='PNG to write')
    options = parser.parse_args(arguments)
    cv2.imwrite(str(options.out), strip()[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 9])


if __name__ == '__main__':
    main()
