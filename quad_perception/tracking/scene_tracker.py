"""
Watches a room, picture after picture: its map, its goal, and where the robot is.

What pictures say is made steady here: the map changes where several agree, the goal is
new where its marker has moved, and the robot's pose is carried from picture to picture
by the legs' odometry.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from quad_common.errors import PictureUnusable, QuadError, SeveralMarkers, without_frames
from quad_common.maps.occupancy_grid import FREE, OccupancyGrid
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_perception.picture.color_segmentation import Picture
from quad_perception.picture.perception import Perceiver, Perception
from quad_perception.tracking.pose_fusion import FusionOptions, PoseFusion
from quad_perception.tracking.steady_map import SteadyMap

_STILL = (0.03, 0.05)
"""Pictures may be equal until the robot has walked or turned so far, by its legs [m, rad]."""


@dataclass(frozen=True)
class TrackerOptions:
    """What counts as a change."""

    confirmations: int = 2
    """The map changes where so many pictures in a row show it."""
    goal_distance: float = 0.05
    """A goal marker that moved by less is where it was [m]."""
    goal_angle: float = 0.1
    """A goal marker that turned by less is as it was [rad]."""
    largest_age: float = 3.0
    """Time without a picture of the robot after which its pose is not known [s]."""


@dataclass(frozen=True)
class Sighting:
    """What a picture has changed."""

    perception: Perception
    """What it shows."""
    map: OccupancyGrid | None
    """The map, if it has changed."""
    goal: Pose2D | None
    """The goal, if it is new or has moved, in the map [m, m, rad]."""
    problem: QuadError | None
    """Reason why the robot's pose was not corrected; None if it was."""
    goal_problem: SeveralMarkers | None
    """Goals that are seen if there are several; the last one stays."""


class SceneTracker:
    """
    The room under one camera.

    Parameters
    ----------
    perceiver : Perceiver
        What sees.
    options : TrackerOptions, optional
        What counts as a change.
    fusion : FusionOptions, optional
        Weights of odometry and camera.
    """

    def __init__(
        self,
        perceiver: Perceiver,
        options: TrackerOptions | None = None,
        fusion: FusionOptions | None = None,
    ) -> None:
        self._perceiver = perceiver
        self._options = options or TrackerOptions()
        self._fusion = PoseFusion(fusion)
        self._map = SteadyMap(self._options.confirmations)
        self._goal: Pose2D | None = None
        self._time = -math.inf
        self._odometry: Pose2D | None = None
        self._last: Picture | None = None
        self._last_at: Pose2D | None = None

    @property
    def perceiver(self) -> Perceiver:
        """What sees."""
        return self._perceiver

    @property
    def map(self) -> OccupancyGrid | None:
        """The map; None before the first picture."""
        return self._map.grid

    @property
    def fusion(self) -> PoseFusion:
        """Pose of the robot, from pictures and odometry."""
        return self._fusion

    @property
    def is_lost(self) -> bool:
        """Whether the robot's pose is not known, or was last seen too long ago."""
        return self._fusion.pose is None or self._fusion.age(self._time) > self._options.largest_age

    @property
    def correction(self) -> Pose2D | None:
        """The odometry's frame in the map's, map -> odom; None while the robot is lost."""
        return None if self.is_lost else self._fusion.correction

    def add_odometry(self, time: float, pose: Pose2D) -> None:
        """Take an odometry: its time [s] and the robot's pose in the odometry's frame."""
        self._time = time
        self._odometry = pose
        self._fusion.add_odometry(time, pose)

    def add_picture(self, time: float, rgb: Picture) -> Sighting:
        """
        Take a picture.

        Parameters
        ----------
        time : float
            When it was taken [s].
        rgb : ndarray of uint8, shape (height, width, 3)
            Red, green, blue.

        Returns
        -------
        Sighting
            What has changed.

        Raises
        ------
        ParameterError
            If it is no picture of the camera's size.
        PictureUnusable
            If it is black, overexposed, or the same although the robot has walked; the map
            stays as it was.
        """
        seen = self._perceiver.perceive(rgb, self._map.grid)
        self._refuse_frozen(rgb)
        problem: QuadError | None = seen.robot_problem
        if seen.robot is not None:
            try:
                self._fusion.add_picture(time, seen.robot.pose, seen.robot.covariance)
            except QuadError as error:
                problem = without_frames(error)
        changed = self._map.add(self._with_standing_room(seen))
        several = seen.goal_problem if isinstance(seen.goal_problem, SeveralMarkers) else None
        return Sighting(
            seen, self._map.grid if changed else None, self._new_goal(seen), problem, several
        )

    def _with_standing_room(self, seen: Perception) -> OccupancyGrid:
        """Return the map with the floor under the robot: it stands there, and nothing else."""
        if seen.robot is None:
            return seen.map
        grid = seen.map
        rows, columns = np.nonzero(grid.unknown())
        centers = grid.map_to_world(np.column_stack((columns, rows)) + np.float64(0.5))
        away = np.hypot(centers[:, 0] - seen.robot.pose.x, centers[:, 1] - seen.robot.pose.y)
        under = away <= self._perceiver.scene.robot_radius
        cells = grid.cells.copy()
        cells[rows[under], columns[under]] = FREE
        return OccupancyGrid(cells, grid.resolution, grid.origin)

    def _new_goal(self, seen: Perception) -> Pose2D | None:
        if seen.goal is None:
            return None
        goal, before = seen.goal.pose, self._goal
        if before is not None:
            is_there = before.distance_to(goal) < self._options.goal_distance
            if is_there and abs(wrap_angle(goal.yaw - before.yaw)) < self._options.goal_angle:
                return None
        self._goal = goal
        return goal

    def _refuse_frozen(self, rgb: Picture) -> None:
        """Refuse a picture that shows nothing of a walk that the legs measure."""
        if self._last is None or not np.array_equal(rgb, self._last):
            self._last, self._last_at = rgb.copy(), self._odometry
            return
        if self._last_at is None or self._odometry is None:
            return
        walked = self._last_at.distance_to(self._odometry)
        turned = abs(wrap_angle(self._odometry.yaw - self._last_at.yaw))
        if walked > _STILL[0] or turned > _STILL[1]:
            raise PictureUnusable(
                f'is frozen: it has not changed while the robot walked {walked:.2f} m and '
                f'turned by {math.degrees(turned):.0f} degrees'
            )
