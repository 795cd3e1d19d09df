# SPDX-License-Identifier: Apache-2.0
"""The robot in a pybullet engine of its own: forces and motor speeds in, state out."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_sim.errors import SimulationError
from psane_sim.robot.gravity import GRAVITY
from psane_sim.robot.quiet_pybullet import pybullet
from psane_sim.robot.robot_body import load_robot
from psane_sim.soils.soil import BODY, GroundLoad, RobotState

_LEGS = list(range(6))


@njit(cache=True)
def _unpack(raw: FloatArray, position: FloatArray, rotation: FloatArray, velocity: FloatArray,
            angular: FloatArray, angle: FloatArray, speed: FloatArray) -> None:
    """Spread the engine's numbers over the arrays of a `RobotState`."""
    position[:] = raw[0:3]
    x, y, z, w = raw[3], raw[4], raw[5], raw[6]
    rotation[0, 0], rotation[0, 1], rotation[0, 2] = (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w))
    rotation[1, 0], rotation[1, 1], rotation[1, 2] = (
        2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w))
    rotation[2, 0], rotation[2, 1], rotation[2, 2] = (
        2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y))
    velocity[:] = raw[7:10]
    angular[:] = raw[10:13]
    angle[:] = raw[13:19]
    speed[:] = raw[19:25]


class Engine:
    """Rigid-body dynamics of one robot; several engines may live in one process.

    Parameters
    ----------
    robot : RobotModel
    time_step : float [s]
    gui : bool
        Show the engine's own window, with the robot's shapes.

    Raises
    ------
    SimulationError
        When there is no display for the window.
    """

    def __init__(self, robot: RobotModel, time_step: float, *, gui: bool = False) -> None:
        self._torque_limits = [robot.motor_torque_limit] * 6
        self.client = int(pybullet.connect(pybullet.GUI if gui else pybullet.DIRECT))
        if self.client < 0:
            raise SimulationError("the engine's window cannot be opened; is there a display?")
        pybullet.setPhysicsEngineParameter(fixedTimeStep=time_step, numSolverIterations=10,
                                           physicsClientId=self.client)
        pybullet.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=self.client)
        self._body = load_robot(robot, self.client, visible=gui)
        for link in range(-1, 6):
            pybullet.changeDynamics(self._body, link, linearDamping=0.0, angularDamping=0.0,
                                    jointDamping=0.0, physicsClientId=self.client)
        for leg in _LEGS:
            pybullet.enableJointForceTorqueSensor(self._body, leg, True,
                                                  physicsClientId=self.client)
        self.state = RobotState.zeros()
        self._raw = np.zeros(25)
        self._joints: Sequence[Sequence[Any]] = ()
        self.read()

    @property
    def quaternion(self) -> FloatArray:
        """Attitude of the base in the map, x y z w [-]."""
        return self._raw[3:7]

    @property
    def torques(self) -> list[float]:
        """Torques of the motors on the legs in the last step [N m]."""
        return [joint[3] for joint in self._joints]

    @property
    def is_finite(self) -> bool:
        """False when the simulation has blown up."""
        return bool(np.isfinite(self._raw).all())

    def place(self, x: float, y: float, z: float, yaw: float) -> None:
        """Put the level robot somewhere, legs as they are [m], [rad]."""
        pybullet.resetBasePositionAndOrientation(
            self._body, [x, y, z], [0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)],
            physicsClientId=self.client)
        self.read()

    def push(self, load: GroundLoad) -> None:
        """Hand over the ground's forces for the next step."""
        client, body = self.client, self._body
        rows = zip(range(7), load.depth.tolist(), load.force.tolist(), load.moment.tolist(),
                   load.place.tolist(), strict=True)
        for row, depth, force, moment, place in rows:
            if depth > 0.0:
                link = row if row < BODY else -1
                pybullet.applyExternalForce(body, link, force, place, pybullet.WORLD_FRAME,
                                            physicsClientId=client)
                pybullet.applyExternalTorque(body, link, moment, pybullet.WORLD_FRAME,
                                             physicsClientId=client)

    def drive(self, speeds: FloatArray) -> None:
        """Tell the motors their speeds for the next step, (6,) [rad/s]."""
        pybullet.setJointMotorControlArray(
            self._body, _LEGS, pybullet.VELOCITY_CONTROL, targetVelocities=speeds.tolist(),
            forces=self._torque_limits, physicsClientId=self.client)

    def step(self) -> None:
        """Move on by one time step."""
        pybullet.stepSimulation(physicsClientId=self.client)

    def read(self) -> None:
        """Read the state into `state`."""
        client, body, state = self.client, self._body, self.state
        position, attitude = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
        velocity, angular = pybullet.getBaseVelocity(body, physicsClientId=client)
        joints = pybullet.getJointStates(body, _LEGS, physicsClientId=client)
        self._raw[:] = (*position, *attitude, *velocity, *angular,
                        *[joint[0] for joint in joints], *[joint[1] for joint in joints])
        _unpack(self._raw, state.position, state.rotation, state.velocity,
                state.angular_velocity, state.angle, state.speed)
        self._joints = joints

    def hip_wrenches(self, torque: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what each leg does to the body, (6, 3) [N] and (6, 3) [N m], base frame.

        The engine gives what the body does to the leg, in the leg's turning frame, and leaves
        out the motor's own `torque` (6,) [N m] about the hip axis.
        """
        reaction = -np.array([joint[2] for joint in self._joints])
        reaction[:, 4] -= torque
        cosine, sine = np.cos(self.state.angle), np.sin(self.state.angle)
        force, moment = (
            np.column_stack((cosine * part[:, 0] + sine * part[:, 2], part[:, 1],
                             -sine * part[:, 0] + cosine * part[:, 2]))
            for part in (reaction[:, :3], reaction[:, 3:]))
        return force, moment

    def close(self) -> None:
        """Close the engine; it cannot be used afterwards."""
        if self.client >= 0:
            pybullet.disconnect(physicsClientId=self.client)
            self.client = -1
