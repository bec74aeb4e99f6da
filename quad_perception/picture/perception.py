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
from quad_perception.picture.color_segmentation import (
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
from quad_perception.picture.scene_model import FLOOR, OBSTACLE, SceneModel

_LEAST_FLOOR = 0.6
"""Least brightness of the floor, as a fraction of the median of what has its color."""


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
    scene : SceneModel, optional
        What is known of the things in the room; the usual ones if not given.
    resolution : float
        Side of the map's cells [m].
    bounds : tuple of float, optional
        x_min, y_min, x_max, y_max of the map [m]; what the camera sees if not given.

    Raises
    ------
    ParameterError
        If an argument is not valid.
    """

    def __init__(
        self,
        camera: CameraModel,
        scene: SceneModel | None = None,
        *,
        resolution: float = 0.05,
        bounds: tuple[float, float, float, float] | None = None,
    ) -> None:
        self.camera = camera
        self.scene = SceneModel() if scene is None else scene
        if not self.scene.robot.height < camera.position[2]:
            raise ParameterError('robot', self.scene.robot.height, 'below the camera in height')
        self.view = FloorView(camera, resolution, bounds, self.scene.largest_height)
        self._finder = FootprintFinder(self.view, self.scene.assumed_height)

    @classmethod
    def of_robot(
        cls,
        camera: CameraModel,
        robot: Robot,
        *,
        resolution: float = 0.05,
        bounds: tuple[float, float, float, float] | None = None,
    ) -> Perceiver:
        """
        Make what looks for a robot, in a room with markers and obstacles of the usual colors.

        Parameters
        ----------
        camera, resolution, bounds
            As for the class.
        robot : Robot
            The robot.

        Returns
        -------
        Perceiver
            For the scene of :meth:`SceneModel.of_robot`.
        """
        return cls(camera, SceneModel.of_robot(robot), resolution=resolution, bounds=bounds)

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
        seen = segment(rgb, self.scene.ranges)
        robot, robot_problem = self._attempt(seen, self.scene.robot)
        goal, goal_problem = self._attempt(seen, self.scene.goal)
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
        for disc in (self.scene.goal.rear, self.scene.goal.front):
            floor = cv2.bitwise_or(floor, seen.masks[disc.color])
        return np.asarray(floor, np.uint8)

    def _covered(self, pose: Pose2D) -> Mask:
        """Return what of the plan the robot may hide: its circle, from the floor to the marker."""
        nadir = self.view.nadir
        center = self.view.to_plan(np.array([[pose.x, pose.y]]))[0]
        turn = np.linspace(0.0, 2.0 * math.pi, 32, endpoint=False)
        circle = np.column_stack((np.cos(turn), np.sin(turn)))
        circle = center + circle * self.scene.robot_radius / self.view.step
        u = 1.0 - self.scene.robot.height / float(self.camera.position[2])
        both = np.vstack((circle, nadir + (circle - nadir) / u)).astype(np.float32)
        outline = np.rint(cv2.convexHull(both)).astype(np.int32)
        covered = np.zeros(self.view.seen.shape, np.uint8)
        cv2.fillConvexPoly(covered, outline, 255)
        return covered
