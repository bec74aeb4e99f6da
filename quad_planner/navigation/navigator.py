"""
Takes a robot to a goal, or through several, and answers for it: the part of Nav2's navigator.

The session plans and publishes; gait_node follows and says what the robot does. The navigator puts
both together, and decides when to try again and when to give up. It knows no topics and no clock.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_common.task_result import FollowCode, TaskOutcome, TaskResult
from quad_planner.navigation.navigator_options import NavigatorOptions
from quad_planner.navigation.remaining_plan import remaining_plan
from quad_planner.navigation.robot_report import RobotReport
from quad_planner.session.given_goal import GivenGoal, GoalEnd
from quad_planner.session.planning_session import PlanningSession

_SETTLED = 1.5
"""Time after a plan in which what the robot says may still be about the one before [s]."""


@dataclass(frozen=True)
class TaskProgress:
    """How far a task has come."""

    distance: float
    """Distance left: along the plan, and straight from goal to goal after it [m]."""
    time_left: float
    """Time that the plan in force still takes [s]; 0 if the gait's pace is not known."""
    recoveries: int
    """Number of times that something was done about trouble."""
    poses_left: int
    """Number of goals that are not reached yet."""


_SILENT = 3.0
"""Time after which a robot that said nothing is not taken at its last word [s]: it reports every
second."""

_DISCOVERY = 30.0
"""Time in which a robot that has never said anything is waited for [s]: on a busy machine it takes
nodes that start together longer than patience to find one another."""


