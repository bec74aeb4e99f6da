"""
The robot in MuJoCo's physics. With ``mujoco_model`` the only files that import mujoco.
"""

from __future__ import annotations

import warnings
from collections.abc import Hashable

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import MissingOptionalDependency
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.rotations import quaternion_from_matrix, tilt_from_quaternion
from quad_sim.engines.joint_failure import FAILURES, FRICTION_SHARE
from quad_sim.engines.simulator import (
    FALLS,
    GRAVITY,
    TILT_OF_A_FALL,
    Contact,
    Observation,
    check_commands,
)
from quad_sim.world.appearance import Appearance
from quad_sim.world.standing import standing_on
from quad_sim.world.world import Obstacle, World

try:
    import mujoco

    from quad_sim.engines.mujoco_model import (
        GROUND,
        OBSTACLE,
        MujocoModel,
        quaternion_of_yaw,
    )
except ImportError as error:
    raise MissingOptionalDependency('mujoco', "pip install 'mujoco>=3.3,<4'") from error

Array = NDArray[np.float64]

_POSITION_GAIN = 0.3
"""Part of a joint's position error that its motor takes back in one step, as Bullet's does."""


_FAR = 10.0
"""Position error beyond which a motor does not pull more [rad]."""

_TOO_FAST = 10.0
"""Largest velocity that a motor drives toward, over that of the robot's data."""


def _warn(text: str) -> None:
    warnings.warn(f'MuJoCo: {text}', RuntimeWarning, stacklevel=2)


# Otherwise MuJoCo writes a file into the folder that the process runs in.
mujoco.set_mju_user_warning(_warn)


