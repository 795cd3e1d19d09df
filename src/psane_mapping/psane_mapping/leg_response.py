# SPDX-License-Identifier: Apache-2.0
"""What ground of strength 1 would do to a leg under an observed motion."""

import math
from dataclasses import dataclass, fields

import numpy as np
from numba import njit

from psane_mapping.errors import ShapeError
from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_mapping.rft import displaced, mobilised_force

Arrays = tuple[FloatArray, FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True, kw_only=True)
class LegMotion:
    """Observed motion of one leg, sample by sample, in the order of time.

    Parameters
    ----------
    time : (n,) float [s]
    angle, speed : (n,) float
        Of the hip joint [rad], [rad/s].
    height : (n,) float
        Of the base's origin above the undisturbed surface [m].
    rotation : (n, 3, 3) float
        Base to map (its yaw does not matter, but must fit the velocities).
    velocity, angular_velocity : (n, 3) float
        Of the base, map frame [m/s], [rad/s].
    """

    time: FloatArray
    angle: FloatArray
    speed: FloatArray
    height: FloatArray
    rotation: FloatArray
    velocity: FloatArray
    angular_velocity: FloatArray

    def __post_init__(self) -> None:
        """Check shapes and finiteness and take contiguous copies."""
        count = np.size(self.time)
        tails = {'rotation': (3, 3), 'velocity': (3,), 'angular_velocity': (3,)}
        for entry in fields(self):
            array = np.array(getattr(self, entry.name), dtype=np.float64)
            shape = (count, *tails.get(entry.name, ()))
            if array.shape != shape:
                raise ShapeError(f'{entry.name} has shape {array.shape}, expected {shape}')
            if not np.isfinite(array).all():
                raise ShapeError(f'{entry.name} holds a number that is not finite')
            object.__setattr__(self, entry.name, array)


@dataclass(frozen=True)
class LegResponse:
    """Response of ground of strength 1, one row for each sample.

    Parameters
    ----------
    force : (n, 3) float
        Of the ground on the leg, heading frame (x along the body's heading, y left, z up) [N].
    moment, mean_moment : (n,) float
        Of that force about the hip axis (+y of the base), and its mean since the sample before
        [N m].
    depth : (n,) float
        Deepest element below the surface [m]; 0 when the leg is above it.
    place : (n, 3) float
        Where the force acts: mean of the elements weighted by force, relative to the base's
        origin, map axes [m]; the hip's place where there is no force.
    speed : (n,) float
        At which the leg moves through the ground, the same mean [m/s].
    """

    force: FloatArray
    moment: FloatArray
    mean_moment: FloatArray
    depth: FloatArray
    place: FloatArray
    speed: FloatArray


@njit(cache=True, inline='always')
def _turn(turn: FloatArray, x: float, y: float, z: float) -> tuple[float, float, float]:
    return (turn[0, 0] * x + turn[0, 1] * y + turn[0, 2] * z,
            turn[1, 0] * x + turn[1, 1] * y + turn[1, 2] * z,
            turn[2, 0] * x + turn[2, 1] * y + turn[2, 2] * z)


