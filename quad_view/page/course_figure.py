"""
A robot's walk in the scene: plan, goal, walked track, footholds, support polygon.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_view.page.robot_figure import ROBOT_COLORS
from quad_view.scene.floor import laid_on
from quad_view.scene.robot_view import RobotView

Array = NDArray[np.float64]

_PLAN, _TURNING_POINT, _GOAL = (30, 110, 240), (250, 130, 10), (20, 150, 60)
_FOOTHOLD = (30, 160, 70)
_PLAN_Z, _TRACK_Z, _SUPPORT_Z, _GOAL_Z = 0.02, 0.012, 0.008, 0.025
"""Heights above the floor, so that nothing hides in it [m]."""

_TRACK_PERIOD = 0.2
"""Time between two updates of the track, which is long [s]."""

SAFE_MARGIN = 0.05
"""A margin from which the support polygon is green; it is red at zero [m]."""


def support_color(margin: float) -> tuple[int, int, int]:
    """Color a stability margin [m]: red at 0 and below, over yellow to green at `SAFE_MARGIN`."""
    part = min(max(margin / SAFE_MARGIN, 0.0), 1.0) if math.isfinite(margin) else 0.0
    red = 225 if part < 0.5 else round(225 - (part - 0.5) * 2.0 * 185)
    green = round(50 + min(part, 0.5) * 2.0 * 130)
    return red, green, 50


def segments(points: Array) -> Array:
    """Join points, shape (n, 3), by lines, shape (n - 1, 2, 3) [m]."""
    return np.stack([points[:-1], points[1:]], axis=1)


class CourseFigure:
    """
    Draws where a robot walks, has walked and steps.

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
        self._root = f'/walks/{number}'
        self._color = ROBOT_COLORS[number % len(ROBOT_COLORS)]
        self._handles: dict[str, Any] = {}
        self._track_due = 0.0
        self._has_new_track = False

    def remove(self) -> None:
        """Take it out of the scene."""
        for name in list(self._handles):
            self._handles.pop(name).remove()

    def draw(self, changed: frozenset[str], now: float) -> None:
        """Draw what has changed, at a time of the wall clock [s]."""
        view = self._view
        if changed & {'plan', 'surface'}:
            self._draw_plan(view.plan)
        if changed & {'goal', 'surface'}:
            self._draw_goal(view.goal)
        if 'footholds' in changed:
            self._draw_footholds(view.footholds)
        if changed & {'support', 'margin'}:
            self._draw_support(view.support, view.margin)
        self._has_new_track = self._has_new_track or 'track' in changed
        if self._has_new_track and now >= self._track_due:
            self._has_new_track, self._track_due = False, now + _TRACK_PERIOD
            self._line('track', view.track, _TRACK_Z, self._color, 0.015)

    def _draw_goal(self, goal: Pose2D | None) -> None:
        """Draw a goal as an arrow on the floor."""
        if goal is None:
            self._remove('goal')
            return
        tip = goal @ Pose2D(0.45, 0.0, 0.0)
        ends = np.array([[goal.x, goal.y], [tip.x, tip.y]])
        z = laid_on(self._view.surface, ends, _GOAL_Z)[:, 2].max()
        ends = np.column_stack([ends, [z, z]])[None]
        self._handles['goal'] = self._scene.add_arrows(
            f'{self._root}/goal', ends, _GOAL, shaft_radius=0.02, head_radius=0.06, head_length=0.15
        )

    def _draw_plan(self, corners: Array) -> None:
        self._line('plan', corners, _PLAN_Z, _PLAN, 0.03)
        if len(corners) < 2:
            self._remove('corners')
            return
        surface = self._view.surface
        points = np.vstack([laid_on(surface, corner[None], _PLAN_Z) for corner in corners])
        self._handles['corners'] = self._scene.add_point_cloud(
            f'{self._root}/corners', points, _TURNING_POINT, point_size=0.06, point_shape='circle'
        )

    def _draw_footholds(self, footholds: Array) -> None:
        if not len(footholds):
            self._remove('footholds')
            return
        self._handles['footholds'] = self._scene.add_point_cloud(
            f'{self._root}/footholds', footholds + (0.0, 0.0, 0.015), _FOOTHOLD,
            point_size=0.03, point_shape='circle',
        )  # fmt: skip

    def _draw_support(self, corners: Array, margin: float) -> None:
        if len(corners) < 2:
            self._remove('support')
            return
        closed = laid_on(self._view.surface, np.vstack([corners, corners[:1]]), _SUPPORT_Z)
        self._put_line('support', segments(closed), support_color(margin), 0.02)

    def _line(
        self, name: str, points: Array, z: float, color: tuple[int, int, int], width: float
    ) -> None:
        if len(points) < 2:
            self._remove(name)
        else:
            line = laid_on(self._view.surface, points, z)
            self._put_line(name, segments(line), color, width)

    def _put_line(self, name: str, lines: Array, color: tuple[int, int, int], width: float) -> None:
        handle = self._handles.get(name)
        if handle is None:
            self._handles[name] = self._scene.add_line_segments(
                f'{self._root}/{name}', lines, color, thickness=width
            )
            return
        handle.points = lines.astype(np.float32)
        if tuple(handle.colors) != color:
            handle.colors = np.array(color, dtype=np.uint8)

    def _remove(self, name: str) -> None:
        handle = self._handles.pop(name, None)
        if handle is not None:
            handle.remove()
