"""
The robot in PyBullet's physics. The only file that imports pybullet.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from collections.abc import Hashable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import MissingOptionalDependency
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.engines.bullet_body import SOLVER_ITERATIONS, load_body
from quad_sim.engines.bullet_ground import lay_ground
from quad_sim.engines.bullet_obstacles import BulletObstacles, build_walls
from quad_sim.engines.bullet_robot import BulletRobot
from quad_sim.engines.bullet_scene import BulletScene
from quad_sim.engines.simulator import BALL, GRAVITY, GROUND, OBSTACLE, Ball, Observation
from quad_sim.world.appearance import Appearance
from quad_sim.world.world import OF_WORLD, Obstacle, World


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Keep what PyBullet prints off the output, which may be somebody's JSON."""
    streams = (sys.stdout, sys.stderr)
    with Path(os.devnull).open('wb') as nothing:
        for stream in streams:
            stream.flush()
        saved = [os.dup(number) for number in (1, 2)]
        try:
            for number in (1, 2):
                os.dup2(nothing.fileno(), number)
            yield
        finally:
            # Python and C keep what they print to a pipe or a file until later.
            for stream in streams:
                stream.flush()
            ctypes.CDLL(None).fflush(None)
            for number, was in zip((1, 2), saved):
                os.dup2(was, number)
                os.close(was)


try:
    with silenced():
        import pybullet
        from pybullet_utils.bullet_client import BulletClient
except ImportError as error:
    raise MissingOptionalDependency(
        'pybullet', 'pip install pybullet (wheels for Python up to 3.11; later ones compile it)'
    ) from error

Array = NDArray[np.float64]


class _Client(BulletClient):  # type: ignore[misc]
    """A ``BulletClient`` that makes each function once: it makes them anew for every call."""

    def __getattr__(self, name: str) -> Any:
        """Return a function of PyBullet for this client, and keep it."""
        found = super().__getattr__(name)
        if name == 'disconnect':
            # Another world may get this one's number: nothing is to reach it by what was kept.
            for kept in [own for own in vars(self) if not own.startswith('_')]:
                delattr(self, kept)
        else:
            setattr(self, name, found)
        return found


def headless_client() -> Any:
    """Open an empty world without a window, a ``BulletClient`` of one's own."""
    with silenced():
        return _Client(pybullet.DIRECT)


def open_client(time_step: float, gui: bool = False) -> Any:
    """
    Open an empty world in which there is gravity, and runs repeat.

    Parameters
    ----------
    time_step : float
        Fixed step [s].
    gui : bool
        Whether to show PyBullet's own window.

    Returns
    -------
    BulletClient
        The world.
    """
    with silenced():
        client = _Client(pybullet.GUI if gui else pybullet.DIRECT)
    client.setGravity(0.0, 0.0, -GRAVITY)
    client.setPhysicsEngineParameter(
        fixedTimeStep=time_step,
        numSolverIterations=SOLVER_ITERATIONS,
        deterministicOverlappingPairs=1,
    )
    return client


