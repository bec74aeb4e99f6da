"""
Goals at random that have a plan.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from quad_common.errors import PlannerError, QuadError
from quad_common.maps.map_file import load_map
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.planner import Planner
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_for

_TRIES = 2000
"""Goals that are drawn before it is given up."""

_TRIES_AHEAD = 100
"""Goals that are drawn ahead of the robot before any direction will do."""


@dataclass(eq=False, repr=False)
class NoGoalFound(QuadError):
    """No goal that was drawn has a plan of the wanted length."""

    tries: int
    """Number of goals that were drawn."""
    lengths: tuple[float, float]
    """Least and largest length of the plan [m]."""
    start: Pose2D
    """Pose from which plans were made."""

    def sentence(self) -> str:
        """Say which lengths were wanted."""
        shortest, longest = self.lengths
        return (
            f'no goal of {self.tries} has a plan of {shortest:g} to {longest:g} m from '
            f'({self.start.x:.2f}, {self.start.y:.2f}) m'
        )


class GoalDrawer:
    """
    Draws goals on a map.

    Parameters
    ----------
    robot : Robot
        Whose clearance counts.
    map_file : Path
        The map.
    seed : int
        Of the drawing.
    method : str
        The planning method that must find a path.
    clearance : float
        Distance to obstacles beyond the one that the planner keeps [m].
    """

    def __init__(
        self,
        robot: Robot,
        map_file: Path,
        seed: int,
        method: str = 'mesh',
        clearance: float = 0.0,
    ) -> None:
        self._rng = np.random.default_rng(seed)
        self._grid = load_map(map_file)
        safety = PlannerParameters().safety_distance + clearance
        # A robot stands a little beside the goal that it was given.
        self._planner: Planner[InflatedMap] = planner_for(
            robot, method, safety, start_tolerance=safety
        )
        self._planner.set_map(self._grid)

    def draw(
        self,
        start: Pose2D,
        shortest: float = 0.5,
        longest: float = 2.0,
        largest_turn: float = math.pi,
    ) -> Pose2D:
        """
        Draw a goal.

        Parameters
        ----------
        start : Pose2D
            Where the robot is.
        shortest, longest : float
            Bounds of the plan's length [m].
        largest_turn : float
            Angle to the goal and of its heading from the start's heading, at most, unless there
            are obstacles ahead [rad].

        Returns
        -------
        Pose2D
            A goal that has a plan from there.

        Raises
        ------
        QuadError
            If none is found.
        """
        for attempt in range(_TRIES):
            # Not far as the crow flies either: most of the room need not be tried.
            distance = self._rng.uniform(0.5 * shortest, longest)
            direction, yaw = self._rng.uniform(-math.pi, math.pi, 2)
            if largest_turn < math.pi and attempt < _TRIES_AHEAD:
                direction, yaw = start.yaw + largest_turn / math.pi * np.array((direction, yaw))
            goal = Pose2D(
                round(start.x + distance * math.cos(direction), 2),
                round(start.y + distance * math.sin(direction), 2),
                float(yaw),
            )
            if shortest <= self._length(start, goal) <= longest:
                return goal
        raise NoGoalFound(_TRIES, (shortest, longest), start)

    def _length(self, start: Pose2D, goal: Pose2D) -> float:
        try:
            return self._planner.plan(start, goal).length
        except PlannerError:
            return -1.0
