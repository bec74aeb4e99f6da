"""
What the ceiling camera sees, drawn by PyBullet on the processor.

It has a PyBullet world of its own, with shapes and without physics. So what is drawn cannot
disturb the simulation, and markers that nothing collides with are in the way of nothing.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.vision.markers import Color, RobotMarker
from quad_sim.engines.bullet_body import BulletBody
from quad_sim.world.appearance import AMBIENT, LIGHT_FROM, SQUARE_SHADE, Appearance
from quad_sim.world.terrain import Terrain
from quad_sim.world.world import Obstacle, World

Array = NDArray[np.float64]
Mesh = tuple[Array, Array, NDArray[np.int64]]
"""Vertices and normals, shape (n, 3), and three indices of vertices for each triangle."""

_FLOOR = 50.0
"""Half side of the floor [m]."""

_PATTERN = 12.0
"""Half side of the part of the floor that has a pattern, if it has one [m]."""

_THIN = 1e-4
"""Thickness of what is painted on the floor [m]."""

_PLATE = 0.004
"""Thickness of the robot's marker, and how far its discs stand out [m]."""

_SIDES = 48
"""Number of sides of the prism in place of a cylinder."""

# What is level has just its own color.
_DIFFUSE = (1.0 - AMBIENT) * float(np.linalg.norm(LIGHT_FROM)) / LIGHT_FROM[2]

_SHADES = 8
"""Number of shades of the floor's color, from the lowest ground to the highest."""

_DARKEST = 0.7
"""The highest ground, of the floor's color."""

_FACET = 0.05
"""Side of the squares that uneven ground is drawn with [m]."""

_HALF_PIXEL = 0.5
"""Distance by which the renderer draws everything too far right and up [pixels]."""


