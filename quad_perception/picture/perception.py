"""
All that a picture says about the room: the map, the robot and the goal.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from quad_common.errors import ParameterError, PerceptionError, without_frames
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.vision.camera import CameraModel
from quad_common.vision.markers import OBSTACLE_COLOR, Color, GoalMarker, RobotMarker
from quad_perception.picture.color_segmentation import (
    ColorRange,
    Mask,
    Picture,
    Segmentation,
    check_picture,
    segment,
)
from quad_perception.picture.floor_map import floor_map
from quad_perception.picture.floor_view import FloorView
from quad_perception.picture.footprints import Footprint, FootprintFinder
from quad_perception.picture.marker_poses import MarkerPose, MarkerShape, find_marker
from quad_perception.picture.picture_check import check_exposure

OBSTACLE, FLOOR = 'obstacle', 'floor'
"""Names of ranges, besides those of the markers."""

_AROUND_FEET = 0.15
"""That the robot has to itself, beyond the circle of its feet [m]."""

_LEAST_FLOOR = 0.6
"""Least brightness of the floor, as a fraction of the median of what has its color."""


def default_ranges(
    obstacle: Color = OBSTACLE_COLOR,
    robot: RobotMarker | None = None,
    goal: GoalMarker | None = None,
) -> tuple[ColorRange, ...]:
    """
    Make the ranges for a gray or white floor and things of known colors.

    Parameters
    ----------
    obstacle : tuple of int
        Red, green and blue of obstacles, 0 to 255.
    robot, goal : RobotMarker and GoalMarker, optional
        The markers; those with their usual colors if not given.

    Returns
    -------
    tuple of ColorRange
        ``obstacle``, ``floor``, ``robot_front``, ``robot_rear``, ``goal`` and ``goal_heading``.
    """
    robot = robot or RobotMarker()
    goal = goal or GoalMarker()
    return (
        ColorRange.around(OBSTACLE, obstacle),
        ColorRange(FLOOR, (0.0, 0.0, 0.15), (360.0, 0.25, 1.0)),
        ColorRange.around('robot_front', robot.front_color),
        ColorRange.around('robot_rear', robot.rear_color),
        ColorRange.around('goal', goal.color),
        ColorRange.around('goal_heading', goal.heading_color),
    )


@dataclass(frozen=True, eq=False)
class Perception:
    """What a picture shows."""

    map: OccupancyGrid
    """0 where the floor is seen, 100 where obstacles stand, -1 elsewhere."""
    footprints: Sequence[Footprint]
    """The obstacles one by one, on the plan of the floor."""
    robot: MarkerPose | None
    """The robot's base_link; None if it is not found."""
    robot_problem: PerceptionError | None
    """Reason why it is not found."""
    goal: MarkerPose | None
    """None if it is not found."""
    goal_problem: PerceptionError | None
    """Reason why it is not found."""
    masks: Mapping[str, Mask]
    """Masks by the name of the range, 255 where the picture has its color."""


