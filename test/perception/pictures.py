"""Pictures of rooms, painted by OpenCV: no simulator is needed to test what sees."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.vision.camera import CameraModel

FLOOR = (170, 170, 165)
OBSTACLE = (210, 40, 35)
LIGHT = np.array([0.35, 0.2, 0.91])


@dataclass(frozen=True)
class Obstacle:
    """A box or, without a width, a cylinder; standing on the floor."""

    x: float
    y: float
    height: float
    length: float
    """Of a cylinder the diameter."""
    width: float | None = None
    yaw: float = 0.0

    def outline(self) -> np.ndarray:
        """Return the footprint's corners, counter-clockwise."""
        if self.width is None:
            turn = np.linspace(0.0, 2.0 * math.pi, 48, endpoint=False)
            corners = np.column_stack((np.cos(turn), np.sin(turn))) * self.length / 2.0
        else:
            signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
            corners = signs * (self.length / 2.0, self.width / 2.0)
        return Pose2D(self.x, self.y, self.yaw).transform(corners)

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return which points of the floor it stands on."""
        local = Pose2D(self.x, self.y, self.yaw).inverse().transform(points)
        if self.width is None:
            return np.hypot(local[..., 0], local[..., 1]) <= self.length / 2.0
        return (np.abs(local[..., 0]) <= self.length / 2.0) & (
            np.abs(local[..., 1]) <= self.width / 2.0
        )


def ceiling_camera(size=640, height=6.0, distortion=(0.0,) * 5, yaw=0.0, place=(0.0, 0.0)):
    """Return a camera that sees a floor of 8 m x 8 m, and a little more."""
    field_of_view = 2.0 * math.atan(4.1 / height)
    return CameraModel.looking_down((*place, height), yaw, field_of_view, (size, size), distortion)


def paint(camera, obstacles, plates=(), floor=FLOOR, color=OBSTACLE, below=()):
    """
    Paint a room.

    Parameters
    ----------
    camera : CameraModel
        What sees it.
    obstacles : sequence of Obstacle
        They are painted from far to near.
    plates : sequence of tuple
        Outline, shape (n, 2) [m], height [m] and color of flat things, painted last.
    below : sequence of tuple
        Likewise, painted first.
    """
    picture = np.empty((camera.height, camera.width, 3), np.uint8)
    picture[:] = floor
    for outline, height, shade in below:
        _fill(picture, camera, np.column_stack((outline, np.full(len(outline), height))), shade)
    nadir = camera.position[:2]
    far_first = sorted(obstacles, key=lambda o: -np.linalg.norm(o.outline() - nadir, axis=1).min())
    light = LIGHT / np.linalg.norm(LIGHT)
    for obstacle in far_first:
        corners = obstacle.outline()
        for a, b in zip(corners, np.roll(corners, -1, axis=0)):
            normal = np.array([b[1] - a[1], a[0] - b[0]])
            normal /= np.linalg.norm(normal)
            if normal @ (nadir - a) <= 0.0:
                continue
            shade = 0.35 + 0.65 * max(0.0, float(normal @ light[:2]))
            along = np.linspace(a, b, 8)
            wall = np.vstack(
                [
                    np.column_stack((along, np.zeros(8))),
                    np.column_stack((along[::-1], np.full(8, obstacle.height))),
                ]
            )
            _fill(picture, camera, wall, np.array(color) * shade)
        shade = 0.35 + 0.65 * light[2]
        top = np.vstack([np.linspace(a, b, 8) for a, b in zip(corners, np.roll(corners, -1, 0))])
        _fill(
            picture,
            camera,
            np.column_stack((top, np.full(len(top), obstacle.height))),
            np.array(color) * shade,
        )
    for outline, height, shade in plates:
        _fill(picture, camera, np.column_stack((outline, np.full(len(outline), height))), shade)
    return picture


def disc(x, y, radius):
    """Return the outline of a disc."""
    turn = np.linspace(0.0, 2.0 * math.pi, 64, endpoint=False)
    return np.column_stack((x + radius * np.cos(turn), y + radius * np.sin(turn)))


def disturbed(picture, rng, brightness=1.0, noise=8.0):
    """Return the picture brighter or darker, and noisy."""
    values = picture * brightness + rng.normal(0.0, noise, picture.shape)
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def truth(grid: OccupancyGrid, obstacles):
    """Return the cells of a grid that obstacles stand on by at least half."""
    parts = 5
    rows, columns = np.indices((grid.height * parts, grid.width * parts))
    points = grid.map_to_world(np.stack((columns + 0.5, rows + 0.5), axis=-1) / parts)
    covered = np.zeros(points.shape[:2], bool)
    for obstacle in obstacles:
        covered |= obstacle.holds(points)
    fractions = covered.reshape(grid.height, parts, grid.width, parts).mean(axis=(1, 3))
    return fractions >= 0.5


def random_obstacles(rng, count, side=8.0, gap=0.3):
    """Draw obstacles that do not touch one another."""
    drawn: list[Obstacle] = []
    while len(drawn) < count:
        x, y = rng.uniform(-side / 2.0 + 0.5, side / 2.0 - 0.5, 2)
        height = rng.uniform(0.2, 1.0)
        length, width = rng.uniform(0.3, 0.9, 2)
        new = (
            Obstacle(x, y, height, length, width, rng.uniform(0.0, math.pi))
            if rng.random() < 0.5
            else Obstacle(x, y, height, length)
        )
        if all(math.hypot(x - o.x, y - o.y) > gap + (_radius(new) + _radius(o)) for o in drawn):
            drawn.append(new)
    return drawn


def _radius(obstacle: Obstacle) -> float:
    return math.hypot(obstacle.length, obstacle.width or 0.0) / 2.0


def _fill(picture, camera, points, color):
    pixels = camera.project(points) - 0.5
    cv2.fillPoly(
        picture,
        [np.rint(pixels * 256.0).astype(np.int32)],
        tuple(float(min(255.0, round(float(part)))) for part in color),
        lineType=cv2.LINE_8,
        shift=8,
    )


def robot_plates(pose, marker, base_height=0.24):
    """Return a robot with its marker, for :func:`paint`."""
    corners = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    plates = [
        (pose.transform(corners * (0.35, 0.3)), base_height - 0.04, (70, 72, 76)),
        (
            pose.transform(corners * (marker.length / 2.0, marker.width / 2.0)),
            base_height + marker.height,
            marker.plate_color,
        ),
    ]
    for side, color in ((1.0, marker.front_color), (-1.0, marker.rear_color)):
        x, y = pose.transform(np.array([side * marker.disc_distance / 2.0, 0.0]))
        plates.append((disc(x, y, marker.disc_radius), base_height + marker.height, color))
    return plates


def goal_plates(pose, marker):
    """Return the goal's marker, for :func:`paint`."""
    x, y = pose.transform(np.array([marker.heading_distance, 0.0]))
    return [
        (disc(pose.x, pose.y, marker.radius), marker.height, marker.color),
        (disc(x, y, marker.heading_radius), marker.height, marker.heading_color),
    ]
