"""
Several robots in MuJoCo's physics: one model with all of them.

A robot that comes or goes makes another model; the state of the others is carried over.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import MissingOptionalDependency
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.engines.mujoco_drives import MujocoDrives
from quad_sim.engines.simulator import Simulator
from quad_sim.fleet.world_handle import WorldHandle
from quad_sim.world.appearance import Appearance
from quad_sim.world.world import Obstacle, World

try:
    import mujoco

    from quad_sim.engines.mujoco_model import MujocoModel
    from quad_sim.engines.mujoco_robot import MujocoRobot, robot_spec, robots_spec
except ImportError as error:
    raise MissingOptionalDependency('mujoco', "pip install 'mujoco>=3.3,<4'") from error

Array = NDArray[np.float64]


class _Handle(MujocoRobot, WorldHandle):
    """A robot whose commands wait for the world's step."""

    def __init__(self, shared: MujocoWorld, robot: Robot, name: str) -> None:
        MujocoRobot.__init__(self, robot, shared.world, shared.time_step, name)
        WorldHandle.__init__(self, shared)
        self.robot = robot
        self._owner = shared

    def bind(self, model: Any, data: Any, number: int) -> None:
        """Go on in a model, as the robot of a number."""
        self._bind(model, data, number)

    def keep_efforts(self) -> None:
        """Remember the torques of the last step: data of another model have none."""
        self._keep_efforts()

    def reset(self, pose: Pose2D) -> None:
        """Stand the robot at a pose; see :meth:`Simulator.reset`."""
        self.motors.reset()
        self._owner.drives.let_go()
        self.push(np.zeros(3))
        self._stand(pose)

    @property
    def state(self) -> tuple[Array, ...]:
        """Place, motion and solver's memory, to be carried over."""
        return tuple(part.copy() for part in self._state())

    def take_state(self, state: tuple[Array, ...]) -> None:
        """Go on from what :attr:`state` was."""
        for part, value in zip(self._state(), state):
            part[:] = value

    def _state(self) -> tuple[Array, ...]:
        data, speeds = self._data, self._speeds
        first = speeds.start - 6
        return (
            self._base_place,
            self._base_motion,
            data.qpos[self._angles],
            data.qvel[speeds],
            data.qacc_warmstart[first : speeds.stop],
        )

    def close(self) -> None:
        """Do nothing: the world is released as a whole."""


class MujocoWorld:
    """
    A model of MuJoCo with any number of robots; see :class:`~.shared_world.SharedWorld`.

    Parameters
    ----------
    world : World
        Ground and obstacles.
    time_step : float
        Fixed step [s].
    """

    def __init__(self, world: World, time_step: float) -> None:
        self.time_step = time_step
        self.world = world
        """Ground and obstacles at first."""
        self._appearance = Appearance()
        self._steps = 0
        self._robots: dict[str, _Handle] = {}
        self._build()
        self._take(*self._parts.compile())

    @property
    def time(self) -> float:
        """Simulated time since the world was made [s]."""
        return self._steps * self.time_step

    def spawn(self, robots: Mapping[str, tuple[Robot, Pose2D]]) -> dict[str, Simulator]:
        """Put robots into the world; see :meth:`SharedWorld.spawn`."""
        states = self._states()
        made = {name: _Handle(self, robot, name) for name, (robot, _) in robots.items()}
        self._robots.update(made)
        self._rebuild(states)
        for name, (_, pose) in robots.items():
            made[name].reset(pose)
        return dict(made)

    def remove(self, name: str) -> None:
        """Take a robot out of the world; the others go on."""
        states = self._states()
        del self._robots[name]
        self._rebuild(states)

    def step(self) -> None:
        """Advance by one time step."""
        mujoco.mj_step1(self._model, self._data)
        self.drives.pull()
        mujoco.mj_step2(self._model, self._data)
        self._steps += 1

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Those that stand there now, besides the walls."""
        return self._parts.obstacles

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one."""
        self._parts.put_obstacle(name, obstacle)
        self._compile_again()

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        if name in self._parts.obstacles:
            self._parts.remove_obstacle(name)
            self._compile_again()

    def close(self) -> None:
        """Do nothing: memory goes with the world."""

    def _states(self) -> dict[str, tuple[Array, ...]]:
        """Return what is to be carried over to another model."""
        for robot in self._robots.values():
            robot.keep_efforts()
        return {name: robot.state for name, robot in self._robots.items()}

    def _rebuild(self, states: Mapping[str, tuple[Array, ...]]) -> None:
        """Make the model of the robots that there are now, with obstacles and states kept."""
        obstacles = dict(self._parts.obstacles)
        self._build()
        for name in set(self._parts.obstacles) - set(obstacles):
            self._parts.remove_obstacle(name)
        for name, obstacle in obstacles.items():
            if self._parts.obstacles.get(name) != obstacle:
                self._parts.put_obstacle(name, obstacle)
        self._take(*self._parts.compile())
        for name, state in states.items():
            if name in self._robots:
                self._robots[name].take_state(state)

    def _build(self) -> None:
        """Describe the world with the robots that there are now, to be compiled."""
        look, robots = self._appearance, self._robots
        specs = {
            name: robot_spec(handle.robot, self.time_step, look) for name, handle in robots.items()
        }
        spec = robots_spec(specs)
        self._parts = MujocoModel(spec, self.world, self.time_step, look, robots=len(specs))
        motors = [handle.motors for handle in robots.values()]
        self.drives = MujocoDrives(motors, self.time_step)
        """Motors, and the anchors of contacts."""

    def _compile_again(self) -> None:
        for robot in self._robots.values():
            robot.keep_efforts()
        self._take(*self._parts.compile_again(self._model, self._data))

    def _take(self, model: Any, data: Any) -> None:
        """Go on with a model that was compiled, or compiled again."""
        self._model, self._data = model, data
        for number, robot in enumerate(self._robots.values()):
            robot.bind(model, data, number)
        self.drives.bind(model, data)
