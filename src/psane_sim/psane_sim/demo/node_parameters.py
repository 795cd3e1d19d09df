# SPDX-License-Identifier: Apache-2.0
"""An assignment as the configurations of the core, and as parameters of the nodes."""

from pathlib import Path

from psane_planner.configuration import PlannerConfiguration
from psane_sim.demo.options import Assignment
from psane_sim.runs.closed_loop import Settings


def settings_of(assignment: Assignment, *, gui: bool = False) -> Settings:
    """Return the configurations for a run in one process."""
    task, robot = assignment.task, assignment.robot
    return Settings(
        simulator=robot.simulator_configuration(gui=gui),
        touch=robot.touch_configuration(), mapping=robot.mapping_configuration(),
        robot=robot.model,
        planner=PlannerConfiguration(strategy=task.strategy, slip_threshold=task.threshold))


def simulator_parameters(assignment: Assignment, pace: float,
                         truth_file: Path) -> dict[str, object]:
    """Return the parameters of `hexapod_sim`."""
    task, robot = assignment.task, assignment.robot
    x, y, yaw = assignment.start_pose
    return {'terrain': task.terrain, 'use_start': True, 'start_x': x, 'start_y': y,
            'start_yaw': yaw, 'seed': task.seed, 'pace': pace,
            'truth_file': truth_file.resolve(), 'strength_factor': robot.strength_factor,
            **robot.model_parameters, **robot.simulator}


def listener_parameters(assignment: Assignment, name: str) -> dict[str, object]:
    """Return the parameters of a node that must be up before the world begins."""
    task, robot = assignment.task, assignment.robot
    parameters: dict[str, object] = {'use_sim_time': True}
    if name == 'contact_sensor':
        parameters.update(**robot.model_parameters, **robot.touch)
    if name == 'terrain_mapper':
        parameters.update(robot.mapping)
    if name == 'safe_planner':
        parameters.update(strategy=task.strategy, slip_threshold=task.threshold,
                          explore=task.goal is None)
    return parameters