@njit(cache=True, inline='always')
def _cross(ax: float, ay: float, az: float, bx: float, by: float,
           bz: float) -> tuple[float, float, float]:
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@njit(cache=True, error_model='numpy')
def _respond_once(angle: float, speed: float, height: float, turn: FloatArray,
                  velocity: FloatArray, angular: FloatArray, dt: float, hip: FloatArray,
                  surface: Arrays, displacement: float, damping: float, memory: FloatArray,
                  force: FloatArray, place: FloatArray) -> tuple[float, float, float]:
    """Fill force and place (3,) of one instant; return moment, depth and speed."""
    points, normals, area, side = surface
    norm = math.hypot(turn[0, 0], turn[1, 0])
    cx, sx = turn[0, 0] / norm, turn[1, 0] / norm
    hx, hy, hz = _turn(turn, hip[0], hip[1], hip[2])
    cosine, sine = math.cos(angle), math.sin(angle)
    moment, deepest, weight, speeds = 0.0, 0.0, 0.0, 0.0
    force[:] = 0.0
    place[:] = 0.0
    for i in range(points.shape[0]):
        ax, ay, az = _turn(turn, cosine * points[i, 0] + sine * points[i, 2], 0.0,
                           cosine * points[i, 2] - sine * points[i, 0])
        depth = -(height + hz + az)
        if depth <= 0.0:
            memory[i] = 0.0
            continue
        deepest = max(deepest, depth)
        nx, ny, nz = _turn(turn, cosine * normals[i, 0] + sine * normals[i, 2], 0.0,
                           cosine * normals[i, 2] - sine * normals[i, 0])
        bx, by, bz = _cross(angular[0], angular[1], angular[2], hx + ax, hy + ay, hz + az)
        lx, ly, lz = _cross(turn[0, 1] * speed, turn[1, 1] * speed, turn[2, 1] * speed, ax, ay, az)
        vx, vy, vz = velocity[0] + bx + lx, velocity[1] + by + ly, velocity[2] + bz + lz
        ex, ey, ez, share = displaced(memory[i], cx * vx + sx * vy, cx * vy - sx * vx, vz, dt,
                                      displacement, damping)
        fx, fy, fz = mobilised_force(ex, ey, ez, share, cx * nx + sx * ny, nz, area[i], side[i],
                                     depth)
        force[0] += fx
        force[1] += fy
        force[2] += fz
        mx, my, mz = _cross(ax, ay, az, cx * fx - sx * fy, sx * fx + cx * fy, fz)
        moment += mx * turn[0, 1] + my * turn[1, 1] + mz * turn[2, 1]
        size = math.sqrt(fx * fx + fy * fy + fz * fz)
        weight += size
        speeds += size * math.sqrt(vx * vx + vy * vy + vz * vz)
        place[0] += size * (hx + ax)
        place[1] += size * (hy + ay)
        place[2] += size * (hz + az)
    if weight > 0.0:
        place /= weight
        speeds /= weight
    else:
        place[0], place[1], place[2] = hx, hy, hz
    return moment, deepest, speeds


@njit(cache=True)
def _respond(time: FloatArray, angle: FloatArray, speed: FloatArray, height: FloatArray,
             rotation: FloatArray, velocity: FloatArray, angular: FloatArray, hip: FloatArray,
             surface: Arrays, displacement: float, damping: float, substep: float,
             force: FloatArray, moment: FloatArray, mean_moment: FloatArray, depths: FloatArray,
             place: FloatArray, speeds: FloatArray) -> None:
    """Fill the results, sample by sample; the elements remember their displacement."""
    memory = np.zeros((surface[0].shape[0], 3))
    turn, body, spin = np.empty((3, 3)), np.empty(3), np.empty(3)
    for n in range(time.shape[0]):
        o = max(n - 1, 0)
        interval = time[n] - time[o]
        parts = max(1, int(math.ceil(interval / substep - 1e-6)))
        for part in range(parts):
            share = (part + 1.0) / parts
            turn[:] = rotation[o] + share * (rotation[n] - rotation[o])
            body[:] = velocity[o] + share * (velocity[n] - velocity[o])
            spin[:] = angular[o] + share * (angular[n] - angular[o])
            moment[n], depths[n], speeds[n] = _respond_once(
                angle[o] + share * (angle[n] - angle[o]), speed[o] + share * (speed[n] - speed[o]),
                height[o] + share * (height[n] - height[o]), turn, body, spin, interval / parts,
                hip, surface, displacement, damping, memory, force[n], place[n])
            mean_moment[n] += moment[n] / parts


def leg_response(model: RobotModel, leg: int, motion: LegMotion, *,
                 displacement: float = 0.0015, damping: float = 0.002,
                 substep: float = 0.001) -> LegResponse:
    """Return what ground of strength 1 would do to a leg.

    Parameters
    ----------
    model : RobotModel
    leg : int
        Index into `LEG_NAMES`.
    motion : LegMotion
        Best from a sample or more before touch-down on, since the elements remember how far
        the ground around them has been displaced. Angles must not jump by a turn.
    displacement, damping : float
        Of the elastic-plastic rule [m], [s]; a displacement near 0 has no memory.
    substep : float
        The motion between two samples is cut into straight pieces that are no longer [s].

    Notes
    -----
    Li et al. 2013, with the elastic-plastic rule of the simulator's soil: u <- u + v dt, |u|
    clipped to delta; e = u + tau_d v; force in the direction of e times min(|e| / delta, 1).
    """
    count = motion.time.shape[0]
    result = LegResponse(np.zeros((count, 3)), np.zeros(count), np.zeros(count),
                         np.zeros(count), np.zeros((count, 3)), np.zeros(count))
    surface = model.leg
    _respond(motion.time, motion.angle, motion.speed, motion.height, motion.rotation,
             motion.velocity, motion.angular_velocity, np.array(model.hips[leg]),
             (np.array(surface.position), np.array(surface.normal), np.array(surface.area),
              np.array(surface.side)), displacement, damping, substep, result.force,
             result.moment, result.mean_moment, result.depth, result.place, result.speed)
    return result
