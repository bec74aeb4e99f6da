"""
An action of a node: one goal at a time, and a newer one preempts it, as in Nav2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse

from quad_common.errors import QuadError
from quad_common.errors.quoting import clipped
from quad_common.ros.guarded_node import GuardedNode
from quad_common.task_result import TaskOutcome, TaskResult


@dataclass(frozen=True)
class GoalPort:
    """What a node does with the goals of an action."""

    check: Callable[[Any], object]
    """Is called with a goal first; a QuadError rejects it."""
    begin: Callable[[Any], object]
    """Is called with a goal that was accepted."""
    cancel: Callable[[], object]
    """Is called when somebody asks to cancel the goal; it ends later."""


class GoalAction:
    """
    Serves an action.

    Parameters
    ----------
    node : GuardedNode
        The node.
    action_type : type
        Type of the action.
    name : str
        Name of the action.
    port : GoalPort
        What the node does with goals.
    """

    def __init__(self, node: GuardedNode, action_type: Any, name: str, port: GoalPort) -> None:
        self.type = action_type
        """Type of the action."""
        self._node = node
        self._name = name
        self._port = port
        self._handle: Any = None
        self._server = _KeptGoals(
            node,
            action_type,
            name,
            execute_callback=lambda handle: action_type.Result(),
            goal_callback=node.guarded(self._on_goal, f"a goal of '{name}'"),
            handle_accepted_callback=node.guarded(self._on_accepted, f"a goal of '{name}'"),
            cancel_callback=node.guarded(self._on_cancel, f"a cancellation of '{name}'"),
        )

    @property
    def is_active(self) -> bool:
        """Whether there is a goal."""
        return self._handle is not None

    def report(self, feedback: Any) -> None:
        """Publish feedback about the goal."""
        if self._handle is not None:
            self._handle.publish_feedback(feedback)

    def succeed(self, result: Any) -> None:
        """End the goal: it was reached."""
        self._end('succeed', result)

    def abort(self, result: Any) -> None:
        """End the goal: it was not reached."""
        self._end('abort', result)

    def canceled(self, result: Any) -> None:
        """End the goal, which somebody asked to cancel."""
        is_asked = self._handle is not None and self._handle.is_cancel_requested
        self._end('canceled' if is_asked else 'abort', result)

    def finish(self, result: TaskResult) -> None:
        """End the goal as a task has ended."""
        end = {
            TaskOutcome.SUCCEEDED: self.succeed,
            TaskOutcome.CANCELED: self.canceled,
            TaskOutcome.ABORTED: self.abort,
        }[result.outcome]
        end(self.type.Result(error_code=int(result.code), error_msg=clipped(result.message)))

    def _end(self, how: str, result: Any) -> None:
        handle, self._handle = self._handle, None
        if handle is not None:
            getattr(handle, how)()
            self._server.answer(handle, result)

    def _on_goal(self, request: Any) -> GoalResponse:
        try:
            self._port.check(request)
        except QuadError as error:
            self._node.report_error(error)
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _on_accepted(self, handle: Any) -> None:
        self.preempt()
        self._handle = handle
        handle.execute()
        try:
            self._port.begin(handle.request)
        except Exception:
            # Reported by the guard; whoever gave the goal must not wait for ever.
            self.abort(self.type.Result())
            raise

    def preempt(self) -> None:
        """Abort the goal, as Nav2 does when a newer one takes its place."""
        result = self.type.Result()
        if hasattr(result, 'error_msg'):
            result.error_msg = 'preempted by a newer goal'
        self.abort(result)

    def _on_cancel(self, handle: Any) -> CancelResponse:
        if handle is not self._handle:
            return CancelResponse.REJECT
        # Once the answer is on its way: the goal counts as canceling from then on.
        self._node.call_soon(partial(self._cancel, handle))
        return CancelResponse.ACCEPT

    def _cancel(self, handle: Any) -> None:
        if handle is self._handle:
            self._port.cancel()


class _KeptGoals(ActionServer):  # type: ignore[misc]
    """
    Goals that go on without a callback that runs all the while.

    A coroutine that waits would be asked again and again by rclpy's executors, which takes a
    processor: so goals are executed when they end, and what they bring is known.
    """

    def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
        """Keep a goal; see rclpy's ActionServer. It is answered by :meth:`answer`."""

    def answer(self, goal_handle: Any, result: Any) -> None:
        """Hand the result of a goal that has ended to whoever asks for it."""
        super().notify_execute(goal_handle, lambda handle: result)
