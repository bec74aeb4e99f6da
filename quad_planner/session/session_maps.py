"""
Maps of a planning session, as they come in parts.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace

from quad_common.errors import PlannerError, WrongFrame
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.grid.grid_update import GridUpdate
from quad_planner.session.session_state import SessionState


class SessionMaps(SessionState, ABC):
    """Takes maps, and plans again on what has changed; parameters as of SessionState."""

    @abstractmethod
    def plan_on_new_map(self) -> None:
        """Show the map, and plan on it to the goal in force."""

    @abstractmethod
    def give_up_goal(self, error: PlannerError) -> None:
        """Give up the goal in force for a reason, which is said: the robot stands."""

    @abstractmethod
    def _publish(self, plan: Plan | None, is_to_goal: bool = True) -> None:
        """Have a plan followed, or none."""

    def take_grid(self, grid: OccupancyGrid, frame: str) -> None:
        """
        Plan on this map from now on.

        In another frame than that of the map before the goal in force stays where it is, and is
        given up if nothing relates the two frames.

        Raises
        ------
        QuadError
            If it cannot be planned on, or a height map that waited for it does not go with it.
        """
        name, before = self.map.frame.name, self.map.frame.pose_in(frame)
        if self.map.take_grid(grid, frame):
            if frame != name:
                self._follow_map(name, before)
            self.plan_on_new_map()
            if frame != name and before is None and (self._goal or self._pending):
                self.give_up_goal(WrongFrame('goal', name, frame))
        if self.map.take_waiting_heights():
            self.plan_on_new_map()

    def take_update(self, update: GridUpdate, frame: str) -> None:
        """Plan on the map with some cells changed; see :meth:`PlanningMap.take_update`."""
        if self.map.take_update(update, frame):
            self.plan_on_new_map()

    def take_mask(self, mask: OccupancyGrid, frame: str) -> None:
        """Keep out of the zones of a mask; see :meth:`PlanningMap.take_mask`."""
        if self.map.take_mask(mask, frame):
            self.plan_on_new_map()

    def take_heights(self, heights: HeightMap, frame: str) -> None:
        """Plan over this ground from now on; see :meth:`PlanningMap.take_heights`."""
        if self.map.take_heights(heights, frame):
            self.plan_on_new_map()

    def _follow_map(self, name: str, before: Pose2D | None) -> None:
        """
        Bring what is known in the frame of the map before into that of the new one.

        Parameters
        ----------
        name : str
            Name of the frame of the map before.
        before : Pose2D or None
            Its pose in the frame of the new one; None if that is not known.
        """
        self.when_moved(before)
        if self.has_ended:
            # It is shown where it was, and a late subscriber must not walk to it again.
            self._publish(None)
        if before is None:
            # Where the robot is, the next odometry says; until then nothing is planned.
            self._pose = self.planned_from = None
            return
        kept = self._pose, self._goal, self._void_at, self.planned_from
        self._pose, self._goal, self._void_at, self.planned_from = (
            pose and before @ pose for pose in kept
        )
        if self.plan is not None:
            self.plan = Plan(tuple(before @ pose for pose in self.plan.poses), self.plan.remark)
        self._waiting, self._pending = (
            replace(wish, frame=self.map.frame.name, goal=before @ wish.goal)
            if wish and wish.frame == name
            else wish
            for wish in (self._waiting, self._pending)
        )
        if self._waiting is not None:
            # Else it is searched anew: a plan on the map before would be taken for one on this.
            self._give_up_search()
