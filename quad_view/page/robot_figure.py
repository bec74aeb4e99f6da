"""
A robot in the scene: one frame for each joint, its shapes below it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np
import viser
from numpy.typing import NDArray

from quad_common.errors.quoting import quoted
from quad_view.scene.robot_model import RobotModel, Shape
from quad_view.scene.robot_view import RobotView

Array = NDArray[np.float64]
Color = tuple[int, int, int]

ROBOT_COLORS: tuple[Color, ...] = (
    (112, 78, 170), (190, 95, 50), (70, 140, 90), (140, 85, 160), (170, 140, 40),
)  # fmt: skip
"""Of the body of the first robot, of the second, and so on."""

_LEG_COLORS: tuple[Color, ...] = ((95, 100, 108), (185, 190, 196), (120, 126, 134))
"""Of links after the first joint, after the second, and so on, in turns."""

_MESH_FORMATS = ('.stl', '.obj', '.ply', '.glb', '.dae', '.off')

_MOVED = 1e-5
"""Frames that moved by less are not sent again."""


def wxyz(quaternion: Array) -> Array:
    """Bring a quaternion xyzw into viser's order."""
    return quaternion[..., [3, 0, 1, 2]]


class RobotFigure:
    """
    Draws a robot, and sends of its pose what has changed.

    Parameters
    ----------
    server : viser.ViserServer
        The page.
    view : RobotView
        What is known of the robot.
    number : int
        Number of the robot, for its color.
    """

    def __init__(self, server: viser.ViserServer, view: RobotView, number: int) -> None:
        self._scene = server.scene
        self._view = view
        self._root = f'/robots/{number}'
        self._color = ROBOT_COLORS[number % len(ROBOT_COLORS)]
        self._frames: list[Any] = []
        self._drawn: RobotModel | None = None
        self._lacking: list[str] = []
        self._placed: tuple[Array, Array] | None = None

    def draw(self, changed: frozenset[str]) -> None:
        """Draw what has changed."""
        if 'model' in changed:
            self._build()
        if not self._frames:
            return
        if changed & {'model', 'position', 'orientation'}:
            body = self._frames[0]
            body.position = self._view.position
            body.wxyz = wxyz(self._view.orientation)
            body.visible = self._view.pose is not None
        if changed & {'model', 'joints'}:
            self._move_joints()

    def remove(self) -> None:
        """Take it out of the scene."""
        if self._frames:
            self._frames[0].remove()
        self._frames = []

    def _move_joints(self) -> None:
        assert self._drawn is not None
        positions, turns = self._drawn.poses(self._view.joints)
        if self._placed is None:
            is_moved = is_turned = np.ones(len(positions), dtype=bool)
        else:
            is_moved = np.abs(positions - self._placed[0]).max(axis=1) > _MOVED
            is_turned = np.abs(turns - self._placed[1]).max(axis=1) > _MOVED
        # The first frame is the body's.
        for index in range(1, len(self._frames)):
            if is_moved[index]:
                self._frames[index].position = positions[index]
            if is_turned[index]:
                self._frames[index].wxyz = wxyz(turns[index])
        self._placed = positions, turns

    def _build(self) -> None:
        model = self._view.model
        if self._frames:
            self._frames[0].remove()
        self._frames, self._drawn, self._placed = [], model, None
        self._lacking = []
        if model is None:
            return
        names: list[str] = []
        for index, link in enumerate(model.links):
            above = names[link.parent] if link.parent >= 0 else self._root
            names.append(f'{above}/{index}')
            self._frames.append(self._scene.add_frame(names[index], show_axes=False))
            color = self._color
            if link.depth > 0:
                color = _LEG_COLORS[(link.depth - 1) % len(_LEG_COLORS)]
            for number, shape in enumerate(link.shapes):
                self._add_shape(f'{names[index]}/shape{number}', shape, shape.color or color)
        self._view.note(lacking=tuple(dict.fromkeys(self._lacking)))

    def _add_shape(self, name: str, shape: Shape, color: Color) -> None:
        scene = self._scene
        place: dict[str, Any] = {
            'position': shape.position,
            'wxyz': wxyz(np.array(shape.orientation)),
        }
        a, b, _ = shape.size
        if shape.kind == 'box':
            scene.add_box(name, color, shape.size, **place)
        elif shape.kind == 'cylinder':
            scene.add_cylinder(name, a, b, color, radial_segments=16, **place)
        elif shape.kind == 'sphere':
            scene.add_icosphere(name, a, color, subdivisions=2, **place)
        else:
            self._add_mesh(name, shape, color, place)

    def _add_mesh(self, name: str, shape: Shape, color: Color, place: dict[str, Any]) -> None:
        """Draw a mesh of a file on this machine; one that cannot be read is left out, and named."""
        path = mesh_file(shape.mesh)
        if path is None:
            formats = ', '.join(_MESH_FORMATS)
            self._lacking.append(f'{quoted(shape.mesh)} is no file here that ends in {formats}')
            return
        # viser has it; only robots with meshes need it.
        import trimesh

        try:
            mesh: Any = trimesh.load(path, force='mesh')
        except Exception:
            # Whatever a reader of some format raises: the rest of the robot is drawn.
            self._lacking.append(f'{quoted(shape.mesh)} cannot be read')
            return
        vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        if len(faces):
            self._scene.add_mesh_simple(
                name, vertices * np.array(shape.size), faces, color=color, side='double', **place
            )


def mesh_file(name: str) -> Path | None:
    """
    Find a mesh's file.

    Parameters
    ----------
    name : str
        As a URDF has it: a path, ``file://``, or ``package://`` with a ROS installation.

    Returns
    -------
    Path or None
        The file; None if it is not there, or of no known format.
    """
    parts = urlsplit(name)
    if parts.scheme == 'package':
        try:
            from ament_index_python.packages import get_package_share_directory

            path = Path(get_package_share_directory(parts.netloc)) / unquote(parts.path).lstrip('/')
        except (ImportError, LookupError):
            return None
    else:
        path = Path(unquote(parts.path) if parts.scheme == 'file' else name)
    is_known = path.suffix.lower() in _MESH_FORMATS and path.is_absolute()
    return path if is_known and path.is_file() else None
