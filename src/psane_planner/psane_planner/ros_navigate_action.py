# SPDX-License-Identifier: Apache-2.0
"""The action `navigate_safely`: one errand at a time; a newer one takes its place."""

from collections.abc import Callable
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future

from psane_mapping.conversions import pose_message
from psane_msgs.action import NavigateSafely
from psane_planner.navigation import End, Errand, ErrorCode
from psane_planner.status import Plan

Begin = Callable[[Any], End | None]


class NavigateAction:
    """Serves the action; the node that plans tells it of every plan.

    Parameters
    ----------
    node : Node
    begin : callable
        Takes the request; returns None, or how the errand ends before it began.
    stop : callable
        Drops the goal.
    """

    def __init__(self, node: Node, begin: Begin, stop: Callable[[], None]) -> None:
        self._node = node
        self._begin = begin
        self._stop = stop
        self._errand: Errand | None = None
        self._over: Future | None = None
        self._length = 0.0
        self._server = ActionServer(
            node, NavigateSafely, 'navigate_safely', self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT)

    def preempt(self) -> None:
        """End the errand under way in favour of another goal."""
        self._finish(End(ErrorCode.PREEMPTED, 'another goal took the place of this one'))

    def take(self, plan: Plan, length: float, frame: str) -> None:
        """Tell who gave the errand how it goes, and end it when it is over.

        Parameters
        ----------
        length : float
            Of all the way walked so far [m].
        """
        self._length = length
        if self._errand is None:
            return
        handle = self._handle
        if handle.is_cancel_requested:
            self._stop()
            self._finish(End(ErrorCode.NONE, 'cancelled'))
            return
        handle.publish_feedback(_feedback(plan, frame))
        end = self._errand.end(plan)
        if end is not None:
            if end.code is not ErrorCode.NONE:
                self._stop()
            self._finish(end)

    def _finish(self, end: End) -> None:
        self._errand = None
        if self._over is not None and not self._over.done():
            self._over.set_result(end)

    async def _execute(self, handle: ServerGoalHandle) -> NavigateSafely.Result:
        """Wait for the end of the errand while the node goes on planning."""
        self.preempt()
        refusal = self._begin(handle.request)
        errand = Errand(self._now(), self._length)
        if refusal is not None:
            handle.abort()
            return _result(refusal, errand, self._now(), self._length)
        self._handle, self._errand = handle, errand
        over = Future()
        self._over = over
        end: End = await over
        if handle.is_cancel_requested:
            handle.canceled()
        elif end.code is ErrorCode.NONE:
            handle.succeed()
        else:
            handle.abort()
        return _result(end, errand, self._now(), self._length)

    def _now(self) -> float:
        return float(self._node.get_clock().now().nanoseconds) * 1e-9


def _result(end: End, errand: Errand, now: float, length: float) -> NavigateSafely.Result:
    return NavigateSafely.Result(error_code=int(end.code), message=end.message,
                                 time_s=errand.time(now), path_length=errand.walked(length))


def _feedback(plan: Plan, frame: str) -> NavigateSafely.Feedback:
    feedback = NavigateSafely.Feedback(
        state=int(plan.state), distance_to_goal=float(plan.distance_to_goal),
        certified_area=float(plan.certified_area), coverage=float(plan.component.mean()))
    if plan.subgoal is not None:
        feedback.subgoal = pose_message(plan.subgoal, 0.0, plan.now, frame)
    return feedback
