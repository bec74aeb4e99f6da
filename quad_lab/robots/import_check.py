"""
Imported robots beside what physics engines make of the same descriptions.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.description.poses import moved
from quad_common.errors import QuadError
from quad_common.importing.options import ImportOptions
from quad_common.importing.robot_import import ImportedRobot, import_robot
from quad_common.named_robots.known_robots import KNOWN_ROBOTS, KnownRobot
from quad_common.robot.leg_kinematics import stack_legs

Array = NDArray[np.float64]

_POSTURES = 100


@dataclass(frozen=True)
class ImportCheck:
    """How far an imported robot is from what an engine reads."""

    robot: str
    """Name of the robot."""
    engine: str
    """Engine that read the description, or why it did not."""
    seconds: float
    """Duration of the import [s]."""
    foot: float
    """Largest distance between feet over random postures [m]; nan if there was no engine."""
    mass: float
    """Difference of the masses, as a fraction."""
    center: float
    """Largest distance between centers of mass [m]."""


UPRIGHT_Y = 'laikago/laikago_toes.urdf'
"""Description in pybullet_data whose root has its y axis up, of a robot that is also there with z
up."""

REFUSED = 'quadruped/minitaur.urdf'
"""Description in pybullet_data of a robot whose legs are closed loops."""


def other_description(file: str, like: str) -> KnownRobot:
    """Return another description of the package that holds a known robot's."""
    return replace(KNOWN_ROBOTS[like], file=file)


def check_import(name: str, known: KnownRobot, seed: int) -> list[ImportCheck]:
    """
    Import a robot and compare it with PyBullet and MuJoCo, which read the same file.

    Parameters
    ----------
    name : str
        Name of the robot in the result.
    known : KnownRobot
        Where its description is, and what that lacks.
    seed : int
        Of the postures.

    Returns
    -------
    list of ImportCheck
        One for each engine that is installed.
    """
    assert known.path is not None
    return check_description(name, known.path, known.options, seed)


def check_description(
    name: str, path: Path, options: ImportOptions, seed: int
) -> list[ImportCheck]:
    """Import a robot from a file and compare it with what engines read; see check_import."""
    began = time.perf_counter()
    robot = import_robot(path, options)
    seconds = time.perf_counter() - began
    postures = _postures(robot, np.random.default_rng(seed))
    found = []
    for engine, read in (('bullet', _BulletReading), ('mujoco', _MujocoReading)):
        try:
            reading = read(path, robot)
        except ImportError:
            continue
        except (ValueError, QuadError) as error:
            # MuJoCo refuses what others let pass: inertias, versions of XML.
            reason = f'{engine} cannot read the file: {str(error).splitlines()[0][:80]}'
            found.append(ImportCheck(name, reason, seconds, np.nan, np.nan, np.nan))
            continue
        found.append(_compared(name, engine, robot, reading, postures, seconds))
    return found


def _postures(robot: ImportedRobot, rng: np.random.Generator) -> Array:
    """Draw joint angles within the ranges, shape (n, 4, 3) [rad]."""
    lower = np.array([leg.lower for leg in robot.legs])
    upper = np.array([leg.upper for leg in robot.legs])
    return rng.uniform(lower, upper, (_POSTURES, 4, 3))


def _compared(
    name: str, engine: str, robot: ImportedRobot, reading: Any, postures: Array, seconds: float
) -> ImportCheck:
    legs = stack_legs([ranged.leg for ranged in robot.legs])
    joints = [joint.name for chain in robot.chains for joint in chain.joints]
    foot = center = 0.0
    for angles in postures:
        reading.pose(dict(zip(joints, angles.reshape(-1).tolist())))
        ours = legs.forward(angles)
        theirs = moved(robot.to_base, np.array([reading.foot(k) for k in range(4)]))
        foot = max(foot, float(np.linalg.norm(ours - theirs, axis=1).max()))
        mass_center = robot.masses.center(legs, angles, legs.chain(angles))
        off = mass_center - moved(robot.to_base, reading.center())
        center = max(center, float(np.linalg.norm(off)))
    mass = abs(robot.masses.total / reading.mass - 1.0)
    return ImportCheck(name, engine, seconds, foot, mass, center)