class BulletSimulator(BulletRobot):
    """
    A rigid-body simulation of one robot in one world.

    Parameters
    ----------
    robot : Robot
        The robot.
    world : World
        Ground and obstacles.
    time_step : float
        Fixed step [s].
    gui : bool
        Show PyBullet's own window.
    appearance : Appearance, optional
        Of the world in pictures.

    Raises
    ------
    MissingOptionalDependency
        On import of this module, if PyBullet is not installed.
    """

    def __init__(
        self,
        robot: Robot,
        world: World,
        time_step: float = 0.005,
        gui: bool = False,
        appearance: Appearance | None = None,
    ) -> None:
        self._appearance = Appearance() if appearance is None else appearance
        self._scene: BulletScene | None = None
        self._goal: Pose2D | None = None
        self._steps = 0
        self._ball: int | None = None
        client = open_client(time_step, gui)
        self._grounds = lay_ground(client, world)
        build_walls(client, world)
        self._obstacles = BulletObstacles(client, world)
        for index, obstacle in enumerate(world.obstacles):
            self.put_obstacle((OF_WORLD, index), obstacle)
        super().__init__(client, robot, world, time_step, self._name)
        if self.iterations:
            client.setPhysicsEngineParameter(numSolverIterations=self.iterations)
        self.reset(Pose2D(0.0, 0.0, 0.0))

    @property
    def time(self) -> float:
        """Simulated time since the simulator was made [s]."""
        return self._steps * self.time_step

    def step(self, joint_positions: Array, joint_velocities: Array) -> None:
        """
        Advance by one time step.

        Parameters
        ----------
        joint_positions : ndarray, shape (12,)
            Wanted [rad], in the order of ``Robot.joint_names``.
        joint_velocities : ndarray, shape (12,)
            Wanted [rad/s].

        Raises
        ------
        ParameterError
            If one of them is not finite: that would stay in Bullet's world for ever.
        """
        self._drive(joint_positions, joint_velocities)
        self._bullet.stepSimulation()
        self._steps += 1

    def observe(self) -> Observation:
        """Return the robot's state."""
        return self._observe(self.time)

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """
        Put an obstacle, in the place of the one of that name if there is one.

        Parameters
        ----------
        name : hashable
            Of the obstacle; those of the world are ('room', 0), ('room', 1) and so on.
        obstacle : Obstacle
            It stands fast.
        """
        self._obstacles.put(name, obstacle)
        if self._scene is not None:
            self._scene.put_obstacle(name, obstacle)

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        self._obstacles.remove(name)
        if self._scene is not None:
            self._scene.remove_obstacle(name)

    def throw(self, ball: Ball | None) -> None:
        """Let a ball fly; see :meth:`ThrowingSimulator.throw`."""
        if self._ball is not None:
            self._bullet.removeBody(self._ball)
            self._ball = None
        if ball is not None:
            shape = self._bullet.createCollisionShape(self._bullet.GEOM_SPHERE, radius=ball.radius)
            self._ball = self._bullet.createMultiBody(
                ball.mass, shape, basePosition=ball.position.tolist()
            )
            self._bullet.resetBaseVelocity(self._ball, ball.velocity.tolist())

    @property
    def obstacles(self) -> dict[Hashable, Obstacle]:
        """Those that stand there now, besides the walls."""
        return self._obstacles.standing

    def put_goal_marker(self, pose: Pose2D) -> None:
        """Lay the goal's marker on the floor, or move it; nothing collides with it."""
        self._goal = pose
        if self._scene is not None:
            self._scene.put_goal_marker(pose)

    def prepare_pictures(self) -> None:
        """Make the world that pictures are taken of."""
        if self._scene is None:
            self._scene = self._make_scene()

    def render(self, view: Array, projection: Array, width: int, height: int) -> NDArray[np.uint8]:
        """Draw a picture, which physics do not notice; see `simulated_camera.Scene`."""
        self.prepare_pictures()
        assert self._scene is not None
        center, orientation = self._bullet.getBasePositionAndOrientation(self._body)
        states = self._bullet.getJointStates(self._body, self._joints)
        self._scene.put_robot(center, orientation, [state[0] for state in states])
        return self._scene.render(view, projection, width, height)

    def close(self) -> None:
        """Disconnect from the physics server."""
        if self._scene is not None:
            self._scene.close()
        if self._bullet.isConnected():
            self._bullet.disconnect()

    def _make_scene(self) -> BulletScene:
        """Make what pictures are taken of, a second world with the same things in it."""
        client = headless_client()
        body = load_body(client, self._robot, in_physics=False)
        scene = BulletScene(client, body, self._robot, self._world, self._appearance)
        for name, obstacle in self.obstacles.items():
            scene.put_obstacle(name, obstacle)
        if self._goal is not None:
            scene.put_goal_marker(self._goal)
        return scene

    def _name(self, body: int) -> str:
        if body == self._ball:
            return BALL
        return GROUND if body in self._grounds else OBSTACLE
