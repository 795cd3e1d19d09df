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
    moment : (n,) float
        Of that force about the hip axis (+y of the base) [N m].
    depth : (n,) float
        Deepest element below the surface [m]; 0 when the leg is above it.
    place : (n, 3) float
        Where the force acts: mean of the elements weighted by force, relative to the base's
        origin, map axes [m]; the hip's place where there is no force.
    """

    force: FloatArray
    moment: FloatArray
    depth: FloatArray
    place: FloatArray


@njit(cache=True)
def _respond(time: FloatArray, angle: FloatArray, speed: FloatArray, height: FloatArray,
             rotation: FloatArray, velocity: FloatArray, angular: FloatArray, hip: FloatArray,
             points: FloatArray, normals: FloatArray, area: FloatArray, side: FloatArray,
             displacement: float, damping: float, force: FloatArray, moment: FloatArray,
             depths: FloatArray, place: FloatArray) -> None:
    """Fill the four results, sample by sample; the elements remember their displacement."""
    memory = np.zeros((points.shape[0], 3))
    for n in range(time.shape[0]):
        dt = time[n] - time[n - 1] if n > 0 else 0.0
        turn = rotation[n]
        norm = math.hypot(turn[0, 0], turn[1, 0])
        cx, sx = turn[0, 0] / norm, turn[1, 0] / norm
        axis = turn[:, 1].copy()
        hip_lever = turn @ hip
        cosine, sine = math.cos(angle[n]), math.sin(angle[n])
        weight, weighted = 0.0, np.zeros(3)
        for i in range(points.shape[0]):
            px, pz = points[i, 0], points[i, 2]
            mx, mz = normals[i, 0], normals[i, 2]
            arm = turn @ np.array([cosine * px + sine * pz, 0.0, cosine * pz - sine * px])
            facing = turn @ np.array([cosine * mx + sine * mz, 0.0, cosine * mz - sine * mx])
            lever = hip_lever + arm
            depth = -(height[n] + lever[2])
            if depth <= 0.0:
                memory[i] = 0.0
                continue
            depths[n] = max(depths[n], depth)
            moving = velocity[n] + np.cross(angular[n], lever) + np.cross(axis * speed[n], arm)
            step = np.array([cx * moving[0] + sx * moving[1], cx * moving[1] - sx * moving[0],
                             moving[2]])
            ex, ey, ez, share = displaced(memory[i], step[0], step[1], step[2], dt,
                                          displacement, damping)
            fx, fy, fz = mobilised_force(ex, ey, ez, share, cx * facing[0] + sx * facing[1],
                                         facing[2], area[i], side[i], depth)
            force[n, 0] += fx
            force[n, 1] += fy
            force[n, 2] += fz
            world = np.array([cx * fx - sx * fy, sx * fx + cx * fy, fz])
            moment[n] += np.dot(np.cross(arm, world), axis)
            size = math.sqrt(fx * fx + fy * fy + fz * fz)
            weight += size
            weighted += size * lever
        place[n] = weighted / weight if weight > 0.0 else hip_lever


def leg_response(model: RobotModel, leg: int, motion: LegMotion, *,
                 displacement: float = 0.0015, damping: float = 0.002) -> LegResponse:
    """Return what ground of strength 1 would do to a leg.

    Parameters
    ----------
    model : RobotModel
    leg : int
        Index into `LEG_NAMES`.
    motion : LegMotion
        Best from a sample or more before touch-down on, since the elements remember how far
        the ground around them has been displaced.
    displacement, damping : float
        Of the elastic-plastic rule [m], [s]; a displacement near 0 has no memory.

    Notes
    -----
    Li et al. 2013, with the elastic-plastic rule of the simulator's soil: u <- u + v dt, |u|
    clipped to delta; e = u + tau_d v; force in the direction of e times min(|e| / delta, 1).
    """
    count = motion.time.shape[0]
    result = LegResponse(np.zeros((count, 3)), np.zeros(count), np.zeros(count),
                         np.zeros((count, 3)))
    surface = model.leg
    _respond(motion.time, motion.angle, motion.speed, motion.height, motion.rotation,
             motion.velocity, motion.angular_velocity, np.array(model.hips[leg]),
             np.array(surface.position), np.array(surface.normal), np.array(surface.area),
             np.array(surface.side), displacement, damping, result.force, result.moment,
             result.depth, result.place)
    return result
