# SPDX-License-Identifier: Apache-2.0
"""The simulated hexapod: rigid-body dynamics by pybullet, ground by a `Soil`, legs by the gait."""

import math
from types import TracebackType

import numpy as np
from numba import njit
from numpy.typing import NDArray

from psane_mapping.grid import FloatArray
from psane_mapping.leg import RobotModel
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.errors import FallenError, StartError
from psane_sim.robot.engine import Engine
from psane_sim.robot.feed_forward import Sweep
from psane_sim.robot.gait import Gait
from psane_sim.robot.gravity import GRAVITY
from psane_sim.robot.render import Camera, Renderer, add_ground
from psane_sim.robot.truth import Truth
from psane_sim.soils.choice import soil_of
from psane_sim.soils.soil import BODY, GroundLoad, Soil
from psane_sim.terrains.terrain import Terrain

_SENSOR_SPAN = 0.005
_SPEED_LIMIT = 25.0


@njit(cache=True)
def _motor_speeds(reference: FloatArray, reference_speed: FloatArray, angle: FloatArray,
                  gain: float, limit: float, target: FloatArray) -> None:
    """Write the speeds that the hip motors are told: reference speed + gain * angle error."""
    for leg in range(6):
        error = (reference[leg] - angle[leg] + math.pi) % (2.0 * math.pi) - math.pi
        target[leg] = max(-limit, min(limit, reference_speed[leg] + gain * error))


class HexapodSimulator:
    """A hexapod on granular ground, stepped at `time_step`; nothing in it is random.

    Parameters
    ----------
    config : SimulatorConfiguration
    terrain : Terrain
    start_pose : (x, y, yaw), optional
        Map frame [m], [rad]; the terrain's own start, facing its goal, if there is none.
    robot : RobotModel, optional
    soil : Soil, optional
        The soil of the configuration with the terrain's strength if there is none.

    Raises
    ------
    StartError
        For a start outside the workspace or not finite.
    """

    def __init__(self, config: SimulatorConfiguration, terrain: Terrain,
                 start_pose: tuple[float, float, float] | None = None, *,
                 robot: RobotModel | None = None, soil: Soil | None = None) -> None:
        pose = _checked(terrain.start_pose if start_pose is None else start_pose, terrain)
        self.config = config
        self.terrain = terrain
        self.robot = robot or RobotModel()
        self.soil: Soil = soil or soil_of(config, self.robot, terrain)
        self.gait = Gait(config)
        self._renderer: Renderer | None = None
        self._load = GroundLoad.zeros()
        self._target = np.zeros(6)
        self._recent = np.zeros((max(1, round(_SENSOR_SPAN / config.time_step)) + 1, 9))
        self._ticks = 0
        self.engine = Engine(self.robot, config.time_step, gui=config.gui)
        if config.gui:
            add_ground(terrain, self.engine.client)
        height = (terrain.height_at(pose[0], pose[1]) + 2.0 * self.robot.leg_radius
                  - float(self.robot.hips[0, 2]))
        self.engine.place(pose[0], pose[1], height, pose[2])
        self.step(round(config.settling_time / config.time_step))
        self._ticks = 0
        self._remember()

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""
        return self._ticks * self.config.time_step

    def command(self, linear: float, angular: float) -> None:
        """Ask for a forward speed [m/s] and a yaw rate [rad/s]; exactly (0, 0) means stand."""
        self.gait.command(linear, angular)

    def walk(self, sweep: Sweep) -> None:
        """Ask for stance sweeps instead."""
        self.gait.walk(sweep)

    def step(self, ticks: int = 1) -> None:
        """Move on by some ticks of `time_step`.

        Raises
        ------
        FallenError
            When the state is not finite any more.
        """
        for _ in range(ticks):
            self._tick()
        if not self.engine.is_finite:
            raise FallenError(f'the simulated state is not finite at {self.time:.3f} s')

    def _tick(self) -> None:
        """Ground and motors act on the present state, then the engine moves it on."""
        self.gait.tick()
        self._load = self.soil.load(self.engine.state, self.config.time_step)
        self.apply_forces()
        self.engine.step()
        self.engine.read()
        self._ticks += 1
        self._remember()

    def apply_forces(self) -> None:
        """Hand the ground's forces and the motors' speeds to the engine for its next step."""
        reference, robot = self.gait.reference, self.robot
        self.engine.push(self._load)
        _motor_speeds(reference.angle, reference.speed, self.engine.state.angle,
                      robot.motor_gain, _SPEED_LIMIT, self._target)
        self.engine.drive(self._target)

    def _remember(self) -> None:
        """Keep velocity and motor torques of the last few ticks, for sensors that average."""
        engine = self.engine
        self._recent[self._ticks % len(self._recent)] = (*engine.state.velocity, *engine.torques)

    def truth(self) -> Truth:
        """Return a copy of everything that the simulator knows of its present state."""
        engine, state, load = self.engine, self.engine.state, self._load
        oldest = self._recent[(self._ticks + 1) % len(self._recent)]
        newest = self._recent[self._ticks % len(self._recent)]
        span = len(self._recent) - 1
        torque = (self._recent.sum(axis=0) - oldest)[3:] / span
        acceleration = (newest - oldest)[:3] / (span * self.config.time_step)
        hip_force, hip_moment = engine.hip_wrenches(torque)
        return Truth(
            time=self.time, position=state.position.copy(), quaternion=engine.quaternion.copy(),
            rotation=state.rotation.copy(), velocity=state.velocity.copy(),
            angular_velocity=state.angular_velocity.copy(),
            specific_force=(acceleration + (0.0, 0.0, GRAVITY)) @ state.rotation,
            joint_angle=state.angle.copy(), joint_speed=state.speed.copy(), joint_torque=torque,
            hip_force=hip_force, hip_moment=hip_moment, foot_force=load.force[:BODY].copy(),
            foot=load.foot[:BODY].copy(), foot_depth=load.depth[:BODY].copy(),
            belly_depth=float(load.depth[BODY]), belly_force=load.force[BODY].copy(),
            sweep=self.gait.sweep)

    def render(self, width: int = 640, height: int = 480,
               camera: Camera | None = None) -> NDArray[np.uint8]:
        """Draw the present state; returns (height, width, 3) uint8, red green blue."""
        if self._renderer is None:
            self._renderer = Renderer(self.terrain, self.robot)
        return self._renderer.frame(self.truth(), width, height, camera)

    def close(self) -> None:
        """Close the engine; the simulator cannot be used afterwards."""
        self.engine.close()
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def __enter__(self) -> 'HexapodSimulator':
        """Return the simulator itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        """Close the engine."""
        self.close()


def _checked(pose: tuple[float, float, float], terrain: Terrain) -> tuple[float, float, float]:
    """Refuse a start pose that is not finite or not in the workspace."""
    x, y, yaw = (float(value) for value in pose)
    if not all(math.isfinite(value) for value in (x, y, yaw)):
        raise StartError(f'start pose {pose} holds a number that is not finite')
    if not terrain.contains((x, y)):
        raise StartError(f'start ({x:g}, {y:g}) m lies outside the workspace, expected '
                         f'{terrain.extent_text}')
    return x, y, yaw
