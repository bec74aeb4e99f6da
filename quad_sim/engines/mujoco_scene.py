"""
What the ceiling camera sees of a world in MuJoCo, drawn by OpenGL without a screen.

What is drawn is the model that is simulated, in a state of its own, and the markers, which are in
the picture only. So taking pictures cannot disturb the simulation.
"""

from __future__ import annotations

import atexit
import importlib
import os
import weakref
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from quad_common.errors import NoRenderer
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.vision.markers import Color, RobotMarker
from quad_sim.engines.mujoco_model import rgba
from quad_sim.world.appearance import Appearance
from quad_sim.world.simulated_camera import FAR, NEAR
from quad_sim.world.world import World

Array = NDArray[np.float64]

_PLATE = 0.004
"""Thickness of the robot's marker, and how far its discs stand out [m]."""

_PARTS_OF_MARKERS = 5
"""Plate and discs of the robot, and the discs at the goal."""

_RENDERERS = ('egl', 'osmesa')
"""What draws without a screen; ``MUJOCO_GL`` puts one of them first, as elsewhere in MuJoCo."""

_UNWANTED = ('SHADOW', 'REFLECTION', 'SKYBOX', 'HAZE', 'FOG')
"""Effects that would change colors."""


@dataclass
class _Canvas:
    """What OpenGL holds for one model and size of picture."""

    model: Any
    width: int
    height: int
    scene: Any
    context: Any


class MujocoScene:
    """
    A robot, obstacles and markers to be looked at.

    Parameters
    ----------
    robot : Robot
        Robot that carries the marker.
    world : World
        Ground on which the goal's marker lies.
    appearance : Appearance
        Markers; the colors are the model's.

    Raises
    ------
    NoRenderer
        If neither EGL nor OSMesa is there.
    """

    def __init__(self, robot: Robot, world: World, appearance: Appearance) -> None:
        self._world = world
        self._appearance = appearance
        self._marker = appearance.robot_marker or RobotMarker.on(robot)
        self._options = mujoco.MjvOption()
        self._no_force = mujoco.MjvPerturb()
        self._camera = mujoco.MjvCamera()
        self._canvases: list[_Canvas] = []
        self._state: Any = None
        self._gl = _gl_context()
        self.close = weakref.finalize(self, _release, self._gl, self._canvases)
        """Release what OpenGL holds."""
        # Also where it is never closed, and before the display is: that was registered just now,
        # and what was registered last is called first.
        self.close.atexit = False
        atexit.register(self.close)

    def render(
        self,
        model: Any,
        positions: Array,
        goal: Pose2D | None,
        view: Array,
        projection: Array,
        size: tuple[int, int],
    ) -> NDArray[np.uint8]:
        """
        Draw a picture.

        Parameters
        ----------
        model : MjModel
            What is simulated.
        positions : ndarray
            MuJoCo's ``qpos``, with base_link first.
        goal : Pose2D or None
            Where the goal's marker lies.
        view, projection : ndarray, shape (4, 4)
            See :class:`quad_sim.world.simulated_camera.Scene`.
        size : tuple of int
            Width and height of the picture [pixels].

        Returns
        -------
        ndarray of uint8, shape (height, width, 3)
            Red, green and blue; the first row is the top.
        """
        self._gl.make_current()
        canvas = self._canvas_for(model, *size)
        state = self._state
        state.qpos[:] = positions
        mujoco.mj_kinematics(model, state)
        mujoco.mj_comPos(model, state)
        mujoco.mj_camlight(model, state)
        scene = canvas.scene
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(
            model, state, self._options, self._no_force, self._camera, everything, scene
        )
        for effect in _UNWANTED:
            scene.flags[getattr(mujoco.mjtRndFlag, f'mjRND_{effect}')] = False
        self._add_robot_marker(scene, state.qpos[:3], state.xmat[1].reshape(3, 3))
        if goal is not None:
            self._add_goal_marker(scene, goal)
        for eye in scene.camera:
            _aim(eye, view, projection)
        picture = np.empty((size[1], size[0], 3), dtype=np.uint8)
        place = mujoco.MjrRect(0, 0, *size)
        mujoco.mjr_render(place, scene, canvas.context)
        mujoco.mjr_readPixels(picture, None, place, canvas.context)
        # OpenGL's first row is the lowest.
        return np.ascontiguousarray(picture[::-1])

    def _canvas_for(self, model: Any, width: int, height: int) -> _Canvas:
        before = self._canvases[0] if self._canvases else None
        if before and before.model is model and (before.width, before.height) == (width, height):
            return before
        if before:
            before.context.free()
            self._canvases.clear()
        if before is None or before.model is not model:
            self._state = mujoco.MjData(model)
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        scene = mujoco.MjvScene(model, model.ngeom + _PARTS_OF_MARKERS)
        context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, context)
        self._canvases.append(_Canvas(model, width, height, scene, context))
        return self._canvases[0]

    def _add_robot_marker(self, scene: Any, base: Array, rotation: Array) -> None:
        marker = self._marker
        ahead = marker.disc_distance / 2.0
        plate = marker.height - 1.5 * _PLATE
        disc = marker.height - 0.5 * _PLATE
        half = _PLATE / 2.0
        box = marker.length / 2.0, marker.width / 2.0, half
        cylinder = marker.disc_radius, half, 0.0
        for shape, size, place, color in (
            ('BOX', box, (0.0, plate), marker.plate_color),
            ('CYLINDER', cylinder, (ahead, disc), marker.front_color),
            ('CYLINDER', cylinder, (-ahead, disc), marker.rear_color),
        ):
            center = base + rotation @ np.array([place[0], 0.0, place[1]])
            _add(scene, shape, size, center, rotation, color)

    def _add_goal_marker(self, scene: Any, goal: Pose2D) -> None:
        marker = self._appearance.goal_marker
        ahead = goal @ Pose2D(marker.heading_distance, 0.0, 0.0)
        for place, radius, color in (
            (goal, marker.radius, marker.color),
            (ahead, marker.heading_radius, marker.heading_color),
        ):
            height = float(self._world.ground_at(np.array([place.x, place.y])))
            half = marker.height / 2.0
            center = np.array([place.x, place.y, height + half])
            _add(scene, 'CYLINDER', (radius, half, 0.0), center, np.eye(3), color)


