"""
One robot among those of a model that MuJoCo simulates: how it is put, driven and observed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from quad_common.errors import RobotNotLoaded
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot.urdf import urdf_from_robot
from quad_common.rotations import quaternion_from_matrix
from quad_sim.engines.mujoco_drives import MujocoMotors
from quad_sim.engines.mujoco_model import make_solid, quaternion_of_yaw, rgba
from quad_sim.engines.simulator import (
    BALL,
    FAILURES,
    GROUND,
    OBSTACLE,
    TILT_OF_A_FALL,
    Accelerometer,
    Contact,
    Observation,
    falls_of,
    foot_zone,
    robot_contact,
)
from quad_sim.world.appearance import Appearance
from quad_sim.world.standing import initial_place
from quad_sim.world.world import World

Array = NDArray[np.float64]

_LEAST_UPRIGHT = float(np.cos(TILT_OF_A_FALL))
"""Cosine of the tilt of a body that has fallen."""

_MOTOR_TIME = 2.75
"""Time constant of motors, in time steps: with 2, which is the least that is stable, TITAN-VIII's
trot advances less by 1.5 %."""

_MOTOR_IMPEDANCE = (0.9999, 0.9999, 0.001, 0.5, 2.0)
"""Impedance of the motors: the stiffer they are, the less a trotting body tilts."""

_HIDDEN = 3
"""Group of geometries that MuJoCo does not show."""


class MujocoRobot:
    """
    What a simulator offers of one robot, but for time and the world.

    Parameters
    ----------
    robot : Robot
        The robot.
    world : World
        Ground on which it is put.
    time_step : float
        Fixed step [s].
    name : str
        Name of the robot among several; empty for one that is alone.
    """

    def __init__(self, robot: Robot, world: World, time_step: float, name: str = '') -> None:
        self.time_step = time_step
        self.failures: tuple[str, ...] = FAILURES
        self._robot = robot
        self._world = world
        self._prefix = prefix_of(name)
        self.motors = MujocoMotors(robot, time_step)
        """Motors of its joints."""
        self._accelerometer = Accelerometer(time_step)
        self._last_efforts: Array = np.zeros(12)
        self._has_efforts = False
        self._feet = robot.part_names.feet
        self._foot_zone = foot_zone(robot)
        self._falls = falls_of(robot)
        self._force: Array | None = None

    def _bind(self, model: Any, data: Any, number: int = 0) -> None:
        """Look up where joints, motors and geometries are in MuJoCo's arrays."""
        self._model, self._data = model, data
        joints = [model.joint(self._prefix + name).id for name in self._robot.joint_names]
        angles, speeds = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
        if list(np.diff(angles)) != [1] * 11 or list(np.diff(speeds)) != [1] * 11:
            raise RuntimeError("MuJoCo's joints are not in the order of the robot's")
        self._angles = slice(int(angles[0]), int(angles[0]) + 12)
        self._speeds = slice(int(speeds[0]), int(speeds[0]) + 12)
        self._base = int(model.body_rootid[model.jnt_bodyid[joints[0]]])
        root = int(model.body_jntadr[self._base])
        place, motion = int(model.jnt_qposadr[root]), int(model.jnt_dofadr[root])
        # They show MuJoCo's own numbers, whatever they become.
        self._base_place = data.qpos[place : place + 7]
        self._base_motion = data.qvel[motion : motion + 6]
        self._base_velocity = data.qvel[motion : motion + 3]
        self.motors.bind(model, data, self._angles, self._speeds, number)
        self._is_own = (model.body_rootid[model.geom_bodyid] == self._base).tolist()
        self._names = [self._name_of(geom) for geom in range(model.ngeom)]
        self._is_foot = [own and name in self._feet for own, name in zip(self._is_own, self._names)]
        self._is_ground = [name == GROUND for name in self._names]
        feet = [model.body(self._prefix + name).id for name in self._feet]
        jointed = set(model.jnt_bodyid.tolist())
        self._foot_of = {int(model.body_parentid[f]): f for f in feet if f not in jointed}

    def _name_of(self, geom: int) -> str:
        """Name what a geometry belongs to: a link, another robot, the ground or an obstacle."""
        body = int(self._model.geom_bodyid[geom])
        if not body:
            return str(self._model.geom(geom).name).partition(' ')[0]
        name = str(self._model.body(body).name)
        if self._is_own[geom]:
            return name.removeprefix(self._prefix)
        if name == BALL:
            return BALL
        return robot_contact(name.partition('/')[0])

    def _stand(self, pose: Pose2D) -> None:
        """Put the robot to a pose in its initial posture, at rest, with all joints sound."""
        base, rotation = initial_place(self._robot, self._world.terrain, pose)
        if rotation is None:
            w, x, y, z = quaternion_of_yaw(pose.yaw)
        else:
            x, y, z, w = quaternion_from_matrix(rotation)
        self._force = None
        self._accelerometer.reset()
        self._has_efforts = False
        self._last_efforts[:] = 0.0
        self.place(base, (x, y, z, w), self._robot.initial_joint_angles.reshape(-1))

    def place(
        self, position: Array, orientation: Sequence[float] | Array, joint_angles: Array
    ) -> None:
        """Put the robot somewhere, at rest; see :meth:`VisibleSimulator.place`."""
        x, y, z, w = orientation
        self._base_place[:3], self._base_place[3:] = position, (w, x, y, z)
        self._data.qpos[self._angles] = joint_angles
        self._base_motion[:] = 0.0
        self._data.qvel[self._speeds] = 0.0
        mujoco.mj_forward(self._model, self._data)

    def fail_joint(self, joint: int, kind: str) -> None:
        """Let a joint fail from now on; see :meth:`Simulator.fail_joint`."""
        self.motors.fail_joint(joint, kind)

    def _drive(self, joint_positions: Array, joint_velocities: Array) -> None:
        """Have the robot driven in the next step; see :meth:`Simulator.step`."""
        self.motors.aim(joint_positions, joint_velocities)
        self._accelerometer.note(self._base_velocity.copy())
        if self._force is not None:
            self._data.xfrc_applied[self._base, :3] = self._force
        self._has_efforts = True

    def _observe(self, time: float) -> Observation:
        """Return the robot's state at a time [s]."""
        place, motion = self._base_place.copy(), self._base_motion.copy()
        w, x, y, z = place[3:].tolist()
        orientation = np.array([x, y, z, w])
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, place[3:])
        to_base = rotation.reshape(3, 3).T
        velocity = motion[:3]
        contacts = self._contacts()
        # The cosine of the body's tilt is in the last place of its matrix.
        has_tilted = float(rotation[8]) < _LEAST_UPRIGHT
        return Observation(
            time=time,
            position=place[:3],
            orientation=orientation,
            linear_velocity_base_in_base=to_base.dot(velocity),
            angular_velocity_base_in_base=motion[3:],
            specific_force_in_base=to_base.dot(self._accelerometer.specific_force(velocity)),
            joint_positions=self._data.qpos[self._angles].copy(),
            joint_velocities=self._data.qvel[self._speeds].copy(),
            joint_efforts=self._joint_efforts(),
            contacts=contacts,
            has_fallen=has_tilted or bool(contacts and self._falls.intersection(contacts)),
        )

    def _joint_efforts(self) -> Array:
        """Return the torques of the motors in the last step, shape (12,) [N m]."""
        if not self._has_efforts:
            return self._last_efforts.copy()
        return self.motors.efforts()

    def _keep_efforts(self) -> None:
        """Remember the torques of the last step: data of another model have none until the next."""
        self._last_efforts, self._has_efforts = self._joint_efforts(), False

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

    def push(self, force: Array) -> None:
        """Push against the body from now on; see :meth:`SolidSimulator.push`."""
        self._force = force.copy() if np.any(force) else None
        self._data.xfrc_applied[self._base, :3] = 0.0

    def _contacts(self) -> tuple[Contact, ...]:
        data = self._data
        if not data.ncon:
            return ()
        is_foot, is_ground, is_own = self._is_foot, self._is_ground, self._is_own
        found = None
        for index, (a, b) in enumerate(data.contact.geom.tolist()):
            if (is_foot[a] and is_ground[b]) or (is_foot[b] and is_ground[a]):
                continue
            if not (is_own[a] or is_own[b]):
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
        parts = sorted((not self._is_own[geom], self._names[geom]) for geom in (a, b))
        return Contact(parts[0][1], parts[1][1])


