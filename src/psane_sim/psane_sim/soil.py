# SPDX-License-Identifier: Apache-2.0
"""The ground under the robot: what its legs and belly are pushed with.

A soil is asked once per tick with the state of the robot and answers with one wrench for each leg
and one for the body. `GranularSoil` is resistive force theory with an elastic-plastic memory.
"""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel, Surface
from psane_mapping.rft import displaced, mobilised_force
from psane_sim.strength_field import StrengthField, strength_at

Arrays = tuple[FloatArray, FloatArray, FloatArray, FloatArray]

BODY = 6
"""Row of the body in the arrays of seven (rows 0 to 5: legs)."""


@dataclass(frozen=True)
class RobotState:
    """What the soil needs to know; a simulator fills the same arrays anew each tick.

    Parameters
    ----------
    position : (3,) float
        Origin of the base frame, map frame [m].
    rotation : (3, 3) float
        Base to map.
    velocity, angular_velocity : (3,) float
        Of the base, map frame [m/s], [rad/s].
    angle, speed : (6,) float
        Hip joints [rad], [rad/s].
    """

    position: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    angular_velocity: FloatArray
    angle: FloatArray
    speed: FloatArray

    @classmethod
    def zeros(cls) -> 'RobotState':
        """Return a state at the origin, at rest."""
        return cls(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3), np.zeros(6), np.zeros(6))


@dataclass(frozen=True)
class GroundLoad:
    """What the ground does to the robot; the arrays are reused from tick to tick.

    Parameters
    ----------
    force : (7, 3) float
        On each leg and (last row) on the body, map frame [N].
    moment : (7, 3) float
        About the leg's hip, and about the base's origin for the body, map frame [N m].
    depth : (7,) float
        Deepest element of each leg and of the belly [m]; negative above the ground.
    foot : (7, 3) float
        That element's place, map frame [m].
    place : (7, 3) float
        Where the force and moment act: each leg's hip and the base's origin, map frame [m].
    """

    force: FloatArray
    moment: FloatArray
    depth: FloatArray
    foot: FloatArray
    place: FloatArray

    @classmethod
    def zeros(cls) -> 'GroundLoad':
        """Return no load."""
        return cls(np.zeros((7, 3)), np.zeros((7, 3)), np.zeros(7), np.zeros((7, 3)),
                   np.zeros((7, 3)))


class Soil(Protocol):
    """State and velocity of the robot's surfaces in, forces out."""

    def load(self, state: RobotState, dt: float) -> GroundLoad:
        """Return the ground's forces and move the soil's own state on by `dt` [s]."""
        ...

    def reset(self) -> None:
        """Forget every displacement."""
        ...


@njit(cache=True, inline='always', error_model='numpy')
def _heading_velocity(velocity: FloatArray, angular: FloatArray, spin: FloatArray,
                      lever: FloatArray, arm: FloatArray, cosine: float,
                      sine: float) -> tuple[float, float, float]:
    """Return the velocity of a point on a leg, x along the heading, y left, z up [m/s]."""
    x = (velocity[0] + angular[1] * lever[2] - angular[2] * lever[1]
         + spin[1] * arm[2] - spin[2] * arm[1])
    y = (velocity[1] + angular[2] * lever[0] - angular[0] * lever[2]
         + spin[2] * arm[0] - spin[0] * arm[2])
    z = (velocity[2] + angular[0] * lever[1] - angular[1] * lever[0]
         + spin[0] * arm[1] - spin[1] * arm[0])
    return cosine * x + sine * y, cosine * y - sine * x, z


