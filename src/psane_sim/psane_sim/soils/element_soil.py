# SPDX-License-Identifier: Apache-2.0
"""Soils that act on the robot plate by plate, each by its law (`soil_laws`)."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel, Surface
from psane_sim.soils.ground_surface import (
    Prints,
    Relief,
    compaction_of,
    flat_relief,
    height_at,
    no_prints,
    normal_at,
    pit_at,
)
from psane_sim.soils.laws import COLUMN, GRANULAR, MEMORY, column, contact, granular
from psane_sim.soils.soil import BODY, GroundLoad, RobotState
from psane_sim.soils.strength_field import StrengthField, strength_at

Arrays = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
Ground = tuple[int, FloatArray, FloatArray, FloatArray, Relief, Prints]
"""Law, its settings, logarithm of strength (or stiffness) and its place, heights, footprints."""


@njit(cache=True, inline='always', error_model='numpy')
def _velocity(velocity: FloatArray, angular: FloatArray, spin: FloatArray, lever: FloatArray,
              arm: FloatArray) -> tuple[float, float, float]:
    """Return the velocity of a point on a leg, map frame [m/s]."""
    x = (velocity[0] + angular[1] * lever[2] - angular[2] * lever[1]
         + spin[1] * arm[2] - spin[2] * arm[1])
    y = (velocity[1] + angular[2] * lever[0] - angular[0] * lever[2]
         + spin[2] * arm[0] - spin[0] * arm[2])
    z = (velocity[2] + angular[0] * lever[1] - angular[1] * lever[0]
         + spin[0] * arm[1] - spin[1] * arm[0])
    return x, y, z


@njit(cache=True, error_model='numpy')
def _surface_frame(relief: Relief, x: float, y: float, rotation: FloatArray,
                   frame: FloatArray) -> None:
    """Fill the rows of a frame on the ground: along the heading, to the left, along the normal."""
    norm = math.hypot(rotation[0, 0], rotation[1, 0])
    cx, sx = (rotation[0, 0] / norm, rotation[1, 0] / norm) if norm > 0.0 else (1.0, 0.0)
    nx, ny, nz = normal_at(relief, x, y)
    along = cx * nx + sx * ny
    fx, fy, fz = cx - along * nx, sx - along * ny, -along * nz
    norm = math.sqrt(fx * fx + fy * fy + fz * fz)
    fx, fy, fz = fx / norm, fy / norm, fz / norm
    frame[0, 0], frame[0, 1], frame[0, 2] = fx, fy, fz
    frame[1, 0], frame[1, 1], frame[1, 2] = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
    frame[2, 0], frame[2, 1], frame[2, 2] = nx, ny, nz


@njit(cache=True, inline='always', error_model='numpy')
def _row(frame: FloatArray, row: int, x: float, y: float, z: float) -> float:
    return frame[row, 0] * x + frame[row, 1] * y + frame[row, 2] * z


@njit(cache=True, error_model='numpy')
def _accumulate(row: int, surface: Arrays, hip: FloatArray, turn: FloatArray, spin: FloatArray,
                position: FloatArray, rotation: FloatArray, velocity: FloatArray,
                angular: FloatArray, memory: FloatArray, ground: Ground, dt: float,
                frame: FloatArray, force: FloatArray, moment: FloatArray, depths: FloatArray,
                foot: FloatArray) -> None:
    """Add up the forces on one rigid surface (a leg or the belly)."""
    points, normals, area, side = surface
    law, settings, log_strength, place, relief, prints = ground
    leaves_prints = prints[0].shape[0] > 1
    _surface_frame(relief, position[0] + hip[0], position[1] + hip[1], rotation, frame)
    arm, lever, normal = np.empty(3), np.empty(3), np.empty(3)
    deepest = -1.0e9
    for i in range(points.shape[0]):
        for k in range(3):
            arm[k] = (turn[k, 0] * points[i, 0] + turn[k, 1] * points[i, 1]
                      + turn[k, 2] * points[i, 2])
            lever[k] = hip[k] + arm[k]
        x, y = position[0] + lever[0], position[1] + lever[1]
        depth = frame[2, 2] * (height_at(relief, x, y) - position[2] - lever[2])
        pit = pit_at(prints, x, y, depth) if leaves_prints and depth > 0.0 else 0.0
        depth -= pit
        if depth > deepest:
            deepest = depth
            for k in range(3):
                foot[row, k] = position[k] + lever[k]
        if depth <= 0.0:
            memory[i] = 0.0
            continue
        wx, wy, wz = _velocity(velocity, angular, spin, lever, arm)
        vx, vy, vz = _row(frame, 0, wx, wy, wz), _row(frame, 1, wx, wy, wz), _row(frame, 2, wx, wy,
                                                                                wz)
        for k in range(3):
            normal[k] = (turn[k, 0] * normals[i, 0] + turn[k, 1] * normals[i, 1]
                         + turn[k, 2] * normals[i, 2])
        nx = _row(frame, 0, normal[0], normal[1], normal[2])
        nz = _row(frame, 2, normal[0], normal[1], normal[2])
        strength = strength_at(log_strength, place, x, y)
        if pit > 0.0:
            strength *= compaction_of(prints, pit)
        if law == GRANULAR:
            fx, fy, fz = granular(memory[i], settings, strength, depth, vx, vy, vz, nx, nz,
                                  area[i], side[i], dt)
            if row == BODY and fz < 0.0:
                fz = 0.0
        elif law == COLUMN:
            fx, fy, fz = column(memory[i], settings, strength, depth, vx, vy, vz, nz, area[i], dt)
        else:
            fx, fy, fz = contact(memory[i], settings, strength, depth, vx, vy, vz, area[i], dt)
        gx = frame[0, 0] * fx + frame[1, 0] * fy + frame[2, 0] * fz
        gy = frame[0, 1] * fx + frame[1, 1] * fy + frame[2, 1] * fz
        gz = frame[0, 2] * fx + frame[1, 2] * fy + frame[2, 2] * fz
        force[row, 0] += gx
        force[row, 1] += gy
        force[row, 2] += gz
        moment[row, 0] += arm[1] * gz - arm[2] * gy
        moment[row, 1] += arm[2] * gx - arm[0] * gz
        moment[row, 2] += arm[0] * gy - arm[1] * gx
    depths[row] = deepest


@njit(cache=True, error_model='numpy')
def _ground_load(position: FloatArray, rotation: FloatArray, velocity: FloatArray,
                 angular: FloatArray, angle: FloatArray, speed: FloatArray, hips: FloatArray,
                 leg: Arrays, belly: Arrays, leg_memory: FloatArray, belly_memory: FloatArray,
                 ground: Ground, dt: float, force: FloatArray, moment: FloatArray,
                 depths: FloatArray, foot: FloatArray, hip_place: FloatArray) -> None:
    """Fill the load for the six legs and the belly."""
    force[:] = 0.0
    moment[:] = 0.0
    ground[5][2][0] += dt
    turn, frame = np.empty((3, 3)), np.empty((3, 3))
    hip, spin = np.zeros(3), np.zeros(3)
    for row in range(6):
        cosine, sine = math.cos(angle[row]), math.sin(angle[row])
        for k in range(3):
            turn[k, 0] = rotation[k, 0] * cosine - rotation[k, 2] * sine
            turn[k, 1] = rotation[k, 1]
            turn[k, 2] = rotation[k, 0] * sine + rotation[k, 2] * cosine
            hip[k] = (rotation[k, 0] * hips[row, 0] + rotation[k, 1] * hips[row, 1]
                      + rotation[k, 2] * hips[row, 2])
            hip_place[row, k] = position[k] + hip[k]
            spin[k] = rotation[k, 1] * speed[row]
        _accumulate(row, leg, hip, turn, spin, position, rotation, velocity, angular,
                    leg_memory[row], ground, dt, frame, force, moment, depths, foot)
    hip[:] = 0.0
    spin[:] = 0.0
    hip_place[BODY] = position
    _accumulate(BODY, belly, hip, rotation, spin, position, rotation, velocity, angular,
                belly_memory, ground, dt, frame, force, moment, depths, foot)


@dataclass(frozen=True)
class SoilLaw:
    """A law and what it needs besides a plate.

    Parameters
    ----------
    law : int
        `GRANULAR`, `COLUMN` or `CONTACT`.
    settings : (k,) float
        As the law counts them.
    log_stiffness : (rows, columns) float
        Natural logarithm of what the law calls strength, modulus or stiffness, on the grid of the
        strength field.
    """

    law: int
    settings: FloatArray
    log_stiffness: FloatArray


class ElementSoil:
    """Ground whose law acts on every plate of the robot by itself.

    Parameters
    ----------
    robot : RobotModel
    field : StrengthField
        Its grid is where the law's stiffness is known.
    law : SoilLaw
    relief : Relief, optional
        Heights; level ground if there are none.
    prints : Prints, optional
        Footprints; ground that forgets them if there are none.

    Notes
    -----
    Depth is measured along the surface's normal under the hip; pits are vertical. The belly is
    never sucked down (its force along the normal is >= 0).
    """

    def __init__(self, robot: RobotModel, field: StrengthField, law: SoilLaw, *,
                 relief: Relief | None = None, prints: Prints | None = None) -> None:
        self._hips = np.array(robot.hips)
        self._leg, self._belly = _arrays(robot.leg), _arrays(robot.belly)
        self._prints = prints or no_prints()
        self._ground: Ground = (law.law, np.array(law.settings), np.array(law.log_stiffness),
                                field.place, relief or flat_relief(), self._prints)
        self._leg_memory = np.zeros((6, len(robot.leg.area), MEMORY))
        self._belly_memory = np.zeros((len(robot.belly.area), MEMORY))
        self._load = GroundLoad.zeros()

    def load(self, state: RobotState, dt: float) -> GroundLoad:
        """Return the ground's forces for this tick (its arrays are reused)."""
        load = self._load
        _ground_load(state.position, state.rotation, state.velocity, state.angular_velocity,
                     state.angle, state.speed, self._hips, self._leg, self._belly,
                     self._leg_memory, self._belly_memory, self._ground, dt, load.force,
                     load.moment, load.depth, load.foot, load.place)
        return load

    def reset(self) -> None:
        """Forget every displacement; footprints stay."""
        self._leg_memory[:] = 0.0
        self._belly_memory[:] = 0.0


def _arrays(surface: Surface) -> Arrays:
    """Return writable copies, since read-only and writable arrays compile apart."""
    return (np.array(surface.position), np.array(surface.normal), np.array(surface.area),
            np.array(surface.side))
