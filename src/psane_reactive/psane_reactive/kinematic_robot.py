# SPDX-License-Identifier: Apache-2.0
"""A unicycle that does exactly what it is told, to try the steering without physics."""

import math
import time
from dataclasses import dataclass, field

import numpy as np
import shapely

from psane_mapping.grid import FloatArray
from psane_reactive.clearance import Border
from psane_reactive.command import Mode
from psane_reactive.controller import ReactiveController
from psane_reactive.safety_stop import advance

_HEARTBEAT = 2.0


@dataclass
class Drive:
    """What became of one drive to a goal.

    Parameters
    ----------
    has_arrived : bool
    time, length : float
        Simulated time [s] and way driven, forwards and backwards [m].
    deepest_outside : float
        Largest signed distance outside the region, negative when it stayed inside [m].
    tick_times : list of float
        Wall-clock time of each command [s].
    modes : dict
        Number of commands of each mode.
    """

    has_arrived: bool = False
    time: float = 0.0
    length: float = 0.0
    deepest_outside: float = -math.inf
    tick_times: list[float] = field(default_factory=list)
    modes: dict[Mode, int] = field(default_factory=dict)


def drive_to(controller: ReactiveController, region: shapely.Polygon, start: FloatArray,
             yaw: float, goal: FloatArray, step: float = 0.05, limit: float = 900.0) -> Drive:
    """Drive a unicycle from a start to a goal, (2,) [m], inside a region; at most `limit` [s]."""
    border = Border(region)
    drive = Drive()
    pose = (float(start[0]), float(start[1]), yaw)
    velocity = (0.0, 0.0)
    heard = -math.inf
    while drive.time < limit:
        now = drive.time
        if now - heard >= _HEARTBEAT:
            controller.set_region(region, now)
            controller.set_subgoal(goal, False, True, now)
            heard = now
        controller.set_odometry(pose, velocity, now)
        begin = time.perf_counter()
        command = controller.command(now)
        drive.tick_times.append(time.perf_counter() - begin)
        drive.modes[command.mode] = drive.modes.get(command.mode, 0) + 1
        if command.mode is Mode.ARRIVED:
            drive.has_arrived = True
            break
        velocity = (command.linear, command.angular)
        aside = command.lateral * step
        pose = advance(*pose, *velocity, step)
        pose = (pose[0] - aside * math.sin(pose[2]), pose[1] + aside * math.cos(pose[2]), pose[2])
        drive.length += math.hypot(command.linear, command.lateral) * step
        drive.time += step
        drive.deepest_outside = max(drive.deepest_outside,
                                    border.outside_distance(np.array(pose)))
    return drive
