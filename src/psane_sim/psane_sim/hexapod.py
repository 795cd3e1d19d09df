# SPDX-License-Identifier: Apache-2.0
"""The simulated hexapod: rigid-body dynamics by pybullet, ground by a `Soil`, legs by the gait."""

import math
from types import TracebackType

import numpy as np
import pybullet
from numba import njit

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.errors import FallenError, StartError
from psane_sim.gait import Gait
from psane_sim.robot_body import load_robot
from psane_sim.soil import BODY, GranularSoil, GroundLoad, RobotState, Soil
from psane_sim.terrain import Terrain
from psane_sim.truth import Truth

GRAVITY = 9.81
_LEGS = list(range(6))
_SPECIFIC_FORCE_SPAN = 0.005
_SPEED_LIMIT = 25.0


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


@njit(cache=True)
def _motor_speeds(reference: FloatArray, reference_speed: FloatArray, angle: FloatArray,
                  gain: float, limit: float, target: FloatArray) -> None:
    """Write the speeds that the hip motors are told: reference speed + gain * angle error."""
    for leg in range(6):
        error = (reference[leg] - angle[leg] + math.pi) % (2.0 * math.pi) - math.pi
        target[leg] = max(-limit, min(limit, reference_speed[leg] + gain * error))


class HexapodSimulator:
    """A hexapod on granular ground, stepped at `time_step`.

    Parameters
    ----------
    config : SimulatorConfiguration
    terrain : Terrain
    start_pose : (x, y, yaw), optional
        Map frame [m], [rad]; the terrain's own start, facing its goal, if there is none.
    robot : RobotModel, optional
    soil : Soil, optional
        Granular ground with the terrain's strength if there is none.

    Raises
    ------
    StartError
        For a start outside the workspace or not finite.
    """

    def __init__(self, config: SimulatorConfiguration, terrain: Terrain,
                 start_pose: tuple[float, float, float] | None = None, *,
                 robot: RobotModel | None = None, soil: Soil | None = None) -> None:
        self.config = config
        self.terrain = terrain
        self.robot = robot or RobotModel()
        self.soil: Soil = soil or GranularSoil(
            self.robot, terrain.strength_field, displacement=config.soil_displacement,
            damping=config.soil_damping)
        self.gait = Gait(config)
        self._state = RobotState.zeros()
        self._raw = np.zeros(25)
        self._target = np.zeros(6)
        self._joints: tuple = ()
        self._load = GroundLoad.zeros()
        self._recent = np.zeros((max(1, round(_SPECIFIC_FORCE_SPAN / config.time_step)) + 1, 3))
        self._ticks = 0
        self._client = self._connect()
        self._place(terrain.start_pose if start_pose is None else start_pose)
        self.step(round(config.settling_time / config.time_step))
        self._ticks = 0

    def _connect(self) -> int:
        """Open an engine of our own and load the robot."""
        mode = pybullet.GUI if self.config.gui else pybullet.DIRECT
        client = int(pybullet.connect(mode))
        pybullet.setPhysicsEngineParameter(fixedTimeStep=self.config.time_step,
                                           numSolverIterations=10, physicsClientId=client)
        pybullet.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=client)
        self._body = load_robot(self.robot, client, visible=self.config.gui)
        for link in range(-1, 6):
            pybullet.changeDynamics(self._body, link, linearDamping=0.0, angularDamping=0.0,
                                    jointDamping=0.0, physicsClientId=client)
        for leg in _LEGS:
            pybullet.enableJointForceTorqueSensor(self._body, leg, True, physicsClientId=client)
        return client

    def _place(self, pose: tuple[float, float, float]) -> None:
        """Put the robot at a pose, legs straight down and just touching the ground."""
        x, y, yaw = pose
        if not all(math.isfinite(value) for value in pose):
            raise StartError(f'start pose {pose} holds a number that is not finite')
        if not self.terrain.contains((x, y)):
            raise StartError(f'start ({x:g}, {y:g}) m lies outside the workspace, expected '
                             f'{self.terrain.extent_text}')
        hip_height = float(self.robot.hips[0, 2])
        height = 2.0 * self.robot.leg_radius - hip_height
        half = 0.5 * yaw
        pybullet.resetBasePositionAndOrientation(
            self._body, [x, y, height], [0.0, 0.0, math.sin(half), math.cos(half)],
            physicsClientId=self._client)
        self.soil.reset()
        self._read()

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""
        return self._ticks * self.config.time_step

    def command(self, linear: float, angular: float) -> None:
        """Ask for a forward speed [m/s] and a yaw rate [rad/s]; exactly (0, 0) means stand."""
        self.gait.command(linear, angular)

    def step(self, ticks: int = 1) -> None:
        """Move on by some ticks of `time_step`.

        Raises
        ------
        FallenError
            When the state is not finite any more.
        """
        for _ in range(ticks):
            self._tick()
        if not np.isfinite(self._raw).all():
            raise FallenError(f'the simulated state is not finite at {self.time:.3f} s')

    def _tick(self) -> None:
        """Ground and motors act on the present state, then the engine moves it on."""
        reference = self.gait.tick()
        self._load = self.soil.load(self._state, self.config.time_step)
        self._push(self._load)
        _motor_speeds(reference.angle, reference.speed, self._state.angle,
                      self.robot.motor_gain, _SPEED_LIMIT, self._target)
        pybullet.setJointMotorControlArray(
            self._body, _LEGS, pybullet.VELOCITY_CONTROL,
            targetVelocities=self._target.tolist(),
            forces=[self.robot.motor_torque_limit] * 6, physicsClientId=self._client)
        pybullet.stepSimulation(physicsClientId=self._client)
        self._ticks += 1
        self._read()

    def _push(self, load: GroundLoad) -> None:
        """Hand the ground's forces to the engine: at each hip, and at the body's origin."""
        client, body = self._client, self._body
        origin = self._state.position
        hips = (origin + self.robot.hips @ self._state.rotation.T).tolist()
        forces, moments = load.force.tolist(), load.moment.tolist()
        for leg in range(7):
            if load.depth[leg] <= 0.0:
                continue
            link, place = (leg, hips[leg]) if leg < BODY else (-1, origin.tolist())
            pybullet.applyExternalForce(body, link, forces[leg], place, pybullet.WORLD_FRAME,
                                        physicsClientId=client)
            pybullet.applyExternalTorque(body, link, moments[leg], pybullet.WORLD_FRAME,
                                         physicsClientId=client)

    def _read(self) -> None:
        """Read the engine's state into the arrays that the soil sees."""
        client, body, raw = self._client, self._body, self._raw
        position, attitude = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
        velocity, angular = pybullet.getBaseVelocity(body, physicsClientId=client)
        joints = pybullet.getJointStates(body, _LEGS, physicsClientId=client)
        raw[:] = (*position, *attitude, *velocity, *angular, *[joint[0] for joint in joints],
                  *[joint[1] for joint in joints])
        state = self._state
        _unpack(raw, state.position, state.rotation, state.velocity, state.angular_velocity,
                state.angle, state.speed)
        self._joints = joints
        self._recent[self._ticks % len(self._recent)] = velocity

    def truth(self) -> Truth:
        """Return a copy of everything that the simulator knows of its present state."""
        state, load = self._state, self._load
        hip_force, hip_moment = self._hip_wrenches()
        return Truth(
            time=self.time, position=state.position.copy(), quaternion=self._raw[3:7].copy(),
            rotation=state.rotation.copy(), velocity=state.velocity.copy(),
            angular_velocity=state.angular_velocity.copy(),
            specific_force=self._specific_force(), joint_angle=state.angle.copy(),
            joint_speed=state.speed.copy(),
            joint_torque=np.array([joint[3] for joint in self._joints]),
            hip_force=hip_force, hip_moment=hip_moment, foot_force=load.force[:BODY].copy(),
            foot=load.foot[:BODY].copy(), foot_depth=load.depth[:BODY].copy(),
            belly_depth=float(load.depth[BODY]), belly_force=load.force[BODY].copy())

    def _specific_force(self) -> FloatArray:
        """Return the accelerometer's reading over the last few ticks, base frame [m/s^2]."""
        span = len(self._recent) - 1
        newest = self._recent[self._ticks % len(self._recent)]
        oldest = self._recent[(self._ticks + 1) % len(self._recent)]
        acceleration = (newest - oldest) / (span * self.config.time_step)
        return np.asarray((acceleration + (0.0, 0.0, GRAVITY)) @ self._state.rotation)

    def _hip_wrenches(self) -> tuple[FloatArray, FloatArray]:
        """Turn the engine's joint reactions into what each leg does to the body, base frame.

        The engine gives what the body does to the leg, in the leg's turning frame, and leaves
        out the motor's own torque about the hip axis.
        """
        reaction = -np.array([joint[2] for joint in self._joints])
        reaction[:, 4] -= [joint[3] for joint in self._joints]
        cosine, sine = np.cos(self._state.angle), np.sin(self._state.angle)
        turned = []
        for part in (reaction[:, :3], reaction[:, 3:]):
            turned.append(np.column_stack((cosine * part[:, 0] + sine * part[:, 2], part[:, 1],
                                           -sine * part[:, 0] + cosine * part[:, 2])))
        return turned[0], turned[1]

    def close(self) -> None:
        """Close the engine; the simulator cannot be used afterwards."""
        if self._client >= 0:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = -1

    def __enter__(self) -> 'HexapodSimulator':
        """Return the simulator itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        """Close the engine."""
        self.close()