class BulletScene:
    """
    A robot, obstacles and markers to be looked at.

    Parameters
    ----------
    client : BulletClient
        An empty world, which becomes the scene's own.
    body : BulletBody
        The robot's body in it.
    robot : Robot
        The same robot's data.
    world : World
        Walls and obstacles.
    appearance : Appearance
        Colors and markers.
    """

    def __init__(
        self,
        client: Any,
        body: BulletBody,
        robot: Robot,
        world: World,
        appearance: Appearance,
    ) -> None:
        self._bullet = client
        self._body = body.number
        self._joints = list(body.joints)
        self._inertial = body.inertial
        self._appearance = appearance
        self._obstacles: dict[Hashable, int] = {}
        self._goal: tuple[int, int] | None = None
        self._world = world
        if world.terrain is None:
            self._lay_floor()
        else:
            self._lay_terrain(world.terrain)
        for outline in world.boxes:
            bottom, top = world.span_of_wall(outline)
            self._add_prism(outline, top, appearance.obstacle_color, bottom)
        # A robot with a URDF of its own has its own colors.
        for link in range(-1, client.getNumJoints(body.number) if not robot.own_urdf else -1):
            client.changeVisualShape(body.number, link, rgbaColor=_rgba(appearance.robot_color))
        self._marker = self._add_marker(appearance.robot_marker or RobotMarker.on(robot))

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one."""
        self.remove_obstacle(name)
        color = obstacle.color or self._appearance.obstacle_color
        bottom, top = self._world.span_of(obstacle)
        self._obstacles[name] = self._add_prism(obstacle.outline(sides=_SIDES), top, color, bottom)

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        if name in self._obstacles:
            self._bullet.removeBody(self._obstacles.pop(name))

    def put_goal_marker(self, pose: Pose2D) -> None:
        """Lay the goal's marker on the floor, or move it."""
        marker = self._appearance.goal_marker
        if self._goal is None:
            self._goal = (
                self._add_prism(_circle(marker.radius), marker.height, marker.color),
                self._add_prism(
                    _circle(marker.heading_radius), marker.height, marker.heading_color
                ),
            )
        ahead = pose @ Pose2D(marker.heading_distance, 0.0, 0.0)
        level = (0.0, 0.0, 0.0, 1.0)
        for disc, place in zip(self._goal, (pose, ahead)):
            height = float(self._world.ground_at(np.array([place.x, place.y])))
            self._bullet.resetBasePositionAndOrientation(disc, (place.x, place.y, height), level)

    def put_robot(
        self, center: Sequence[float], orientation: Sequence[float], angles: Sequence[float]
    ) -> None:
        """
        Pose the robot.

        Parameters
        ----------
        center : sequence of float
            The body's center of mass in the world [m].
        orientation : sequence of float
            Of the body, quaternion xyzw.
        angles : sequence of float
            Of the joints, in the order of ``Robot.joint_names`` [rad].
        """
        self._bullet.resetBasePositionAndOrientation(self._body, center, orientation)
        for joint, angle in zip(self._joints, angles):
            self._bullet.resetJointState(self._body, joint, angle)
        turned = self._inertial.base_orientation(orientation)
        to_world = np.reshape(self._bullet.getMatrixFromQuaternion(turned), (3, 3))
        base = np.asarray(center) - to_world @ self._inertial.center
        for part, place in self._marker:
            self._bullet.resetBasePositionAndOrientation(part, base + to_world @ place, turned)

    def render(self, view: Array, projection: Array, width: int, height: int) -> NDArray[np.uint8]:
        """Draw a picture; see :class:`quad_sim.world.simulated_camera.Scene`."""
        shifted = projection.copy()
        # In clip coordinates a pixel is 2 / width wide; they grow with the depth, -z.
        shifted[0, 2] += 2.0 * _HALF_PIXEL / width
        shifted[1, 2] += 2.0 * _HALF_PIXEL / height
        picture = self._bullet.getCameraImage(
            width,
            height,
            viewMatrix=view.T.reshape(-1).tolist(),
            projectionMatrix=shifted.T.reshape(-1).tolist(),
            renderer=self._bullet.ER_TINY_RENDERER,
            flags=self._bullet.ER_NO_SEGMENTATION_MASK,
            shadow=0,
            lightDirection=LIGHT_FROM,
            lightColor=(1.0, 1.0, 1.0),
            lightAmbientCoeff=AMBIENT,
            lightDiffuseCoeff=_DIFFUSE,
            lightSpecularCoeff=0.0,
        )[2]
        pixels = np.reshape(np.asarray(picture, dtype=np.uint8), (height, width, 4))
        return np.ascontiguousarray(pixels[..., :3])

    def close(self) -> None:
        """Disconnect from PyBullet."""
        if self._bullet.isConnected():
            self._bullet.disconnect()

    def _lay_floor(self) -> None:
        look = self._appearance
        floor = self._add_prism(_rectangle(_FLOOR, _FLOOR), _THIN, look.floor_color)
        below = (0.0, 0.0, -2.0 * _THIN)
        self._bullet.resetBasePositionAndOrientation(floor, below, (0.0, 0.0, 0.0, 1.0))
        if look.checker_size == 0.0:
            return
        count = int(np.ceil(_PATTERN / look.checker_size))
        places = np.arange(-count, count)
        darker = tuple(round(SQUARE_SHADE * part) for part in look.floor_color)
        square = _rectangle(look.checker_size / 2.0, look.checker_size / 2.0)
        shapes = [
            _prism(square + (np.array([column, row]) + 0.5) * look.checker_size, 0.0)
            for row in places
            for column in places[(places + row) % 2 == 0]
        ]
        self._add_mesh(shapes, (darker[0], darker[1], darker[2]))

    def _lay_terrain(self, terrain: Terrain) -> None:
        """Lay level ground around the field, the field, and the blocks; the higher the darker."""
        look = self._appearance
        x_min, y_min, x_max, y_max = terrain.field.bounds
        below = (0.0, 0.0, -2.0 * _THIN)
        for x0, y0, x1, y1 in (
            (-_FLOOR, -_FLOOR, x_min, _FLOOR),
            (x_max, -_FLOOR, _FLOOR, _FLOOR),
            (x_min, -_FLOOR, x_max, y_min),
            (x_min, y_max, x_max, _FLOOR),
        ):
            outline = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
            color = _darker(look.floor_color, _part_of(terrain, 0.0))
            floor = self._add_prism(outline, _THIN, color)
            self._bullet.resetBasePositionAndOrientation(floor, below, (0.0, 0.0, 0.0, 1.0))
        for shade, mesh in _shaded(terrain):
            self._add_mesh([mesh], _darker(look.floor_color, _part_of(terrain, shade)))
        for block in terrain.blocks:
            bottom, _ = terrain.span_under(block.outline)
            color = _darker(look.floor_color, _part_of(terrain, block.top))
            self._add_prism(block.outline, block.top, color, min(bottom, terrain.lowest))

    def _add_marker(self, marker: RobotMarker) -> tuple[tuple[int, Array], ...]:
        """Make plate and discs; return the body of each and where it is in base_link."""
        plate = _rectangle(marker.length / 2.0, marker.width / 2.0)
        disc = _circle(marker.disc_radius)
        ahead = marker.disc_distance / 2.0
        low, high = marker.height - 2.0 * _PLATE, marker.height - _PLATE
        return (
            (self._add_prism(plate, _PLATE, marker.plate_color), np.array([0.0, 0.0, low])),
            (self._add_prism(disc, _PLATE, marker.front_color), np.array([ahead, 0.0, high])),
            (self._add_prism(disc, _PLATE, marker.rear_color), np.array([-ahead, 0.0, high])),
        )

    def _add_prism(self, outline: Array, height: float, color: Color, bottom: float = 0.0) -> int:
        return self._add_mesh([_prism(outline, height, bottom)], color)

    def _add_mesh(self, shapes: list[Mesh], color: Color) -> int:
        """Add one body without collisions, of shapes as from :func:`_prism`."""
        counts = np.cumsum([0] + [len(vertices) for vertices, _, _ in shapes])
        vertices, normals = (np.concatenate([shape[k] for shape in shapes]) for k in (0, 1))
        indices = np.concatenate([shape[2] + first for shape, first in zip(shapes, counts)])
        visual = self._bullet.createVisualShape(
            self._bullet.GEOM_MESH,
            vertices=vertices.tolist(),
            normals=normals.tolist(),
            uvs=np.zeros((len(vertices), 2)).tolist(),
            indices=indices.tolist(),
            rgbaColor=_rgba(color),
        )
        body: int = self._bullet.createMultiBody(0.0, -1, visual)
        return body


