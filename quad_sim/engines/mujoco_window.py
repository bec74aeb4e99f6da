"""
MuJoCo's own window, in which the mouse turns the view.
"""

from __future__ import annotations

import time
import warnings
from typing import Any

import mujoco

from quad_common.errors import NoDisplay

_PERIOD = 1.0 / 60.0
"""Time between two pictures [s], on the wall clock."""

_FROM = (135.0, -35.0)
"""Azimuth and elevation of the view [deg]."""


class MujocoWindow:
    """
    Shows what is simulated, until somebody closes it; the simulation goes on without it.

    Parameters
    ----------
    model, data : MjModel, MjData
        What is simulated; its first body is the robot's.
    distance : float
        Distance from which the robot is looked at [m].

    Raises
    ------
    NoDisplay
        If there is no screen.
    """

    def __init__(self, model: Any, data: Any, distance: float) -> None:
        # MuJoCo ends the process if it finds no screen.
        import glfw

        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter('always')
            if not glfw.init():
                raise NoDisplay('; '.join(str(warning.message) for warning in said))
        self._distance = distance
        self._due = 0.0
        self._open(model, data)

    def show(self, model: Any, data: Any) -> None:
        """Show the state, if it is time for another picture."""
        if time.monotonic() < self._due or not self._viewer.is_running():
            return
        if model is not self._model:
            self._viewer.close()
            self._open(model, data)
        self._viewer.sync()
        self._due = time.monotonic() + _PERIOD

    def close(self) -> None:
        """Close it."""
        self._viewer.close()

    def _open(self, model: Any, data: Any) -> None:
        from mujoco.viewer import launch_passive

        self._model = model
        self._viewer: Any = launch_passive(model, data, show_left_ui=False, show_right_ui=False)
        camera = self._viewer.cam
        camera.type, camera.trackbodyid = mujoco.mjtCamera.mjCAMERA_TRACKING, 1
        camera.distance, camera.azimuth, camera.elevation = self._distance, *_FROM