def robot_spec(robot: Robot, time_step: float, appearance: Appearance) -> Any:
    """
    Describe a robot for MuJoCo: its motors are joints with dry friction, see `MujocoSimulator`.

    Parameters
    ----------
    robot : Robot
        The robot.
    time_step : float
        Fixed step [s].
    appearance : Appearance
        Colors.

    Returns
    -------
    MjSpec
        The robot alone, free to move.

    Raises
    ------
    RobotNotLoaded
        If MuJoCo does not take its description.
    """
    urdf = urdf_from_robot(robot)
    try:
        spec: Any = mujoco.MjSpec.from_string(_seen(urdf) if robot.own_urdf else urdf)
        _complete(spec, robot, time_step, appearance)
    except ValueError as error:
        raise RobotNotLoaded(robot.name, 'MuJoCo', str(error)) from error
    return spec


def _complete(spec: Any, robot: Robot, time_step: float, appearance: Appearance) -> None:
    """Let a robot move, with its motors and colors; what MuJoCo cannot compile is a ValueError."""
    spec.compiler.fusestatic = False
    spec.compiler.discardvisual = False
    spec.worldbody.first_body().add_freejoint()
    for body in spec.bodies:
        _dress(body, None if robot.own_urdf else rgba(appearance.robot_color), time_step)
    _set_motors(spec, robot, time_step)
    if robot.own_urdf:
        _part_overlapping_links(spec, robot)