def _prism(outline: Array, height: float, bottom: float = 0.0) -> Mesh:
    """
    Make the upper and the upright faces of a prism.

    Parameters
    ----------
    outline : ndarray, shape (n, 2)
        Corners of its base, convex, counter-clockwise [m].
    height : float
        Of its upper face [m].
    bottom : float
        Of its base; if it is no lower than the upper face, there is that face only [m].

    Returns
    -------
    vertices, normals : ndarray, shape (m, 3)
        Each face has its own vertices, so that edges are sharp.
    indices : ndarray, shape (k,)
        Three for each triangle.
    """
    count = len(outline)
    vertices = [np.column_stack([outline, np.full(count, height)])]
    normals = [np.tile([0.0, 0.0, 1.0], (count, 1))]
    fan = np.arange(1, count - 1)
    indices: list[NDArray[np.int64]] = [
        np.column_stack([np.zeros_like(fan), fan, fan + 1]).reshape(-1)
    ]
    if height > bottom:
        following = np.roll(outline, -1, axis=0)
        corners = np.stack([outline, following, following, outline], axis=1)
        heights = np.tile([[bottom], [bottom], [height], [height]], (count, 1, 1))
        vertices.append(np.concatenate([corners, heights], axis=2).reshape(-1, 3))
        edges = (following - outline) / np.linalg.norm(following - outline, axis=1)[:, None]
        outward = np.column_stack([edges[:, 1], -edges[:, 0], np.zeros(count)])
        normals.append(np.repeat(outward, 4, axis=0))
        first = count + 4 * np.arange(count)[:, None]
        indices.append((first + np.array([0, 1, 2, 0, 2, 3])).reshape(-1))
    return np.concatenate(vertices), np.concatenate(normals), np.concatenate(indices)


def _shaded(terrain: Terrain) -> Iterator[tuple[float, Mesh]]:
    """Yield meshes of the field, each with the middle of the heights that it has [m]."""
    x_min, y_min, x_max, y_max = terrain.field.bounds
    x, y = (
        np.linspace(low, high, max(2, int(np.ceil((high - low) / _FACET)) + 1))
        for low, high in ((x_min, x_max), (y_min, y_max))
    )
    points = np.stack(np.meshgrid(x, y), axis=-1)
    # The last ones may be off the border by a rounding error.
    heights = terrain.field.height_at(points, beyond=0.0)
    slopes = np.nan_to_num(terrain.field.slope_at(points))
    normals = np.dstack([-slopes, np.ones(heights.shape)])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    # Around the border it goes upright to the level ground there.
    points = np.pad(points, ((1, 1), (1, 1), (0, 0)), mode='edge')
    normals = np.pad(normals, ((1, 1), (1, 1), (0, 0)), mode='edge')
    heights = np.pad(heights, 1)
    vertices = np.dstack([points, heights]).reshape(-1, 3)
    index = np.arange(heights.size).reshape(heights.shape)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    facets = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 6)
    middle = heights.reshape(-1)[facets].mean(axis=1)
    low, high = float(middle.min()), float(middle.max())
    shade = np.minimum((middle - low) / max(high - low, 1e-9) * _SHADES, _SHADES - 1).astype(int)
    for number in np.unique(shade):
        used, indices = np.unique(facets[shade == number].reshape(-1), return_inverse=True)
        mesh = vertices[used], normals.reshape(-1, 3)[used], indices
        yield low + (number + 0.5) / _SHADES * (high - low), mesh


def _part_of(terrain: Terrain, height: float) -> float:
    """Return where a height is between the lowest ground, 0, and the highest, 1."""
    span = max(terrain.highest - terrain.lowest, 1e-9)
    return min(1.0, max(0.0, (height - terrain.lowest) / span))


def _darker(color: Color, part: float) -> Color:
    """Darken a color, the more the larger a part from 0 to 1 is."""
    red, green, blue = (round(value * (1.0 - (1.0 - _DARKEST) * part)) for value in color)
    return red, green, blue


def _circle(radius: float) -> Array:
    angles = np.arange(_SIDES) * (2.0 * np.pi / _SIDES)
    points: Array = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return points


def _rectangle(half_length: float, half_width: float) -> Array:
    signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return signs * (half_length, half_width)


def _rgba(color: Color) -> tuple[float, float, float, float]:
    red, green, blue = (part / 255.0 for part in color)
    return red, green, blue, 1.0
