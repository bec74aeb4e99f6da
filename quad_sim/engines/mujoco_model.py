"""
The model that MuJoCo simulates: robots, the ground, walls and obstacles.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from quad_common.vision.markers import Color
from quad_sim.engines.simulator import BALL, GRAVITY, GROUND, OBSTACLE, Ball
from quad_sim.world.appearance import AMBIENT, LIGHT_FROM, SQUARE_SHADE, Appearance
from quad_sim.world.terrain import Terrain
from quad_sim.world.world import OF_WORLD, Obstacle, World

Array = NDArray[np.float64]

_AROUND = 100.0
"""Width of the level ground around a height field [m]."""

_DEEP = 1.0
"""Depth to which the ground around a field, and blocks, reach down [m]."""

_CONTACT_TIME, _CONTACT_DAMPING = 2.4, 0.9
"""Time constant of contacts, in time steps, and their damping ratio. What rebounds rocks a trotting
body about the diagonal it stands on: at (2.75, 0.7) genibo, forward, by 0.57 degrees, not 0.39. At
(2.2, 1.0) cuhk, which keeps its balance, falls on a slope of 15 degrees, and at (2.5, 0.8) it rocks
there. What feet sink in by as they stand longer is taken back by `MujocoDrives`."""

_CONTACT_IMPEDANCE = (0.945, 0.945, 0.001, 0.5, 2.0)
"""The same at any depth. MuJoCo means it for feet whose joints are loose: while motors hold them,
ten times the inertia is behind, and contacts give more. With 0.95 and (2.75, 0.7) cuhk, turning on
the spot by trotting, rocks by 0.22 degrees, not 0.11."""

_ITERATIONS, _LINE_SEARCHES = 100, 50
"""Most of the solver's; with a fifth of them it may end in NaN after an impact."""

_SIDES = 48
"""Number of sides of a cylinder in pictures."""