class MujocoSimulator:
    """
    A rigid-body simulation of one robot in one world.

    A motor is dry friction that drives its joint toward a velocity with its largest torque at
    most: exact torque limits at any time step, and stiff where the torque suffices. Between the
    two halves of MuJoCo's step the friction's reference is set to the velocity that is wanted.

    Parameters
    ----------
    robot : Robot
        The robot.
    world : World
        Ground and obstacles.
    time_step : float
        Fixed step [s].
    gui : bool
        Not used: there is no window.
    appearance : Appearance, optional
        Not used: there are no pictures.

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
        self._efforts_limit = robot.effort.reshape(-1)
        self._fastest = _TOO_FAST * np.broadcast_to(robot.velocity, (4, 3)).reshape(-1)
        self._feet = [f'{leg}_foot' for leg in LEGS]
        self._parts = MujocoModel(robot, world, time_step)
        self._free: list[int] = []
        self._stuck: dict[int, float] = {}
        self._model, self._data = self._parts.compile()
        self._find_places()
        self.reset(Pose2D(0.0, 0.0, 0.0))

    @property
    def time(self) -> float:
        """Simulated time since the simulator was made [s]."""
        return self._steps * self.time_step

    def reset(self, pose: Pose2D) -> None:
        """
        Stand the robot at a pose, in its initial posture, at rest, with all joints sound.

        Parameters
        ----------
        pose : Pose2D
            Of base_link, in the world. On uneven ground the body is as parallel to the ground and
            as near to it as no foot in the ground allows.
        """
        base = np.array([pose.x, pose.y, self._robot.standing_height])
        orientation = quaternion_of_yaw(pose.yaw)
        if self._world.terrain is not None:
            base, rotation = standing_on(self._robot, self._world.terrain, pose)
            x, y, z, w = quaternion_from_matrix(rotation)
            orientation = [w, x, y, z]
        self._free, self._stuck = [], {}
        self._model.dof_frictionloss[self._speeds] = self._efforts_limit
        mujoco.mj_resetData(self._model, self._data)
        self._data.qpos[:3], self._data.qpos[3:7] = base, orientation
        self._data.qpos[self._angles] = self._robot.initial_joint_angles.reshape(-1)
        self._last_velocity = np.zeros(3)
        self._efforts = np.zeros(12)
        mujoco.mj_forward(self._model, self._data)

    def fail_joint(self, joint: int, kind: str) -> None:
        """
        Let a joint fail from now on, until :meth:`reset`.

        Parameters
        ----------
        joint : int
            Its place in ``Robot.joint_names``.
        kind : str
            One of :data:`quad_sim.engines.joint_failure.FAILURES`.
        """
        if kind == 'free':
            self._free.append(joint)
            self._let_go()
        else:
            self._stuck[joint] = float(self._data.qpos[self._angles][joint])

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
        check_commands(joint_positions, joint_velocities)
        data = self._data
        # No motor is asked for more than it could ever give: a command that is far off must not
        # make MuJoCo unstable, which would put the robot back to where it began.
        off = np.clip(joint_positions - data.qpos[self._angles], -_FAR, _FAR)
        wanted = joint_velocities + (_POSITION_GAIN / self.time_step) * off
        wanted = np.clip(wanted, -self._fastest, self._fastest)
        for joint, angle in self._stuck.items():
            missing = angle - float(data.qpos[self._angles][joint])
            wanted[joint] = _POSITION_GAIN / self.time_step * missing
        wanted[self._free] = 0.0
        self._last_velocity = data.qvel[:3].copy()
        mujoco.mj_step1(self._model, data)
        # Friction is toward the velocity that is wanted, not toward rest.
        data.efc_aref[self._motors] += data.efc_KBIP[self._motors, 1] * wanted
        mujoco.mj_step2(self._model, data)
        self._efforts = data.efc_force[self._motors].copy()
        self._steps += 1

    def observe(self) -> Observation:
        """Return the robot's state."""
        data = self._data
        w, x, y, z = data.qpos[3:7].tolist()
        orientation = np.array([x, y, z, w])
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, data.qpos[3:7])
        to_base = rotation.reshape(3, 3).T
        velocity = data.qvel[:3]
        acceleration = (velocity - self._last_velocity) / self.time_step
        contacts = self._contacts()
        efforts = self._efforts.copy()
        # What is left there is the gear's friction.
        efforts[self._free] = 0.0
        tilted = tilt_from_quaternion(orientation) > TILT_OF_A_FALL
        return Observation(
            time=self.time,
            position=data.qpos[:3].copy(),
            orientation=orientation,
            linear_velocity_base_in_base=to_base @ velocity,
            angular_velocity_base_in_base=data.qvel[3:6].copy(),
            specific_force_in_base=to_base @ (acceleration + (0.0, 0.0, GRAVITY)),
            joint_positions=data.qpos[self._angles].copy(),
            joint_velocities=data.qvel[self._speeds].copy(),
            joint_efforts=efforts,
            contacts=contacts,
            has_fallen=bool(tilted or FALLS.intersection(contacts)),
        )

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
            names = [self._names[geom] for geom in self._data.contact[index].geom]
            foot = next((name for name in names if name in forces), None)
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

    def close(self) -> None:
        """Release nothing: MuJoCo's memory goes with the simulator."""

    def _compile_again(self) -> None:
        self._model, self._data = self._parts.compile_again(self._model, self._data)
        self._find_places()
        self._model.dof_frictionloss[self._speeds] = self._efforts_limit
        self._let_go()

    def _let_go(self) -> None:
        """Leave the free joints the friction of their gears alone."""
        if self._free:
            places = self._speeds.start + np.array(self._free)
            self._model.dof_frictionloss[places] = FRICTION_SHARE * self._efforts_limit[self._free]

    def _find_places(self) -> None:
        """Look up where joints, motors and geometries are in MuJoCo's arrays."""
        model = self._model
        joints = [model.joint(name).id for name in self._robot.joint_names]
        angles, speeds = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
        if list(np.diff(angles)) != [1] * 11 or list(np.diff(speeds)) != [1] * 11:
            raise RuntimeError("MuJoCo's joints are not in the order of the robot's")
        self._angles = slice(int(angles[0]), int(angles[0]) + 12)
        self._speeds = slice(int(speeds[0]), int(speeds[0]) + 12)
        if model.neq:
            raise RuntimeError("the motors are not the first of MuJoCo's constraints")
        # Rows of dry friction come first, one for each joint.
        self._motors = slice(0, 12)
        self._names = [self._name_of(geom) for geom in range(model.ngeom)]
        feet = np.array([name in self._feet for name in self._names])
        ground = np.array([name == GROUND for name in self._names])
        self._is_foot, self._is_ground = feet, ground

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
        geoms = data.contact.geom
        a, b = geoms[:, 0], geoms[:, 1]
        allowed = (self._is_foot[a] & self._is_ground[b]) | (self._is_foot[b] & self._is_ground[a])
        found = set()
        for index in np.flatnonzero(~allowed & (data.contact.dist <= 0.0)):
            names = sorted(
                (self._names[geom] for geom in geoms[index]),
                key=lambda name: (name in (GROUND, OBSTACLE), name),
            )
            found.add(Contact(*names))
        return tuple(sorted(found, key=str))