@njit(cache=True, error_model='numpy')
def _accumulate(row: int, surface: Arrays, hip: FloatArray, turn: FloatArray, spin: FloatArray,
                position: FloatArray, rotation: FloatArray, velocity: FloatArray,
                angular: FloatArray, memory: FloatArray, log_strength: FloatArray,
                place: FloatArray, settings: FloatArray, is_belly: bool, force: FloatArray,
                moment: FloatArray, depths: FloatArray, foot: FloatArray) -> None:
    """Add up the forces on one rigid surface (a leg or the belly)."""
    points, normals, area, side = surface
    dt, yield_displacement, damping = settings[0], settings[1], settings[2]
    norm = math.hypot(rotation[0, 0], rotation[1, 0])
    cx, sx = (rotation[0, 0] / norm, rotation[1, 0] / norm) if norm > 0.0 else (1.0, 0.0)
    arm = np.empty(3)
    lever = np.empty(3)
    normal = np.empty(3)
    deepest = -1.0e9
    for i in range(points.shape[0]):
        for k in range(3):
            arm[k] = (turn[k, 0] * points[i, 0] + turn[k, 1] * points[i, 1]
                      + turn[k, 2] * points[i, 2])
            lever[k] = hip[k] + arm[k]
        depth = -(position[2] + lever[2])
        if depth > deepest:
            deepest = depth
            for k in range(3):
                foot[row, k] = position[k] + lever[k]
        if depth <= 0.0:
            memory[i, 0] = memory[i, 1] = memory[i, 2] = 0.0
            continue
        vx, vy, vz = _heading_velocity(velocity, angular, spin, lever, arm, cx, sx)
        ex, ey, ez, share = displaced(memory[i], vx, vy, vz, dt, yield_displacement, damping)
        for k in range(3):
            normal[k] = (turn[k, 0] * normals[i, 0] + turn[k, 1] * normals[i, 1]
                         + turn[k, 2] * normals[i, 2])
        strength = strength_at(log_strength, place, position[0] + lever[0],
                               position[1] + lever[1])
        fx, fy, fz = mobilised_force(ex, ey, ez, share, cx * normal[0] + sx * normal[1],
                                     normal[2], area[i], side[i], strength * depth)
        if is_belly and fz < 0.0:
            fz = 0.0
        gx, gy = cx * fx - sx * fy, sx * fx + cx * fy
        force[row, 0] += gx
        force[row, 1] += gy
        force[row, 2] += fz
        moment[row, 0] += arm[1] * fz - arm[2] * gy
        moment[row, 1] += arm[2] * gx - arm[0] * fz
        moment[row, 2] += arm[0] * gy - arm[1] * gx
    depths[row] = deepest


@njit(cache=True, error_model='numpy')
def _ground_load(position: FloatArray, rotation: FloatArray, velocity: FloatArray,
                 angular: FloatArray, angle: FloatArray, speed: FloatArray, hips: FloatArray,
                 leg: Arrays, belly: Arrays, leg_memory: FloatArray, belly_memory: FloatArray,
                 log_strength: FloatArray, place: FloatArray, settings: FloatArray,
                 force: FloatArray, moment: FloatArray, depths: FloatArray, foot: FloatArray,
                 hip_place: FloatArray) -> None:
    """Fill the load for the six legs and the belly."""
    force[:] = 0.0
    moment[:] = 0.0
    turn = np.empty((3, 3))
    hip = np.zeros(3)
    spin = np.zeros(3)
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
                    leg_memory[row], log_strength, place, settings, False, force, moment, depths,
                    foot)
    hip[:] = 0.0
    spin[:] = 0.0
    hip_place[BODY] = position
    _accumulate(BODY, belly, hip, rotation, spin, position, rotation, velocity, angular,
                belly_memory, log_strength, place, settings, True, force, moment, depths, foot)


class GranularSoil:
    """Resistive force theory with an elastic-plastic memory in each element.

    Parameters
    ----------
    robot : RobotModel
    field : StrengthField
        Strength over the map.
    displacement : float
        At which the ground yields fully, delta [m].
    damping : float
        Time constant tau_d [s].

    Notes
    -----
    Per element u <- u + v dt, |u| clipped to delta; e = u + tau_d v; the force is that of
    resistive force theory (Li et al. 2013) in the direction of e, times min(|e| / delta, 1). The
    surface is flat at height 0. The belly is never sucked down (its vertical force is >= 0).
    """

    def __init__(self, robot: RobotModel, field: StrengthField, *, displacement: float = 0.0015,
                 damping: float = 0.002) -> None:
        self._hips = np.array(robot.hips)
        self._leg, self._belly = _arrays(robot.leg), _arrays(robot.belly)
        self._log_strength, self._place = np.array(field.log_strength), field.place
        self._settings = np.array([0.0, displacement, damping])
        self._leg_memory = np.zeros((6, len(robot.leg.area), 3))
        self._belly_memory = np.zeros((len(robot.belly.area), 3))
        self._load = GroundLoad.zeros()

    def load(self, state: RobotState, dt: float) -> GroundLoad:
        """Return the ground's forces for this tick (its arrays are reused)."""
        self._settings[0] = dt
        load = self._load
        _ground_load(state.position, state.rotation, state.velocity, state.angular_velocity,
                     state.angle, state.speed, self._hips, self._leg, self._belly,
                     self._leg_memory, self._belly_memory, self._log_strength, self._place,
                     self._settings, load.force, load.moment, load.depth, load.foot, load.place)
        return load

    def reset(self) -> None:
        """Forget every displacement."""
        self._leg_memory[:] = 0.0
        self._belly_memory[:] = 0.0


def _arrays(surface: Surface) -> Arrays:
    """Return writable copies, since read-only and writable arrays compile apart."""
    return (np.array(surface.position), np.array(surface.normal), np.array(surface.area),
            np.array(surface.side))
