"""
Clicks and drags on the floor.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
import viser

from quad_view.page.controls import Controls
from quad_view.scene.commands import Command, GiveGoal, PutObstacle
from quad_view.scene.course import goal_of_drag
from quad_view.scene.floor import floor_point
from quad_view.scene.robot_view import RobotView


class Pointing:
    """
    Makes commands of where somebody points on the floor.

    Parameters
    ----------
    server : viser.ViserServer
        The page.
    controls : Controls
        They say what a click does.
    robot : callable
        Returns the robot that is looked at, if any.
    send : callable
        Takes a command; from any thread.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        controls: Controls,
        robot: Callable[[], RobotView | None],
        send: Callable[[Command], None],
    ) -> None:
        self._controls = controls
        self._robot = robot
        self._send = send
        # viser takes coroutines, whatever its annotations say.
        server.scene.on_click()(cast(Any, self._on_click))

    def watch(self, floor: Any) -> None:
        """Take drags on a floor's handle; with Shift, so that others turn the view."""
        floor.on_drag(button='left', modifier='shift')(self._on_drag)

    # Coroutines, so that what a hand does keeps its order.
    async def _on_click(self, event: Any) -> None:
        point = floor_point(np.array(event.ray_origin), np.array(event.ray_direction))
        view = self._robot()
        if point is None or view is None:
            return
        goal = goal_of_drag(point, point, view.pose)
        if self._controls.puts_obstacles:
            self._send(PutObstacle(view.name, goal, self._controls.obstacle_size))
        else:
            self._send(GiveGoal(view.name, self._controls.with_heading(goal)))

    async def _on_drag(self, event: Any) -> None:
        view = self._robot()
        if event.phase != 'end' or view is None:
            return
        camera = np.array(event.client.camera.position)
        # The end lies on a plane that faces the camera: the floor is behind or before it.
        end = floor_point(camera, np.array(event.end_position) - camera)
        if end is not None:
            # What was pressed may lie below the ground.
            pressed = floor_point(camera, np.array(event.start_position) - camera)
            start = pressed or end
            self._send(GiveGoal(view.name, goal_of_drag(start, end, view.pose)))
