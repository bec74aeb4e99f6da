"""
What was seen, drawn into the picture: for people to look at.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from quad_common.vision.camera import CameraModel
from quad_perception.picture.color_segmentation import Picture
from quad_perception.picture.marker_poses import MarkerPose
from quad_perception.picture.perception import Perceiver, Perception

_OCCUPIED, _UNKNOWN = (255, 255, 255), (90, 90, 90)
_ROBOT, _GOAL = (0, 255, 255), (255, 255, 0)
_ARROW = 0.5
"""Length of the arrows that show headings [m]."""


def annotated(rgb: Picture, perceiver: Perceiver, seen: Perception) -> Picture:
    """
    Draw the map's outlines, the robot and the goal into the picture that showed them.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (height, width, 3)
        The picture.
    perceiver : Perceiver
        What saw.
    seen : Perception
        What it saw.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        White around what is occupied, gray around what is unknown, arrows for robot and goal.
    """
    picture = rgb.copy()
    camera, grid = perceiver.camera, seen.map
    for cells, color in ((grid.unknown(), _UNKNOWN), (grid.occupied(), _OCCUPIED)):
        outlines, _ = cv2.findContours(
            cells.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE
        )
        for outline in outlines:
            corners = grid.map_to_world(outline.reshape(-1, 2) + 0.5)
            _draw_line(picture, camera, corners, 0.0, color)
    if seen.robot is not None:
        _draw_arrow(picture, camera, seen.robot, perceiver.scene.robot.height, _ROBOT)
    if seen.goal is not None:
        _draw_arrow(picture, camera, seen.goal, perceiver.scene.goal.height, _GOAL)
    return picture


def _draw_line(
    picture: Picture,
    camera: CameraModel,
    corners: NDArray[np.float64],
    height: float,
    color: tuple[int, int, int],
) -> None:
    """Draw a closed line at a height, of points on the map."""
    pixels = camera.project(np.column_stack((corners, np.full(len(corners), height))))
    cv2.polylines(picture, [np.rint(pixels).astype(np.int32)], True, color, 1, cv2.LINE_AA)


def _draw_arrow(
    picture: Picture,
    camera: CameraModel,
    seen: MarkerPose,
    height: float,
    color: tuple[int, int, int],
) -> None:
    ends = seen.pose.transform(np.array([(0.0, 0.0, height), (_ARROW, 0.0, height)]))
    (x, y), (to_x, to_y) = np.rint(camera.project(ends)).astype(int).tolist()
    cv2.arrowedLine(picture, (x, y), (to_x, to_y), color, 2, cv2.LINE_AA, tipLength=0.3)