def robots_spec(specs: Mapping[str, Any]) -> Any:
    """
    Put robots into one description.

    Parameters
    ----------
    specs : mapping of str to MjSpec
        Each of :func:`robot_spec`, by the robot's name.

    Returns
    -------
    MjSpec
        All of them in the order given; names in it begin as :func:`prefix_of` says.
    """
    spec = mujoco.MjSpec()
    for name, one in specs.items():
        spec.attach(one, prefix=prefix_of(name), frame=spec.worldbody.add_frame())
    return spec


def prefix_of(name: str) -> str:
    """Return what names of a robot's bodies and joints begin with among several robots."""
    return f'{name}/' if name else ''


def _dress(body: Any, color: list[float] | None, time_step: float) -> None:
    """Make a link's shapes solid, and show it: as its own URDF has it, or in a color."""
    seen = [geom for geom in body.geoms if not geom.contype and not geom.conaffinity]
    for geom in body.geoms:
        if geom in seen:
            continue
        make_solid(geom, 1.0, time_step)
        if seen:
            geom.group = _HIDDEN
        elif color is not None:
            geom.rgba = color


def _set_motors(spec: Any, robot: Robot, time_step: float) -> None:
    for name, effort in zip(robot.joint_names, robot.effort.reshape(-1)):
        joint = spec.joint(name)
        # The command's limits are the gate's business; here a joint turns as it is driven.
        joint.limited = False
        joint.actfrclimited = False
        joint.frictionloss = effort
        joint.solref_friction = [_MOTOR_TIME * time_step, 1.0]
        joint.solimp_friction = list(_MOTOR_IMPEDANCE)


def _part_overlapping_links(spec: Any, robot: Robot) -> None:
    """Let links pass each other that overlap in the initial posture: shapes are covers."""
    model = spec.compile()
    data = mujoco.MjData(model)
    for name, angle in zip(robot.joint_names, robot.initial_joint_angles.reshape(-1)):
        data.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_forward(model, data)
    bodies = model.geom_bodyid[data.contact.geom]
    for first, second in sorted({tuple(sorted(pair)) for pair in bodies.tolist()}):
        spec.add_exclude(bodyname1=model.body(first).name, bodyname2=model.body(second).name)


def _seen(urdf: str) -> str:
    """Have MuJoCo keep what is only looked at, and the folders of meshes."""
    settings = '<mujoco><compiler discardvisual="false" strippath="false"/></mujoco>'
    return urdf.replace('</robot>', f'{settings}</robot>')