class Navigator:
    """
    One task at a time; a newer one takes the place of one that runs.

    Parameters
    ----------
    session : PlanningSession
        The session that plans.
    options : NavigatorOptions
        Conditions under which a task goes on.
    """

    def __init__(self, session: PlanningSession, options: NavigatorOptions) -> None:
        self.options = options
        """Conditions under which a task goes on."""
        self._session = session
        self._goals: list[tuple[str, Pose2D]] = []
        self._given: GivenGoal | None = None
        self._is_canceled = False
        self._recoveries = 0
        self._report: RobotReport | None = None
        self._is_report_new = False
        self._last: tuple[float, float] | None = None
        self._idle = self._since_plan = self._unheard = 0.0
        self._plan: object = None

    @property
    def is_active(self) -> bool:
        """Whether there is a task."""
        return self._given is not None

    def begin(self, goals: Sequence[tuple[str, Pose2D]]) -> None:
        """
        Begin a task.

        Parameters
        ----------
        goals : sequence of tuple of str and Pose2D
            Each with its frame, in the order in which they are to be reached; one at least.
        """
        self._goals = list(goals)
        self._is_canceled = False
        self._recoveries = 0
        self._go_to_next()

    def cancel(self) -> None:
        """Give the task up; it ends when the robot stands."""
        self._is_canceled = True
        self._is_report_new = False
        self._idle = 0.0
        self._session.withdraw_goal()

    def take_report(self, report: RobotReport) -> None:
        """Take what the robot says of itself; with its first word patience begins."""
        if self._report is None:
            self._idle = 0.0
        self._report = report
        self._is_report_new = True
        self._unheard = 0.0

    def update(self, wall: float, clock: float) -> TaskResult | None:
        """
        Let time go on, and look how the task goes.

        Parameters
        ----------
        wall : float
            Time by the wall clock [s].
        clock : float
            Time of the node: while it stands still, nothing is waited for [s].

        Returns
        -------
        TaskResult or None
            The end of the task; None while it goes on, or if there is none.
        """
        self._count(wall, clock)
        if self._given is None:
            return None
        result = self._canceled() if self._is_canceled else self._checked(self._given)
        if result is not None:
            self._given = None
            if result.outcome is TaskOutcome.ABORTED and result.code != FollowCode.NONE:
                # Whoever gave it up for lost must not find that it walks there after all.
                self._session.withdraw_goal()
        return result

    def progress(self, pose: Pose2D | None, pace: WalkingTimeModel | None) -> TaskProgress:
        """
        Say how far the task has come.

        Parameters
        ----------
        pose : Pose2D or None
            The robot in the map; None if that is not known.
        pace : WalkingTimeModel or None
            Times of the gait; None if they are not known.

        Returns
        -------
        TaskProgress
            The distance is 0 as long as there is no plan.
        """
        distance = time_left = 0.0
        plan = self._session.plan
        if plan is not None and pose is not None:
            left = remaining_plan(plan, pose)
            distance = left.length
            time_left = pace.walking_time(pose, left) if pace is not None else 0.0
            stops = [plan.poses[-1], *(goal for _, goal in self._goals)]
            distance += sum(a.distance_to(b) for a, b in pairwise(stops))
        return TaskProgress(
            distance, time_left, self._recoveries, len(self._goals) + self.is_active
        )

    def _go_to_next(self) -> None:
        frame, goal = self._goals.pop(0)
        self._idle = 0.0
        self._given = self._session.give_goal(frame, goal)

    def _count(self, wall: float, clock: float) -> None:
        """Count for how long the robot has done nothing, and how old the plan is."""
        passed = 0.0
        if self._last is not None and clock != self._last[1]:
            passed = max(0.0, wall - self._last[0])
        self._last = wall, clock
        plan = self._session.plan
        if plan is not self._plan:
            self._plan, self._since_plan, self._idle = plan, 0.0, 0.0
        self._since_plan += passed
        self._unheard += passed
        is_moving = self._report is not None and self._report.is_moving
        is_known = self._unheard <= _SILENT and not self._session.silence
        # Waiting for another robot is on its way too.
        is_on_its_way = is_known and bool(
            self._session.hold_reason or (plan is not None and is_moving)
        )
        self._idle = 0.0 if is_on_its_way and not self._is_canceled else self._idle + passed

    def _canceled(self) -> TaskResult | None:
        """Return the end of a task that was given up, once the robot stands."""
        stands = self._is_report_new and self._report is not None and not self._report.is_moving
        if stands or self._idle > self.options.patience:
            return TaskResult(TaskOutcome.CANCELED)
        return None

    def _checked(self, given: GivenGoal) -> TaskResult | None:
        """Return the end of a task that runs, if it has come."""
        if given.end is GoalEnd.ARRIVED or (given.end is None and self._passes_a_goal()):
            if not self._goals:
                return TaskResult(TaskOutcome.SUCCEEDED)
            self._go_to_next()
            return None
        if given.end is GoalEnd.REFUSED:
            code = FollowCode.UNKNOWN if given.error is None else given.error.code
            return TaskResult(TaskOutcome.ABORTED, code, given.reason)
        if given.end in (GoalEnd.REPLACED, GoalEnd.WITHDRAWN):
            return TaskResult(TaskOutcome.ABORTED, FollowCode.NONE, f'preempted: {given.reason}')
        if given.end is not None:
            return TaskResult(
                TaskOutcome.ABORTED, FollowCode.UNKNOWN, f'{given.reason}{self._robots_words()}'
            )
        return self._troubled()

    def _passes_a_goal(self) -> bool:
        """Return whether the robot is near enough to a goal that is not the last."""
        pose, plan = self._session.pose, self._session.plan
        is_planned_to = self._session.pending_goal is None and not self._session.is_waiting
        if not self._goals or pose is None or plan is None or not is_planned_to:
            return False
        return pose.distance_to(plan.poses[-1]) <= self.options.passing_distance

    def _troubled(self) -> TaskResult | None:
        """Do something about trouble; return the end of the task where there is nothing to do."""
        session, report = self._session, self._report
        if session.plan is not None and report is not None and self._since_plan > _SETTLED:
            if report.is_disabled:
                return TaskResult(TaskOutcome.ABORTED, FollowCode.NO_CONTROL, report.reason)
            if report.is_stuck and session.pending_goal is None:
                if self._recoveries >= self.options.retries:
                    return TaskResult(TaskOutcome.ABORTED, FollowCode.NO_PROGRESS, report.reason)
                self._recoveries += 1
                self._since_plan = 0.0
                session.plan_again()
                return None
        if self._idle <= self._patience():
            return None
        code, why = self._lack()
        return TaskResult(
            TaskOutcome.ABORTED, code, f'nothing happened for {self._idle:.0f} s: {why}'
        )

    def _patience(self) -> float:
        """Return for how long nothing may happen [s]."""
        patience, session = self.options.patience, self._session
        is_new = self._report is None and session.plan is not None and not session.silence
        return max(patience, _DISCOVERY) if is_new else patience

    def _lack(self) -> tuple[int, str]:
        """Say what is missing, with its code."""
        session = self._session
        if session.problem is not None:
            return getattr(session.problem, 'code', FollowCode.UNKNOWN), str(session.problem)
        if not session.map.is_ready:
            return FollowCode.UNKNOWN, 'there is no map'
        if not session.has_pose or session.silence:
            return FollowCode.NO_POSE, 'there is no odometry'
        if self._unheard > _SILENT:
            return FollowCode.PATIENCE_EXCEEDED, 'no gait_node says what the robot does'
        return FollowCode.PATIENCE_EXCEEDED, f'the plan is not followed{self._robots_words()}'

    def _robots_words(self) -> str:
        return '' if self._report is None else f'; the robot says: {self._report.reason}'
