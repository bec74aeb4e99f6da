"""
A planning session beside a controller, without topics: what planner_node and gait_node exchange.
"""

from __future__ import annotations

from typing import Any

from quad_common.frames.map_frame import MapFrame
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.supervisor import Supervisor
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import session_from_parameters
from quad_planner.session.immediate_request import ImmediateRequest


class PlannerInLoop:
    """
    Gives the session's plans to a controller, and tells the session what is followed.

    Parameters
    ----------
    robot : Robot
        The robot.
    controller : Supervisor
        What follows the plans.
    parameters : PlannerParameters
        As planner_node takes them.
    frame : MapFrame, optional
        What places odometry on the map.
    """

    def __init__(
        self,
        robot: Robot,
        controller: Supervisor,
        parameters: PlannerParameters,
        frame: MapFrame | None = None,
    ) -> None:
        self._controller = controller
        self._followed: tuple[Plan, int] | None = None
        self._impassable: Pose2D | None = None
        self._stamp = 0
        self.frame = frame or MapFrame('map')
        """What places odometry on the map."""
        self.plans = 0
        """Number of plans, those that were made again included."""
        self.session = session_from_parameters(
            parameters, robot, self.frame, ImmediateRequest(), self
        )
        """What decides when to plan."""

    @property
    def problem(self) -> str:
        """Reason why the last goal has no plan; empty if it has one."""
        problem = self.session.problem
        return '' if problem is None else str(problem)

    def take_pose(self, time: float, pose: Pose2D) -> None:
        """Take the robot's pose in the map at a time [s]."""
        self.session.take_pose(time, pose)
        impassable = self._controller.impassable
        if impassable is not None and impassable is not self._impassable:
            self.session.take_impassable(self.frame.name, impassable)
        self._impassable = impassable
        followed = self._followed
        if followed is not None and self._controller.wanted_plan is not followed[0]:
            self._followed = None
            self.session.take_followed(followed[1], self.frame.name, None)

    def publish_plan(self, plan: Plan | None) -> int:
        """Hand a plan to the controller; return its stamp."""
        self._stamp += 1
        self.plans += plan is not None
        self._controller.set_plan(plan)
        if plan is not None and self._controller.wanted_plan is plan:
            self._followed = plan, self._stamp
        return self._stamp

    def show_map(self, prepared: Any) -> None:
        """Show nothing: nobody looks."""

    def say(self, sentence: str) -> None:
        """Log nothing: nobody reads it."""

    def warn(self, sentence: str) -> None:
        """Log nothing: nobody reads it."""

    def update_status(self) -> None:
        """Report nothing: nobody subscribes."""
