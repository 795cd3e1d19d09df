# SPDX-License-Identifier: Apache-2.0
"""The words for every situation in which the robot does not simply go on."""

import math
from dataclasses import replace

from psane_mapping.grid import FloatArray
from psane_planner.configuration import PlannerConfiguration
from psane_planner.goal import Refusal
from psane_planner.scene import Scene
from psane_planner.status import Decision, PlannerState

WAITING = Decision(state=PlannerState.WAITING, cause='no map or no pose has arrived',
                   remedy='start the mapper and the odometry')

IDLE = Decision(state=PlannerState.WAITING, cause='there is no task',
                remedy='set a goal or explore')


def refused(refusal: Refusal) -> Decision:
    """Say why the goal is not taken."""
    return Decision(state=PlannerState.STALLED, cause=refusal.cause, remedy=refusal.remedy,
                    is_refused=True)


def without_region(scene: Scene, lasted: float, configuration: PlannerConfiguration) -> Decision:
    """Feel the ground on the spot, and say so when that has not helped for too long.

    Parameters
    ----------
    lasted : float [s]
        How long there has been no region around the robot.
    """
    if not scene.component.any():
        what = 'nothing is certified around the robot'
    elif scene.is_lost:
        what = 'the robot is off certified ground and what is left of it is too small'
    else:
        what = 'the certified ground around the robot is too narrow to steer in'
    if scene.is_lost:
        return Decision(state=PlannerState.LOST, cause=what, march=True,
                        remedy='feel the ground on the spot; carry the robot to firm ground')
    if lasted < configuration.bootstrap_time:
        return Decision(state=PlannerState.SEEKING, cause=f'{what}; feeling it on the spot',
                        march=True)
    return Decision(
        state=PlannerState.STALLED, march=True,
        cause=f'{what}, after {lasted:.0f} s of feeling it on the spot',
        remedy='start on firmer ground, check that contacts arrive, or raise slip_threshold')


def too_weak(weakening: float) -> Decision:
    """Stop, because strides slip far more than touch promised.

    Parameters
    ----------
    weakening : float [-]
        Logarithm of true over felt strength.
    """
    return Decision(
        state=PlannerState.STALLED,
        cause=f'strides slip as on ground {100.0 * (1.0 - math.exp(weakening)):.0f} % weaker '
              'than touch says; the map cannot be trusted',
        remedy='calibrate touch and slip for this robot and ground, or lower slip_threshold')


def lost(scene: Scene, subgoal: FloatArray) -> Decision:
    """Lead the robot back by the shortest way."""
    return Decision(
        state=PlannerState.LOST, subgoal=subgoal,
        cause=f'the robot is {scene.outside_distance:.2f} m outside certified ground; '
              'going back to the nearest point of it',
        remedy='nothing if it gets back by itself; otherwise carry it to certified ground')


def naive(goal: FloatArray | None) -> Decision:
    """Walk straight to the goal."""
    if goal is None:
        return Decision(state=PlannerState.STALLED, cause='this strategy needs a goal',
                        remedy='set a goal, or explore with another strategy')
    return Decision(state=PlannerState.TO_GOAL, subgoal=goal, subgoal_is_goal=True,
                    cause='straight to the goal, nothing is certified')


def nothing_left(scene: Scene, lasted: float, is_resting: bool, is_goal_cut_off: bool,
                 configuration: PlannerConfiguration) -> Decision:
    """End the search, or say why it cannot go on.

    Parameters
    ----------
    lasted : float [s]
        How long no frontier has been eligible.
    is_resting : bool
        Whether there are frontiers that were set aside.
    is_goal_cut_off : bool
        Whether ground known to be unsafe separates the robot from the goal.
    """
    why = ('every frontier left was visited in vain' if is_resting
           else 'no frontier is left that could grow')
    if lasted < configuration.settle_time:
        return Decision(state=PlannerState.SEEKING, march=True,
                        cause=f'{why}; feeling on before giving up')
    if scene.goal is None:
        return Decision(state=PlannerState.EXPLORED, cause=why)
    behind = ('ground known to be unsafe' if is_goal_cut_off
              else f'ground that is not certified at slip_threshold = '
                   f'{configuration.slip_threshold:g}')
    return Decision(state=PlannerState.STALLED, march=True,
                    remedy='set another goal, or accept more slip by a higher slip_threshold',
                    cause=f'{why}; the goal lies behind {behind}')


def without_growth(decision: Decision, lasted: float, is_explored: bool) -> Decision:
    """End a search that wins nothing, or report it.

    Parameters
    ----------
    decision : Decision
        To go on searching.
    lasted : float [s]
        How long the certified area has not grown.
    is_explored : bool
        Whether there is no goal, and the robot got to each frontier that it has sought since.
    """
    cause = f'the certified area has not grown for {lasted:.0f} s'
    if is_explored:
        return replace(decision, state=PlannerState.EXPLORED,
                       cause=f'{cause}: each frontier that was sought since was visited in vain')
    return replace(
        decision, state=PlannerState.STALLED, cause=cause,
        remedy='set another goal, take another strategy or raise slip_threshold; '
               'the search goes on meanwhile')
