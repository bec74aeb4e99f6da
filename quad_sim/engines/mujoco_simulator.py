"""
The robot in MuJoCo's physics. Only the files ``mujoco_*`` import mujoco.
"""

from __future__ import annotations

import warnings
from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import MissingOptionalDependency
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.rotations import quaternion_from_matrix
from quad_sim.engines.joint_failure import FAILURES
from quad_sim.engines.mujoco_drives import MujocoDrives
from quad_sim.engines.simulator import (
    GRAVITY,
    TILT_OF_A_FALL,
    Contact,
    Observation,
    falls_of,
    foot_zone,
)
from quad_sim.world.appearance import Appearance
from quad_sim.world.standing import initial_place
from quad_sim.world.world import Obstacle, World

try:
    import mujoco

    from quad_sim.engines.mujoco_model import (
        GROUND,
        OBSTACLE,
        MujocoModel,
        quaternion_of_yaw,
    )
    from quad_sim.engines.mujoco_scene import MujocoScene
    from quad_sim.engines.mujoco_window import MujocoWindow
except ImportError as error:
    raise MissingOptionalDependency('mujoco', "pip install 'mujoco>=3.3,<4'") from error

Array = NDArray[np.float64]

_LEAST_UPRIGHT = float(np.cos(TILT_OF_A_FALL))
"""Cosine of the tilt of a body that has fallen."""

_WINDOW_DISTANCE = 8.0
"""Distance from which the window looks at the robot, in radii of its footprint."""


def _warn(text: str) -> None:
    warnings.warn(f'MuJoCo: {text}', RuntimeWarning, stacklevel=2)


# Otherwise MuJoCo writes a file into the folder that the process runs in.
mujoco.set_mju_user_warning(_warn)


