# SPDX-License-Identifier: Apache-2.0
"""A RHex-class robot: sizes, hips, and the surface elements of its half-circle legs.

Frames: `base` has its origin at the middle of the body, x forward, y left, z up. A leg turns about
the hip's +y axis; at angle 0 it points straight down with its convex side to the rear, and a
growing angle moves the foot to the rear (so it drives the robot forward).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from psane_mapping.grid import FloatArray
from psane_mapping.parameters import Configuration, parameter
from psane_mapping.rft import side_area

LEG_NAMES = ('left_front', 'left_middle', 'left_rear', 'right_front', 'right_middle', 'right_rear')
"""The order of the legs in every array of six."""

TRIPOD = (0, 1, 0, 1, 0, 1)
"""Which of the two alternating tripods each leg belongs to."""

SIDE = (0, 0, 0, 1, 1, 1)
"""0 for a left leg, 1 for a right one."""


@dataclass(frozen=True, kw_only=True)
class RobotModel(Configuration):
    """Geometry, masses and motors of a robot with six half-circle legs (default: X-RHex class)."""

    body_length: float = parameter(0.57, 'length of the body', unit='m', low=0.01, high=10.0)
    body_width: float = parameter(0.25, 'width of the body', unit='m', low=0.01, high=10.0)
    body_height: float = parameter(0.08, 'height of the body', unit='m', low=0.005, high=2.0)
    body_mass: float = parameter(7.9, 'mass without the legs', unit='kg', low=0.01, high=500.0)
    leg_mass: float = parameter(0.1, 'mass of one leg', unit='kg', low=0.001, high=50.0)
    leg_inertia: float = parameter(
        3.0e-3, 'inertia of a leg about its hip, rotor included', unit='kg m^2', low=1.0e-6,
        high=10.0)
    hip_spacing: float = parameter(
        0.2, 'distance of the front and rear hips from the middle', unit='m', low=0.01, high=5.0)
    hip_side: float = parameter(
        0.15, 'distance of the front and rear legs from the centre line', unit='m', low=0.005,
        high=5.0)
    hip_side_middle: float = parameter(
        0.19, 'distance of the middle legs from the centre line', unit='m', low=0.005, high=5.0)
    hip_above_belly: float = parameter(
        0.04, 'height of the hip axes above the belly', unit='m', low=0.0, high=2.0)
    leg_radius: float = parameter(
        0.0875, 'radius of the half circle of a leg', unit='m', low=0.005, high=2.0)
    leg_width: float = parameter(0.03, 'width of a leg', unit='m', low=0.001, high=1.0)
    leg_thickness: float = parameter(0.008, 'thickness of a leg', unit='m', low=0.0, high=0.5)
    leg_elements: int = parameter(20, 'surface elements of one leg', low=4, high=200)
    belly_rows: int = parameter(10, 'surface elements along the belly', low=1, high=100)
    belly_columns: int = parameter(4, 'surface elements across the belly', low=1, high=100)
    motor_torque_limit: float = parameter(
        12.0, 'largest torque of a hip motor', unit='N m', low=0.01, high=1000.0)
    motor_gain: float = parameter(
        40.0, 'speed added for each radian of angle error', unit='1/s', low=0.1, high=500.0)

    @cached_property
    def hips(self) -> FloatArray:
        """Hip positions, shape (6, 3), base frame [m], in the order of `LEG_NAMES`."""
        height = self.hip_above_belly - self.body_height / 2.0
        rows = (self.hip_spacing, 0.0, -self.hip_spacing)
        sides = (self.hip_side, self.hip_side_middle, self.hip_side)
        hips = np.array([(x, sign * y, height) for sign in (1.0, -1.0)
                         for x, y in zip(rows, sides, strict=True)])
        hips.setflags(write=False)
        return hips

    @cached_property
    def leg(self) -> 'Surface':
        """Surface elements of one leg at angle 0, relative to its hip."""
        return leg_surface(self)

    @cached_property
    def belly(self) -> 'Surface':
        """Surface elements of the belly, base frame."""
        return belly_surface(self)

    @property
    def mass(self) -> float:
        """Mass of the whole robot [kg]."""
        return self.body_mass + 6.0 * self.leg_mass


@dataclass(frozen=True)
class Surface:
    """Small plates that together make up a surface.

    Parameters
    ----------
    position : (n, 3) float [m]
        Centres of the elements.
    normal : (n, 3) float [-]
        Unit normals (either side).
    area, side : (n,) float [m^2]
        Area, and equivalent area against sideways motion (`rft.side_area`).
    """

    position: FloatArray
    normal: FloatArray
    area: FloatArray
    side: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name in ('position', 'normal', 'area', 'side'):
            array = np.array(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)


def leg_surface(model: RobotModel) -> Surface:
    """Cut the half circle of a leg into equal arcs, from the hip to the tip."""
    arc = math.pi / model.leg_elements
    angle = (np.arange(model.leg_elements) + 0.5) * arc
    radius = model.leg_radius
    zero = np.zeros_like(angle)
    normal = np.column_stack((-np.sin(angle), zero, np.cos(angle)))
    position = radius * normal - np.array([0.0, 0.0, radius])
    length = np.full_like(angle, radius * arc)
    area = length * model.leg_width
    return Surface(position, normal, area, side_area(area, model.leg_thickness, length))


def belly_surface(model: RobotModel) -> Surface:
    """Cut the underside of the body into equal rectangles."""
    rows, columns = model.belly_rows, model.belly_columns
    x = ((np.arange(rows) + 0.5) / rows - 0.5) * model.body_length
    y = ((np.arange(columns) + 0.5) / columns - 0.5) * model.body_width
    x, y = np.meshgrid(x, y, indexing='ij')
    position = np.column_stack((x.ravel(), y.ravel(), np.full(x.size, -model.body_height / 2.0)))
    normal = np.tile([0.0, 0.0, -1.0], (x.size, 1))
    area = np.full(x.size, model.body_length * model.body_width / x.size)
    return Surface(position, normal, area, side_area(area, 0.0, area))


def elements_in_base(model: RobotModel, leg: int, angle: float) -> tuple[FloatArray, FloatArray]:
    """Return positions [m] and unit normals of a leg's elements, each (n, 3), base frame."""
    cosine, sine = math.cos(angle), math.sin(angle)
    turn = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    return model.hips[leg] + model.leg.position @ turn.T, model.leg.normal @ turn.T
