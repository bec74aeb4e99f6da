"""
The robot in MuJoCo's physics. Only the files ``mujoco_*`` import mujoco.
"""

from __future__ import annotations

import warnings
from collections.abc import Hashable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import MissingOptionalDependency
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.engines.mujoco_drives import MujocoDrives
from quad_sim.engines.simulator import BALL, Ball, Observation
from quad_sim.world.appearance import Appearance
from quad_sim.world.world import Obstacle, World

try:
    import mujoco

    from quad_sim.engines.mujoco_model import MujocoModel
    from quad_sim.engines.mujoco_robot import MujocoRobot, robot_spec
    from quad_sim.engines.mujoco_scene import MujocoScene
    from quad_sim.engines.mujoco_window import MujocoWindow
except ImportError as error:
    raise MissingOptionalDependency('mujoco', "pip install 'mujoco>=3.3,<4'") from error

Array = NDArray[np.float64]

_WINDOW_DISTANCE = 8.0
"""Distance from which the window looks at the robot, in radii of its footprint."""


def _warn(text: str) -> None:
    warnings.warn(f'MuJoCo: {text}', RuntimeWarning, stacklevel=2)


# Otherwise MuJoCo writes a file into the folder that the process runs in.
mujoco.set_mju_user_warning(_warn)


class MujocoSimulator(MujocoRobot):
    """
    A rigid-body simulation of one robot in one world.

    A motor is dry friction that drives its joint toward a velocity with its largest torque at
    most: exact torque limits at any time step, and stiff where the torque suffices. What stands
    is anchored, and does not creep. See :class:`MujocoDrives`.

    Parameters
    ----------
    robot : Robot
        The robot.
    world : World
        Ground and obstacles.
    time_step : float
        Fixed step [s].
    gui : bool
        Show MuJoCo's own window.
    appearance : Appearance, optional
        Of the world in pictures.

    Raises
    ------
    MissingOptionalDependency
        On import of this module, if MuJoCo is not installed.
    """

    def __init__(
        self,
        robot: Robot,
        world: World,
        time_step: float = 0.005,
        gui: bool = False,
        appearance: Appearance | None = None,
    ) -> None:
        super().__init__(robot, world, time_step)
        self._steps = 0
        self.drives = MujocoDrives([self.motors], time_step)
        """Motors, and the anchors of contacts."""
        self._appearance = Appearance() if appearance is None else appearance
        spec = robot_spec(robot, time_step, self._appearance)
        self._parts = MujocoModel(spec, world, time_step, self._appearance)
        self._scene: MujocoScene | None = None
        self._goal: Pose2D | None = None
        self._take(*self._parts.compile())
        self.reset(Pose2D(0.0, 0.0, 0.0))
        self._window: MujocoWindow | None = None
        if gui:
            distance = _WINDOW_DISTANCE * robot.footprint_radius
            self._window = MujocoWindow(self._model, self._data, distance)

    @property
    def time(self) -> float:
        """Simulated time since the simulator was made [s]."""
        return self._steps * self.time_step

    def reset(self, pose: Pose2D) -> None:
        """Stand the robot at a pose; see :meth:`Simulator.reset`."""
        self.motors.reset()
        self.drives.let_go()
        mujoco.mj_resetData(self._model, self._data)
        self._stand(pose)

    def step(self, joint_positions: Array, joint_velocities: Array) -> None:
        """
        Advance by one time step.

        Parameters
        ----------
        joint_positions : ndarray, shape (12,)
            Wanted at the end of the step [rad], in the order of ``Robot.joint_names``.
        joint_velocities : ndarray, shape (12,)
            Wanted [rad/s].

        Raises
        ------
        ParameterError
            If one of them is not finite.
        """
        self._drive(joint_positions, joint_velocities)
        model, data = self._model, self._data
        mujoco.mj_step1(model, data)
        self.drives.pull()
        mujoco.mj_step2(model, data)
        self._steps += 1
        if self._window is not None:
            self._window.show(self._model, data)

    def observe(self) -> Observation:
        """Return the robot's state."""
        return self._observe(self.time)

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one; it stands fast."""
        self._parts.put_obstacle(name, obstacle)
        self._compile_again()

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        if name in self._parts.obstacles:
            self._parts.remove_obstacle(name)
            self._compile_again()

    def throw(self, ball: Ball | None) -> None:
        """Let a ball fly; see :meth:`ThrowingSimulator.throw`."""
        self._parts.put_ball(ball)
        self._compile_again()
        if ball is not None:
            joint = int(self._model.body(BALL).jntadr[0])
            place, motion = self._model.jnt_qposadr[joint], self._model.jnt_dofadr[joint]
            self._data.qpos[place : place + 7] = (*ball.position, 1.0, 0.0, 0.0, 0.0)
            self._data.qvel[motion : motion + 6] = (*ball.velocity, 0.0, 0.0, 0.0)

    @property
    def obstacles(self) -> dict[Hashable, Obstacle]:
        """Those that stand there now, besides the walls."""
        return self._parts.obstacles

    def put_goal_marker(self, pose: Pose2D) -> None:
        """Lay the goal's marker on the floor, or move it; nothing collides with it."""
        self._goal = pose

    def prepare_pictures(self) -> None:
        """Make ready what draws pictures; NoRenderer where nothing does."""
        if self._scene is None:
            self._scene = MujocoScene(self._robot, self._world, self._appearance)

    def render(self, view: Array, projection: Array, width: int, height: int) -> NDArray[np.uint8]:
        """Draw a picture, which physics do not notice; see `simulated_camera.Scene`."""
        self.prepare_pictures()
        assert self._scene is not None
        size = (width, height)
        return self._scene.render(self._model, self._data.qpos, self._goal, view, projection, size)

    def close(self) -> None:
        """Close the window, release what pictures need; memory goes with the simulator."""
        if self._window is not None:
            self._window.close()
        if self._scene is not None:
            self._scene.close()

    def _compile_again(self) -> None:
        self._keep_efforts()
        self._take(*self._parts.compile_again(self._model, self._data))

    def _take(self, model: Any, data: Any) -> None:
        """Go on with a model that was compiled, or compiled again."""
        self._bind(model, data)
        self.drives.bind(model, data)