class MujocoSimulator:
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
        self.time_step = time_step
        self.failures: tuple[str, ...] = FAILURES
        self._robot = robot
        self._world = world
        self._steps = 0
        self.drives = MujocoDrives(robot, time_step)
        """Motors, and the anchors of contacts."""
        self._last_velocity = np.zeros(3)
        self._last_efforts: Array = np.zeros(12)
        self._has_efforts = False
        self._feet = robot.part_names.feet
        self._foot_zone = foot_zone(robot)
        self._falls = falls_of(robot)
        self._appearance = Appearance() if appearance is None else appearance
        self._parts = MujocoModel(robot, world, time_step, self._appearance)
        self._scene: MujocoScene | None = None
        self._goal: Pose2D | None = None
        self._model, self._data = self._parts.compile()
        self._find_places()
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
        base, rotation = initial_place(self._robot, self._world.terrain, pose)
        if rotation is None:
            w, x, y, z = quaternion_of_yaw(pose.yaw)
        else:
            x, y, z, w = quaternion_from_matrix(rotation)
        self.drives.reset()
        mujoco.mj_resetData(self._model, self._data)
        self._last_velocity[:] = 0.0
        self._has_efforts = False
        self._last_efforts[:] = 0.0
        self.place(base, (x, y, z, w), self._robot.initial_joint_angles.reshape(-1))

    def place(
        self, position: Array, orientation: Sequence[float] | Array, joint_angles: Array
    ) -> None:
        """Put the robot somewhere, at rest; see :meth:`VisibleSimulator.place`."""
        x, y, z, w = orientation
        self._data.qpos[:3], self._data.qpos[3:7] = position, (w, x, y, z)
        self._data.qpos[self._angles] = joint_angles
        self._data.qvel[:] = 0.0
        mujoco.mj_forward(self._model, self._data)

    def fail_joint(self, joint: int, kind: str) -> None:
        """Let a joint fail from now on; see :meth:`Simulator.fail_joint`."""
        self.drives.fail_joint(joint, kind)

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
        self.drives.aim(joint_positions, joint_velocities)
        model, data = self._model, self._data
        self._last_velocity[:] = self._base_velocity
        mujoco.mj_step1(model, data)
        self.drives.pull()
        mujoco.mj_step2(model, data)
        self._has_efforts = True
        self._steps += 1
        if self._window is not None:
            self._window.show(self._model, data)

    def observe(self) -> Observation:
        """Return the robot's state."""
        positions, velocities = self._data.qpos.copy(), self._data.qvel.copy()
        w, x, y, z = positions[3:7].tolist()
        orientation = np.array([x, y, z, w])
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, positions[3:7])
        to_base = rotation.reshape(3, 3).T
        velocity = velocities[:3]
        force = velocity - self._last_velocity
        force /= self.time_step
        force[2] += GRAVITY
        contacts = self._contacts()
        # The cosine of the body's tilt is in the last place of its matrix.
        has_tilted = float(rotation[8]) < _LEAST_UPRIGHT
        return Observation(
            time=self.time,
            position=positions[:3],
            orientation=orientation,
            linear_velocity_base_in_base=to_base.dot(velocity),
            angular_velocity_base_in_base=velocities[3:6],
            specific_force_in_base=to_base.dot(force),
            joint_positions=positions[self._angles],
            joint_velocities=velocities[self._speeds],
            joint_efforts=self._joint_efforts(),
            contacts=contacts,
            has_fallen=has_tilted or bool(contacts and self._falls.intersection(contacts)),
        )

    def _joint_efforts(self) -> Array:
        """Return the torques of the motors in the last step, shape (12,) [N m]."""
        if not self._has_efforts:
            return self._last_efforts.copy()
        return self.drives.efforts()

    def foot_forces(self) -> Array:
        """
        Return what presses against each foot, as no robot can measure it.

        Returns
        -------
        ndarray, shape (4,)
            Normal forces of the ground and of obstacles in the last step, in the order of
            ``LEGS``; 0 in the air [N].
        """
        forces = dict.fromkeys(self._feet, 0.0)
        force = np.zeros(6)
        for index in range(self._data.ncon):
            a, b = self._data.contact[index].geom.tolist()
            names = [self._names[a], self._names[b]]
            foot = next((name for name in names if name in forces), None)
            if foot is None and self._foot_of and self._stands_as_foot(index, a, b):
                leg = b if self._is_ground[a] else a
                foot = self._model.body(self._foot_of[int(self._model.geom_bodyid[leg])]).name
            if foot is not None and any(name in (GROUND, OBSTACLE) for name in names):
                mujoco.mj_contactForce(self._model, self._data, index, force)
                forces[foot] += float(force[0])
        return np.array(list(forces.values()))

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one; it stands fast."""
        self._parts.put_obstacle(name, obstacle)
        self._compile_again()

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        if name in self._parts.obstacles:
            self._parts.remove_obstacle(name)
            self._compile_again()

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
        # The new data have no forces until the next step.
        self._last_efforts, self._has_efforts = self._joint_efforts(), False
        self._model, self._data = self._parts.compile_again(self._model, self._data)
        self._find_places()

    def _find_places(self) -> None:
        """Look up where joints, motors and geometries are in MuJoCo's arrays."""
        model = self._model
        joints = [model.joint(name).id for name in self._robot.joint_names]
        angles, speeds = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
        if list(np.diff(angles)) != [1] * 11 or list(np.diff(speeds)) != [1] * 11:
            raise RuntimeError("MuJoCo's joints are not in the order of the robot's")
        self._angles = slice(int(angles[0]), int(angles[0]) + 12)
        self._speeds = slice(int(speeds[0]), int(speeds[0]) + 12)
        # It shows MuJoCo's own numbers, whatever they become.
        self._base_velocity = self._data.qvel[:3]
        self.drives.bind(model, self._data, self._angles, self._speeds)
        self._names = [self._name_of(geom) for geom in range(model.ngeom)]
        self._is_foot = [name in self._feet for name in self._names]
        self._is_ground = [name == GROUND for name in self._names]
        feet = [model.body(name).id for name in self._feet]
        jointed = set(model.jnt_bodyid.tolist())
        self._foot_of = {int(model.body_parentid[f]): f for f in feet if f not in jointed}

    def _name_of(self, geom: int) -> str:
        """Name what a geometry belongs to: a link, the ground or an obstacle."""
        body = int(self._model.geom_bodyid[geom])
        if body:
            return str(self._model.body(body).name)
        return str(self._model.geom(geom).name).partition(' ')[0]

    def _contacts(self) -> tuple[Contact, ...]:
        data = self._data
        if not data.ncon:
            return ()
        is_foot, is_ground = self._is_foot, self._is_ground
        found = None
        for index, (a, b) in enumerate(data.contact.geom.tolist()):
            if (is_foot[a] and is_ground[b]) or (is_foot[b] and is_ground[a]):
                continue
            if self._foot_of and self._stands_as_foot(index, a, b):
                continue
            if data.contact.dist[index] <= 0.0:
                found = found or set()
                found.add(self._contact(a, b))
        return tuple(sorted(found, key=str)) if found else ()

    def _stands_as_foot(self, index: int, a: int, b: int) -> bool:
        """Whether a contact is that of a calf with the ground, where its foot is."""
        leg, other = (b, a) if self._is_ground[a] else (a, b)
        foot = self._foot_of.get(int(self._model.geom_bodyid[leg]))
        if foot is None or not self._is_ground[other]:
            return False
        arm = self._data.contact.pos[index] - self._data.xpos[foot]
        return float(np.linalg.norm(arm)) < self._foot_zone

    def _contact(self, a: int, b: int) -> Contact:
        """Name two geometries that touch, the robot's first."""
        names = (self._names[a], self._names[b])
        return Contact(*sorted(names, key=lambda name: (name in (GROUND, OBSTACLE), name)))
