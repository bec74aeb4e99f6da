"""
A path that somebody asked the robot to follow, and answers are owed for: Nav2's controller's part.
"""

from __future__ import annotations

from quad_common.plan import Plan
from quad_common.task_result import FollowCode, TaskOutcome, TaskResult
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.wishes import FollowPlan
from quad_gait.supervisor import Supervisor

_PATIENCE = 10.0
"""Time for which the robot may do nothing, or be nowhere, before the task fails [s]."""

_ENDS = {
    Activity.BLOCKED: FollowCode.NO_PROGRESS,
    Activity.STOPPED: FollowCode.NO_CONTROL,
    Activity.NOT_EXECUTED: FollowCode.NO_CONTROL,
}
"""What a plan is followed no farther for, though it is wanted."""


class PathTask:
    """
    One path at a time.

    Parameters
    ----------
    supervisor : Supervisor
        What decides.
    """

    def __init__(self, supervisor: Supervisor) -> None:
        self._supervisor = supervisor
        self._plan: Plan | None = None
        self._is_canceled = False
        self._moved_at: float | None = None

    @property
    def is_followed(self) -> bool:
        """Whether its plan is the one that is wanted."""
        return self._plan is not None and self._supervisor.wanted_plan is self._plan

    def begin(self, plan: Plan) -> TaskResult | None:
        """Follow a plan in the map from the next cycle on; return why not, if it is refused."""
        supervisor = self._supervisor
        supervisor.wish(FollowPlan(plan, is_asked=True))
        self._is_canceled = False
        self._moved_at = None
        if supervisor.wanted_plan is not plan:
            self._plan = None
            return _aborted(FollowCode.NO_CONTROL, supervisor.limit)
        self._plan = plan
        return None

    def cancel(self) -> None:
        """Follow it no farther; the task ends when the robot stands."""
        self._is_canceled = True
        if self._supervisor.wanted_plan is self._plan:
            self._supervisor.set_plan(None)

    def update(self, time: float) -> TaskResult | None:
        """
        Look how the task goes, after the supervisor has decided.

        Parameters
        ----------
        time : float
            Of the measurement that was decided on [s].

        Returns
        -------
        TaskResult or None
            The end of the task; None while it goes on, or if there is none.
        """
        if self._plan is None:
            return None
        result = self._checked(time, self._plan)
        if result is not None:
            self._plan = None
        return result

    def wait(self, silence: float) -> TaskResult | None:
        """
        Look how the task goes while nothing tells where the robot is, and nothing is decided.

        Parameters
        ----------
        silence : float
            Time for which that is so [s].

        Returns
        -------
        TaskResult or None
            The end of the task; None while it waits, or if there is none.
        """
        if self._plan is None or (not self._is_canceled and silence <= _PATIENCE):
            return None
        result = TaskResult(TaskOutcome.CANCELED)
        if not self._is_canceled:
            why = f"the robot's pose has not been known for {_PATIENCE:g} s"
            result = _aborted(FollowCode.PATIENCE_EXCEEDED, why)
            self.cancel()
        self._plan = None
        return result

    def _checked(self, time: float, plan: Plan) -> TaskResult | None:
        supervisor = self._supervisor
        activity, reason = supervisor.activity, supervisor.reason
        is_moving = activity.is_moving
        if is_moving or self._moved_at is None or time < self._moved_at:
            self._moved_at = time
        if self._is_canceled:
            return None if is_moving else TaskResult(TaskOutcome.CANCELED)
        if activity.is_disabled:
            return _aborted(FollowCode.NO_CONTROL, reason)
        wanted = supervisor.wanted_plan
        if wanted is plan and activity in _ENDS:
            return _aborted(_ENDS[activity], reason)
        if wanted is plan and time - self._moved_at > _PATIENCE:
            why = f'the robot did not move for {_PATIENCE:g} s: {reason}'
            return _aborted(FollowCode.PATIENCE_EXCEEDED, why)
        if wanted is plan:
            return None
        if wanted is not None:
            return _aborted(FollowCode.NONE, 'preempted: another plan has taken its place')
        if activity is Activity.ARRIVED:
            return TaskResult(TaskOutcome.SUCCEEDED)
        return _aborted(FollowCode.UNKNOWN, f'the path is not followed any more: {reason}')


def _aborted(code: FollowCode, message: str) -> TaskResult:
    return TaskResult(TaskOutcome.ABORTED, code, message)
