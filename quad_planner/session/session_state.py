"""
What a planning session knows: for itself, and for whoever asks what it is doing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from quad_common.errors import QuadError
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.session.planning_map import PlanningMap
from quad_planner.session.pose_age import PoseAge
from quad_planner.session.session_ports import Requests


@dataclass(frozen=True)
class GoalWish:
    """A goal to plan to."""

    frame: str
    """Frame of the goal."""
    goal: Pose2D
    """Goal in that frame."""
    is_given: bool
    """Whether it was just given; else it is an older one that is planned to again."""
    is_detour: bool = False
    """Whether it is a place to give way at, and the goal in force stays."""


@dataclass(frozen=True)
class SessionOptions:
    """Conditions under which a session plans, and its map."""

    replan_distance: float = 0.3
    """Distance from its path at which a robot is planned for again [m]."""
    odom_timeout: float = 1.0
    """Age of a pose from which no plan is made any more [s]."""


class SessionState:
    """
    Map, pose, goal and plan of a session.

    Parameters
    ----------
    planning_map : PlanningMap
        The map, and the planning method that works on it.
    requests : Requests
        The part that works on searches.
    options : SessionOptions
        Conditions under which to plan.
    """

    def __init__(
        self, planning_map: PlanningMap, requests: Requests, options: SessionOptions
    ) -> None:
        self.map = planning_map
        """Map that is planned on."""
        self.options = options
        """Conditions under which it plans."""
        self._requests = requests
        self._pose: Pose2D | None = None
        self._age = PoseAge()
        self._waiting: GoalWish | None = None
        self._pending: GoalWish | None = None
        self._goal: Pose2D | None = None
        self._void_at: Pose2D | None = None
        self.when_moved: Callable[[Pose2D | None], object] = lambda before: None
        """Is told the pose of the frame of the map before in that of a new one, None if it is not
        known: what was known in that frame is elsewhere now."""
        self.hold_reason = ''
        """Reason for which it waits, or leaves its path, for other robots; empty if it does not."""
        self.plan: Plan | None = None
        """Plan that was published last, unless it was taken back."""
        self.is_detour = False
        """Whether that plan leads to a place to give way at."""
        self.planned_from: Pose2D | None = None
        """Pose of the robot from which it was planned."""
        self.problem: QuadError | None = None
        """Reason why the last goal was refused, or has no plan."""

    @property
    def is_busy(self) -> bool:
        """Whether a search, or what makes searches ready, is under way."""
        return self._requests.is_busy

    @property
    def pending_goal(self) -> Pose2D | None:
        """Goal that is being searched for."""
        return None if self._pending is None else self._pending.goal

    @property
    def goal(self) -> Pose2D | None:
        """Goal in force, in the map."""
        return self._goal

    @property
    def pose(self) -> Pose2D | None:
        """Pose of the robot in the map that was received last."""
        return self._pose

    @property
    def has_pose(self) -> bool:
        """Whether the robot's pose was received."""
        return self._pose is not None

    @property
    def silence(self) -> float:
        """Time since the last pose [s]; 0 as long as it is recent enough to plan from."""
        seconds = self._age.seconds
        return seconds if self.has_pose and seconds > self.options.odom_timeout else 0.0

    @property
    def has_ended(self) -> bool:
        """Whether the plan that was published last leads to no goal any more."""
        return self.plan is not None and self._goal is None

    @property
    def is_waiting(self) -> bool:
        """Whether a goal waits for a map, or for a pose."""
        return self._waiting is not None

    def _give_up_search(self) -> None:
        """Search nothing any more."""
        if self._pending is not None:
            self._pending = None
            self._requests.submit(lambda: None, lambda result: result())
