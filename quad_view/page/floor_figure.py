"""
The room in the scene: map, safety boundary, ground, obstacles.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import viser

from quad_view.page.course_figure import segments
from quad_view.scene.floor import laid_on, with_walls
from quad_view.scene.robot_view import RobotView

_BOUNDARY, _OBSTACLE = (205, 45, 45), (205, 110, 70)
_FLOOR_Z, _BOUNDARY_Z, _BELOW = -0.004, 0.006, 0.02
"""Heights above the ground, so that nothing hides in it [m]."""


class FloorFigure:
    """
    Draws the room of the robot that is looked at.

    Parameters
    ----------
    server : viser.ViserServer
        The page.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._handles: dict[str, Any] = {}
        self._shown: RobotView | None = None

    @property
    def handle(self) -> Any:
        """What is pointed at: the map, once it is drawn."""
        return self._handles['floor']

    def draw(self, view: RobotView, changed: frozenset[str]) -> bool:
        """Draw what has changed of a robot's room, or all of another one; return if the map has."""
        if view is not self._shown:
            self._shown = view
            changed = frozenset({'floor', 'boundary', 'surface', 'obstacles'})
        if changed & {'surface', 'floor'}:
            self._draw_floor(view)
        if changed & {'boundary', 'surface'}:
            self._draw_boundary(view)
        if changed & {'surface', 'floor'}:
            self._draw_surface(view)
        if changed & {'obstacles', 'surface'}:
            self._draw_obstacles(view)
        return bool(changed & {'surface', 'floor'}) and view.floor is not None

    def _draw_floor(self, view: RobotView) -> None:
        floor = view.floor
        self._remove('floor')
        if floor is None:
            return
        center, (width, height) = floor.center, floor.size
        z = _FLOOR_Z
        if view.surface is not None:
            # The ground shows the walls: the picture must not come through it.
            z += float(view.surface.vertices[:, 2].min()) - _BELOW
        # viser hangs pictures so that their top is at -y and their face looks down: half a turn
        # about the picture's own rows brings both right.
        half = 0.5 * center.yaw
        self._handles['floor'] = self._scene.add_image(
            '/room/floor', floor.pixels, width, height, format='png',
            position=(center.x, center.y, z),
            wxyz=(0.0, math.cos(half), math.sin(half), 0.0), cast_shadow=False,
        )  # fmt: skip

    def _draw_boundary(self, view: RobotView) -> None:
        self._remove('boundary')
        lines = [segments(laid_on(view.surface, line, _BOUNDARY_Z)) for line in view.boundary]
        if lines:
            self._handles['boundary'] = self._scene.add_line_segments(
                '/room/boundary', np.concatenate(lines), _BOUNDARY, thickness=0.02
            )

    def _draw_surface(self, view: RobotView) -> None:
        self._remove('surface')
        surface = view.surface
        if surface is None or not len(surface.faces):
            return
        # viser has it; only uneven ground needs it.
        import trimesh

        if view.floor is not None:
            surface = with_walls(surface, view.floor)
        mesh = trimesh.Trimesh(
            surface.vertices, surface.faces, vertex_colors=surface.colors, process=False
        )
        self._handles['surface'] = self._scene.add_mesh_trimesh(
            '/room/surface', mesh, cast_shadow=False
        )

    def _draw_obstacles(self, view: RobotView) -> None:
        for name in [name for name in self._handles if name.startswith('obstacle')]:
            self._remove(name)
        for index, (kind, pose, (length, width, height)) in enumerate(view.obstacles.values()):
            name = f'obstacle{index}'
            half = 0.5 * pose.yaw
            base = laid_on(view.surface, np.array([[pose.x, pose.y]]), 0.5 * height)[0]
            place: dict[str, Any] = {
                'position': base,
                'wxyz': (math.cos(half), 0.0, 0.0, math.sin(half)),
            }
            if kind == 'box':
                handle: Any = self._scene.add_box(
                    f'/room/{name}', _OBSTACLE, (length, width, height), **place
                )
            else:
                handle = self._scene.add_cylinder(
                    f'/room/{name}', 0.5 * length, height, _OBSTACLE, **place
                )
            self._handles[name] = handle

    def _remove(self, name: str) -> None:
        handle = self._handles.pop(name, None)
        if handle is not None:
            handle.remove()