def _add(
    scene: Any,
    shape: str,
    size: tuple[float, ...],
    center: Array,
    rotation: Array,
    color: Color,
) -> None:
    """Add a body that is in the picture only."""
    kind = getattr(mujoco.mjtGeom, f'mjGEOM_{shape}')
    geom = scene.geoms[scene.ngeom]
    red, green, blue, opaque = rgba(color)
    paint = np.array([red, green, blue, opaque], dtype=np.float32)
    mujoco.mjv_initGeom(geom, kind, np.array(size), center, rotation.reshape(-1), paint)
    geom.specular = 0.0
    scene.ngeom += 1


def _aim(eye: Any, view: Array, projection: Array) -> None:
    """Set one of a scene's eyes."""
    rotation = view[:3, :3]
    eye.pos = -rotation.T @ view[:3, 3]
    eye.forward, eye.up = -rotation[2], rotation[1]
    # The sides of the picture on the plane at the distance NEAR.
    (half_width, half_height), (right, up) = NEAR / projection.diagonal()[:2], projection[:2, 2]
    eye.frustum_near, eye.frustum_far = NEAR, FAR
    eye.frustum_center, eye.frustum_width = right * half_width, half_width
    eye.frustum_bottom = (up - 1.0) * half_height
    eye.frustum_top = (up + 1.0) * half_height


def _release(gl: Any, canvases: list[_Canvas]) -> None:
    """Give back what OpenGL holds, the one canvas that there may be first."""
    gl.make_current()
    for canvas in canvases:
        canvas.context.free()
    canvases.clear()
    gl.free()


def _gl_context() -> Any:
    """Make what OpenGL draws in; its size is that of the frame that MuJoCo makes in it."""
    wanted = os.environ.get('MUJOCO_GL', '').lower()
    reasons = []
    for name in sorted(_RENDERERS, key=lambda name: name != wanted):
        try:
            return importlib.import_module(f'mujoco.{name}').GLContext(1, 1)
        # Whatever is wrong with drivers and libraries ends here: each fails in its own way.
        except Exception as error:
            reasons.append(f'{name}: {error}'.strip())
    raise NoRenderer('; '.join(reasons))