class MujocoModel:
    """
    Robots and their world as a specification that can be compiled, and compiled again.

    Parameters
    ----------
    spec : MjSpec
        The robot, of `mujoco_robot.robot_spec`, or several robots, of `robots_spec`.
    world : World
        Ground, walls and obstacles.
    time_step : float
        Fixed step [s].
    appearance : Appearance
        Colors.
    robots : int
        Number of robots.
    """

    def __init__(
        self,
        spec: Any,
        world: World,
        time_step: float,
        appearance: Appearance,
        robots: int = 1,
    ) -> None:
        self._spec = spec
        self._robots = robots
        self._world = world
        self._appearance = appearance
        self._time_step = time_step
        self._heights: Array | None = None
        self._count: Counter[str] = Counter()
        self._placed: dict[Hashable, tuple[Obstacle, Any]] = {}
        self._ball: Any = None
        # Feet are bodies of their own, so that contacts can be told apart.
        self._spec.compiler.fusestatic = False
        # Shapes that are only looked at were left out on reading; the floor's pattern is to stay.
        self._spec.compiler.discardvisual = False
        self._set_options()
        self._set_light()
        self._pattern = self._make_pattern()
        self._lay_ground()
        for outline in world.boxes:
            self._add_wall(outline)
        for index, obstacle in enumerate(world.obstacles):
            self.put_obstacle((OF_WORLD, index), obstacle)

    @property
    def obstacles(self) -> dict[Hashable, Obstacle]:
        """Those that stand there now, besides the walls."""
        return {name: obstacle for name, (obstacle, _) in self._placed.items()}

    def compile(self) -> tuple[Any, Any]:
        """Return MuJoCo's model and data."""
        model = self._spec.compile()
        self._set_heights(model)
        return model, mujoco.MjData(model)

    def compile_again(self, model: Any, data: Any) -> tuple[Any, Any]:
        """Return model and data after a change; the robot's state is kept."""
        model, data = self._spec.recompile(model, data)
        self._set_heights(model)
        return model, data

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one."""
        self.remove_obstacle(name)
        bottom, top = self._world.span_of(obstacle)
        half = (top - bottom) / 2.0
        place = [obstacle.pose.x, obstacle.pose.y, bottom + half]
        if obstacle.kind == 'box':
            size = [obstacle.length / 2.0, obstacle.width / 2.0, half]
            geom = self._add_box(OBSTACLE, size, place, obstacle.pose.yaw)
        else:
            geom = self._add(OBSTACLE, mujoco.mjtGeom.mjGEOM_CYLINDER, place)
            geom.size = [obstacle.length / 2.0, half, 0.0]
        geom.rgba = rgba(obstacle.color or self._appearance.obstacle_color)
        self._placed[name] = obstacle, geom

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        if name in self._placed:
            self._spec.delete(self._placed.pop(name)[1])

    def put_ball(self, ball: Ball | None) -> None:
        """Put a ball, which is free to move, in the place of the last one; None: none."""
        if self._ball is not None:
            self._spec.delete(self._ball)
            self._ball = None
        if ball is not None:
            self._ball = self._spec.worldbody.add_body(name=BALL, pos=ball.position.tolist())
            self._ball.add_freejoint()
            geom = self._ball.add_geom(
                type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[ball.radius, 0.0, 0.0], mass=ball.mass
            )
            make_solid(geom, self._world.friction, self._time_step)

    def _set_options(self) -> None:
        option = self._spec.option
        option.timestep = self._time_step
        option.gravity = [0.0, 0.0, -GRAVITY]
        option.solver = mujoco.mjtSolver.mjSOL_NEWTON
        # Nothing is damped but by constraints, so that implicit integration would give the same
        # in a fifth more time.
        option.integrator = mujoco.mjtIntegrator.mjINT_EULER
        # Of all combinations that were tried only this one suits every robot's trot: elliptic cones
        # and stiffer friction let the small robots rock by up to 2.9 degrees. MuJoCo's pass against
        # slip is off: what stands is anchored (`MujocoDrives`), in less time.
        option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
        option.impratio = 1.0
        if self._robots == 1:
            # There is nothing to gain from telling islands of contacts apart.
            option.disableflags |= int(getattr(mujoco.mjtDisableBit, 'mjDSBL_ISLAND', 0))
        option.iterations, option.ls_iterations = _ITERATIONS, _LINE_SEARCHES

    def _set_light(self) -> None:
        """Light the world so that what is level has just its own color."""
        visual = self._spec.visual
        visual.headlight.active = False
        visual.quality.offsamples = 0
        visual.quality.numslices = _SIDES
        light = self._spec.worldbody.add_light()
        light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
        light.dir = [-part for part in LIGHT_FROM]
        light.castshadow = False
        upward = LIGHT_FROM[2] / float(np.linalg.norm(LIGHT_FROM))
        light.ambient = [AMBIENT] * 3
        light.diffuse = [(1.0 - AMBIENT) / upward] * 3
        light.specular = [0.0] * 3

    def _make_pattern(self) -> str:
        """Make the material of a floor with squares, and return its name; empty without squares."""
        look = self._appearance
        if look.checker_size == 0.0:
            return ''
        texture = self._spec.add_texture(
            name='floor', type=mujoco.mjtTexture.mjTEXTURE_2D, width=128, height=128
        )
        texture.builtin = mujoco.mjtBuiltin.mjBUILTIN_CHECKER
        texture.rgb1 = rgba(look.floor_color)[:3]
        texture.rgb2 = [SQUARE_SHADE * part for part in texture.rgb1]
        material = self._spec.add_material(name='floor', texuniform=True, specular=0.0)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = 'floor'
        # A texture has two squares in each direction.
        material.texrepeat = [0.5 / look.checker_size] * 2
        return 'floor'

    def _lay_ground(self) -> None:
        terrain = self._world.terrain
        if terrain is None or terrain.is_level:
            self._add(GROUND, mujoco.mjtGeom.mjGEOM_PLANE, [0.0, 0.0, 0.0]).size = [0.0, 0.0, 1.0]
        else:
            self._add_field(terrain)
            self._add_surroundings(terrain)
        if terrain is not None:
            bottom = terrain.lowest - _DEEP
            for block in terrain.blocks:
                half = [block.length / 2.0, block.width / 2.0, (block.top - bottom) / 2.0]
                place = [block.pose.x, block.pose.y, block.top - half[2]]
                self._add_box(GROUND, half, place, block.pose.yaw)

    def _add_field(self, terrain: Terrain) -> None:
        """Add the height field, with one more cell on each side so that it reaches its border."""
        field = terrain.field
        heights: Array = np.pad(field.heights, 1, mode='edge')
        rows, columns = heights.shape
        low, high = float(heights.min()), float(heights.max())
        half = [(columns - 1) * field.resolution / 2.0, (rows - 1) * field.resolution / 2.0]
        shape = self._spec.add_hfield(
            name=GROUND, nrow=rows, ncol=columns, size=[*half, high - low, _DEEP]
        )
        shape.userdata = heights.ravel()
        self._heights = ((heights - low) / (high - low)).ravel()
        x_min, y_min, x_max, y_max = field.bounds
        place = [(x_min + x_max) / 2.0, (y_min + y_max) / 2.0, low]
        self._add(GROUND, mujoco.mjtGeom.mjGEOM_HFIELD, place).hfieldname = GROUND

    def _add_surroundings(self, terrain: Terrain) -> None:
        """Add four boxes around the field with their tops at z = 0."""
        x_min, y_min, x_max, y_max = terrain.field.bounds
        west, south, east, north = (
            x_min - _AROUND,
            y_min - _AROUND,
            x_max + _AROUND,
            y_max + _AROUND,
        )
        depth = _DEEP - terrain.lowest
        for x0, y0, x1, y1 in (
            (west, south, x_min, north),
            (x_max, south, east, north),
            (x_min, south, x_max, y_min),
            (x_min, y_max, x_max, north),
        ):
            half = [(x1 - x0) / 2.0, (y1 - y0) / 2.0, depth / 2.0]
            self._add_box(GROUND, half, [(x0 + x1) / 2.0, (y0 + y1) / 2.0, -depth / 2.0], 0.0)

    def _add_wall(self, outline: Array) -> None:
        bottom, top = self._world.span_of_wall(outline)
        along, across = outline[1] - outline[0], outline[3] - outline[0]
        half = [float(np.hypot(*along)) / 2.0, float(np.hypot(*across)) / 2.0, (top - bottom) / 2.0]
        x, y = outline.mean(axis=0).tolist()
        yaw = float(np.arctan2(along[1], along[0]))
        self._add_box(OBSTACLE, half, [x, y, (top + bottom) / 2.0], yaw)

    def _add_box(self, kind: str, half: list[float], place: list[float], yaw: float) -> Any:
        geom = self._add(kind, mujoco.mjtGeom.mjGEOM_BOX, place)
        geom.size = half
        geom.quat = quaternion_of_yaw(yaw)
        return geom

    def _add(self, kind: str, shape: Any, place: list[float]) -> Any:
        """Add a geometry that stands fast."""
        self._count[kind] += 1
        geom = self._spec.worldbody.add_geom(
            name=f'{kind} {self._count[kind]}', type=shape, pos=place
        )
        # As in Bullet, where the frictions of two surfaces are multiplied and the robot's is 1.
        make_solid(geom, self._world.friction if kind == GROUND else 0.5, self._time_step)
        geom.priority = 1
        if kind == OBSTACLE:
            geom.rgba = rgba(self._appearance.obstacle_color)
        elif self._pattern:
            geom.material = self._pattern
        else:
            geom.rgba = rgba(self._appearance.floor_color)
        return geom

    def _set_heights(self, model: Any) -> None:
        """Put the heights back that the compiler stretches from 0 to 1 by itself."""
        if self._heights is not None:
            model.hfield_data[:] = self._heights


def make_solid(geom: Any, friction: float, time_step: float) -> None:
    """Let a geometry collide, with Coulomb friction and as stiff as the time step [s] allows."""
    geom.condim = 3
    geom.friction = [friction, 0.0, 0.0]
    geom.solref = [_CONTACT_TIME * time_step, _CONTACT_DAMPING]
    geom.solimp = list(_CONTACT_IMPEDANCE)


def rgba(color: Color) -> list[float]:
    """Return an opaque color, each part from 0 to 1."""
    return [*(part / 255.0 for part in color), 1.0]


def quaternion_of_yaw(yaw: float) -> list[float]:
    """Return the quaternion wxyz of a heading [rad]."""
    return [float(np.cos(yaw / 2.0)), 0.0, 0.0, float(np.sin(yaw / 2.0))]
