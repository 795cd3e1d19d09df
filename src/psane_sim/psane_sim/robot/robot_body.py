# SPDX-License-Identifier: Apache-2.0
"""The robot as a URDF: a body and six legs on hip axes, with or without something to look at."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from psane_mapping.grid import FloatArray
from psane_mapping.leg import LEG_NAMES, RobotModel
from psane_sim.robot.leg_mesh import half_circle
from psane_sim.robot.quiet_pybullet import pybullet

_BODY_COLOUR = '0.16 0.24 0.38 1'
_LEG_COLOURS = ('0.90 0.55 0.13 1', '0.93 0.75 0.25 1')


def load_robot(robot: RobotModel, client: int, *, visible: bool) -> int:
    """Load the robot into an engine and return its body number.

    Parameters
    ----------
    robot : RobotModel
    client : int
        Engine's connection number.
    visible : bool
        True adds shapes to look at; there is never a shape to collide with, since the ground
        acts through the soil alone.
    """
    with TemporaryDirectory() as folder:
        if visible:
            (Path(folder) / 'leg.obj').write_text(half_circle_mesh(robot))
        path = Path(folder) / 'robot.urdf'
        path.write_text(urdf_of(robot, visible=visible))
        return int(pybullet.loadURDF(str(path), flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
                                     physicsClientId=client))


def urdf_of(robot: RobotModel, *, visible: bool) -> str:
    """Return the robot's URDF text; joints and links are in the order of `LEG_NAMES`."""
    legs = ''.join(_leg_urdf(robot, index, visible) for index in range(len(LEG_NAMES)))
    x, y, z = robot.body_length, robot.body_width, robot.body_height
    inertia = robot.body_mass / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    visual = _visual(f'<box size="{x} {y} {z}"/>', 'body', _BODY_COLOUR) if visible else ''
    return (f'<robot name="hexapod"><link name="base">'
            f'{_inertial(robot.body_mass, inertia)}{visual}</link>{legs}</robot>')


def _inertial(mass: float, inertia: FloatArray) -> str:
    return (f'<inertial><mass value="{mass}"/><inertia ixx="{inertia[0]}" iyy="{inertia[1]}" '
            f'izz="{inertia[2]}" ixy="0" ixz="0" iyz="0"/></inertial>')


def _visual(geometry: str, name: str, colour: str) -> str:
    return (f'<visual><geometry>{geometry}</geometry><material name="{name}">'
            f'<color rgba="{colour}"/></material></visual>')


def _leg_urdf(robot: RobotModel, index: int, visible: bool) -> str:
    name = LEG_NAMES[index]
    hip = ' '.join(str(value) for value in robot.hips[index])
    colour = _LEG_COLOURS[index % 2]
    visual = _visual('<mesh filename="leg.obj"/>', name, colour) if visible else ''
    inertia = np.full(3, robot.leg_inertia)
    return (f'<link name="{name}">{_inertial(robot.leg_mass, inertia)}{visual}</link>'
            f'<joint name="{name}_hip" type="continuous"><parent link="base"/>'
            f'<child link="{name}"/><origin xyz="{hip}"/><axis xyz="0 1 0"/></joint>')


def half_circle_mesh(robot: RobotModel, pieces: int = 24) -> str:
    """Return a half-circle leg as the text of a Wavefront OBJ file."""
    vertices, faces = half_circle(robot, pieces)
    return _obj_text(vertices, [(int(a), int(b), int(c)) for a, b, c in faces])


def _obj_text(vertices: FloatArray, faces: list[tuple[int, int, int]]) -> str:
    """Write flat-shaded triangles, each seen from both sides."""
    lines = [f'v {x:.6f} {y:.6f} {z:.6f}' for x, y, z in vertices]
    normals, triangles = [], []
    for a, b, c in faces:
        normal = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
        normals.append(normal / max(float(np.linalg.norm(normal)), 1.0e-12))
        triangles.append((a + 1, b + 1, c + 1, len(normals)))
    lines += [f'vn {x:.5f} {y:.5f} {z:.5f}' for x, y, z in normals]
    lines += ['vt 0 0']
    lines += [f'f {a}/1/{n} {b}/1/{n} {c}/1/{n}' for a, b, c, n in triangles]
    return '\n'.join(lines) + '\n'