class _BulletReading:
    """The robot as PyBullet reads its description, its root at the world's origin."""

    def __init__(self, path: Path, robot: ImportedRobot) -> None:
        from quad_sim.engines.bullet_simulator import headless_client, silenced

        self._bullet: Any = headless_client()
        flags = self._bullet.URDF_USE_INERTIA_FROM_FILE
        with silenced():
            # What PyBullet thinks of inertias that the import replaces.
            self._body = self._bullet.loadURDF(str(path), useFixedBase=True, flags=flags)
        self._robot = robot
        count = self._bullet.getNumJoints(self._body)
        described = [self._bullet.getJointInfo(self._body, index) for index in range(count)]
        self._joints = {entry[1].decode(): entry[0] for entry in described}
        self._links = {entry[12].decode(): entry[0] for entry in described}
        self._links[self._bullet.getBodyInfo(self._body)[0].decode()] = -1
        stated = robot.tree.links
        # A link without inertial has 1 kg in Bullet, and none in its description.
        self._weights = {
            index: self._bullet.getDynamicsInfo(self._body, index)[0]
            for name, index in self._links.items()
            if stated[name].inertial is not None
        }
        root = robot.tree.mass_of(robot.tree.root).amount
        self._weights[-1] = root
        self.mass = float(sum(self._weights.values()))
        self._locals = [_local(robot.tree.pose(foot.link), foot.center) for foot in robot.feet]

    def pose(self, angles: dict[str, float]) -> None:
        """Turn the joints; others are at 0 [rad]."""
        for name, index in self._joints.items():
            self._bullet.resetJointState(self._body, index, angles.get(name, 0.0))

    def foot(self, leg: int) -> Array:
        """Return where a foot is, in the root's frame, shape (3,) [m]."""
        link = self._links[self._robot.feet[leg].link]
        state = self._bullet.getLinkState(self._body, link, computeForwardKinematics=True)
        rotation = np.reshape(self._bullet.getMatrixFromQuaternion(state[5]), (3, 3))
        return self._from_root(np.array(state[4]) + rotation @ self._locals[leg])

    def center(self) -> Array:
        """Return the center of mass in the root's frame, shape (3,) [m]."""
        moment = np.zeros(3)
        for index, weight in self._weights.items():
            if index < 0:
                place = self._bullet.getBasePositionAndOrientation(self._body)[0]
            else:
                place = self._bullet.getLinkState(self._body, index)[0]
            moment += weight * np.array(place)
        return self._from_root(moment / self.mass)

    def _from_root(self, place: Array) -> Array:
        # The base's pose is that of its inertia.
        described = self._bullet.getDynamicsInfo(self._body, -1)
        inertial = self._bullet.getBasePositionAndOrientation(self._body)
        back = self._bullet.invertTransform(described[3], described[4])
        origin, turn = self._bullet.multiplyTransforms(*inertial, *back)
        rotation = np.reshape(self._bullet.getMatrixFromQuaternion(turn), (3, 3))
        local: Array = rotation.T @ (place - np.array(origin))
        return local


class _MujocoReading:
    """The robot as MuJoCo reads its description, its root at the world's origin."""

    def __init__(self, path: Path, robot: ImportedRobot) -> None:
        import mujoco

        self._mujoco = mujoco
        spec = mujoco.MjSpec.from_file(str(path))
        spec.compiler.fusestatic = False
        spec.compiler.balanceinertia = True
        self._model: Any = spec.compile()
        self._data: Any = mujoco.MjData(self._model)
        self._robot = robot
        self.mass = float(self._model.body_mass[1:].sum())
        self._locals = [_local(robot.tree.pose(foot.link), foot.center) for foot in robot.feet]

    def pose(self, angles: dict[str, float]) -> None:
        """Turn the joints; others are at 0 [rad]."""
        self._data.qpos[:] = 0.0
        for name, angle in angles.items():
            self._data.qpos[self._model.joint(name).qposadr[0]] = angle
        self._mujoco.mj_kinematics(self._model, self._data)
        self._mujoco.mj_comPos(self._model, self._data)

    def foot(self, leg: int) -> Array:
        """Return where a foot is, in the root's frame, shape (3,) [m]."""
        body = self._data.body(self._robot.feet[leg].link)
        place: Array = body.xpos + body.xmat.reshape(3, 3) @ self._locals[leg]
        return place

    def center(self) -> Array:
        """Return the center of mass in the root's frame, shape (3,) [m]."""
        masses = self._model.body_mass[1:, None]
        moment = (masses * self._data.xipos[1:]).sum(axis=0)
        place: Array = moment / self.mass
        return place


def _local(frame: Array, point: Array) -> Array:
    """Return a point of the root's frame in a link's, shape (3,) [m]."""
    local: Array = frame[:3, :3].T @ (point - frame[:3, 3])
    return local