class Perceiver:
    """
    Sees the room: everything that one camera's pictures need is computed once.

    Parameters
    ----------
    camera : CameraModel
        What takes the pictures.
    ranges : sequence of ColorRange
        Color ranges with the names of :func:`default_ranges`.
    robot : MarkerShape
        The marker on the robot's back.
    goal : MarkerShape
        The marker at the goal.
    resolution : float
        Side of the map's cells [m].
    bounds : tuple of float, optional
        x_min, y_min, x_max, y_max of the map [m]; what the camera sees if not given.
    robot_radius : float
        Radius of the circle around base_link that the robot, with its legs, never leaves [m].
    largest_height : float
        Obstacles are at most this high [m].
    assumed_height : float
        Height of obstacles whose sides are not seen [m].

    Raises
    ------
    ParameterError
        If an argument is not valid, or the range of a color is missing.
    """

    def __init__(
        self,
        camera: CameraModel,
        ranges: Sequence[ColorRange] | None = None,
        robot: MarkerShape | None = None,
        goal: MarkerShape | None = None,
        *,
        resolution: float = 0.05,
        bounds: tuple[float, float, float, float] | None = None,
        robot_radius: float = 0.6,
        largest_height: float = 1.2,
        assumed_height: float = 0.6,
    ) -> None:
        self.camera = camera
        self.ranges = tuple(default_ranges() if ranges is None else ranges)
        self.robot = robot or MarkerShape.of_robot(RobotMarker(), base_height=0.24)
        self.goal = goal or MarkerShape.of_goal(GoalMarker())
        names = {color.name for color in self.ranges}
        discs = [disc.color for m in (self.robot, self.goal) for disc in (m.rear, m.front)]
        missing = {OBSTACLE, FLOOR, *discs} - names
        if missing:
            raise ParameterError(
                'ranges', sorted(names), f'with those for {", ".join(sorted(missing))} too'
            )
        if not 0.0 <= robot_radius < math.inf:
            raise ParameterError('robot_radius', robot_radius, 'a finite number of at least 0')
        if not self.robot.height < camera.position[2]:
            raise ParameterError('robot', self.robot.height, 'below the camera in height')
        self.view = FloorView(camera, resolution, bounds, largest_height)
        self._finder = FootprintFinder(self.view, assumed_height)
        self.robot_radius = robot_radius

    @classmethod
    def of_robot(
        cls,
        camera: CameraModel,
        robot: Robot,
        ranges: Sequence[ColorRange] | None = None,
        robot_marker: RobotMarker | None = None,
        goal_marker: GoalMarker | None = None,
        *,
        resolution: float = 0.05,
        bounds: tuple[float, float, float, float] | None = None,
    ) -> Perceiver:
        """
        Make what looks for a robot that carries the marker that suits its body.

        Parameters
        ----------
        camera, resolution, bounds
            As for the class.
        robot : Robot
            The robot.
        ranges : sequence of ColorRange, optional
            Those of the markers with obstacles of the usual color if not given.
        robot_marker, goal_marker : optional
            The markers; with their usual colors if not given.

        Returns
        -------
        Perceiver
            For this robot, standing at its height.
        """
        robot_marker = robot_marker or RobotMarker.on(robot)
        goal_marker = goal_marker or GoalMarker()
        return cls(
            camera,
            default_ranges(robot=robot_marker, goal=goal_marker) if ranges is None else ranges,
            MarkerShape.of_robot(robot_marker, robot.standing_height),
            MarkerShape.of_goal(goal_marker),
            resolution=resolution,
            bounds=bounds,
            robot_radius=robot.footprint_radius + _AROUND_FEET,
        )

    def perceive(self, rgb: Picture, previous: OccupancyGrid | None = None) -> Perception:
        """
        See what a picture shows.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (height, width, 3)
            The picture: red, green, blue.
        previous : OccupancyGrid, optional
            The map of the picture before: it holds what the robot hides now.

        Returns
        -------
        Perception
            The map, the robot and the goal.

        Raises
        ------
        ParameterError
            If this is no picture of the camera's size.
        PictureUnusable
            If it is black or overexposed.
        """
        check_picture(rgb, (self.camera.width, self.camera.height))
        check_exposure(rgb)
        seen = segment(rgb, self.ranges)
        robot, robot_problem = self._attempt(seen, self.robot)
        goal, goal_problem = self._attempt(seen, self.goal)
        layers = self.view.straighten(seen.masks[OBSTACLE], self._floor(seen), seen.value)
        obstacles, floor = (
            np.asarray(cv2.threshold(layer, 127, 255, cv2.THRESH_BINARY)[1], np.uint8)
            for layer in layers[:2]
        )
        footprints = self._finder.find(obstacles, layers[2])
        covered = None if robot is None else self._covered(robot.pose)
        floor = cv2.subtract(floor, obstacles)
        grid = floor_map(self.view, floor, footprints, covered, previous)
        return Perception(grid, footprints, robot, robot_problem, goal, goal_problem, seen.masks)

    def _attempt(
        self, seen: Segmentation, shape: MarkerShape
    ) -> tuple[MarkerPose | None, PerceptionError | None]:
        try:
            return find_marker(seen, self.camera, shape), None
        except PerceptionError as problem:
            return None, without_frames(problem)

    def _floor(self, seen: Segmentation) -> Mask:
        """Return where the floor is seen; what lies flat on it counts as floor."""
        floor = seen.masks[FLOOR]
        # Things of the floor's color that are much darker stand on it: a gray robot.
        counts = cv2.calcHist([seen.value], [0], floor, [256], [0, 256]).ravel().cumsum()
        median = int(np.searchsorted(counts, counts[-1] / 2.0))
        _, bright = cv2.threshold(seen.value, _LEAST_FLOOR * median, 255, cv2.THRESH_BINARY)
        floor = cv2.bitwise_and(floor, bright)
        for disc in (self.goal.rear, self.goal.front):
            floor = cv2.bitwise_or(floor, seen.masks[disc.color])
        return np.asarray(floor, np.uint8)

    def _covered(self, pose: Pose2D) -> Mask:
        """Return what of the plan the robot may hide: its circle, from the floor to the marker."""
        nadir = self.view.nadir
        center = self.view.to_plan(np.array([[pose.x, pose.y]]))[0]
        turn = np.linspace(0.0, 2.0 * math.pi, 32, endpoint=False)
        circle = np.column_stack((np.cos(turn), np.sin(turn)))
        circle = center + circle * self.robot_radius / self.view.step
        u = 1.0 - self.robot.height / float(self.camera.position[2])
        both = np.vstack((circle, nadir + (circle - nadir) / u)).astype(np.float32)
        outline = np.rint(cv2.convexHull(both)).astype(np.int32)
        covered = np.zeros(self.view.seen.shape, np.uint8)
        cv2.fillConvexPoly(covered, outline, 255)
        return covered
