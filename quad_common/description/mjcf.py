"""
Reads MJCF, MuJoCo's own format, as links and joints of the kind that URDF has.

MuJoCo itself reads the file and compiles it: classes, defaults, included files, units of angles
and masses of shapes are what they are in its simulation. What is left is a change of terms:

- A body has any number of joints in MJCF, one after another; each gets a link of its own here.
- A joint's anchor may be anywhere in its body; here it is the origin of its link.
- Angles are those of MuJoCo's ``qpos``, whatever angle the file calls ``ref``.
- The base's joints are left out, and the world around the robot.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import yourdfpy
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from quad_common.errors import (
    DescriptionEntryInvalid,
    DescriptionUnusable,
    MissingOptionalDependency,
    NotAQuadruped,
)

try:
    import mujoco
except ImportError as error:
    raise MissingOptionalDependency('mujoco', "pip install 'quadwalk[sim]'") from error

from quad_common.description.mjcf_shapes import LinkShapes, pose_from

Array = NDArray[np.float64]

_LEGS = 4
"""Number of chains of joints that the body of a quadruped carries at least."""

_BETWEEN = 0.02
"""Fraction of a body's mass that a link between two of its joints gets: engines need some."""

_NO_NAME = 'MuJoCo Model'
"""Name that MuJoCo gives to models without one."""

_UNNAMED = 'Caught an unknown exception!'
"""What MuJoCo says for want of memory."""

_SCENE = re.compile(r'[\s_-]+scene$', re.IGNORECASE)
"""End of the names of files that put a robot on a floor."""

_FREE = int(mujoco.mjtJoint.mjJNT_FREE)
_BALL = int(mujoco.mjtJoint.mjJNT_BALL)
_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)


def robot_from_mjcf(path: Path) -> Any:
    """
    Read a robot from an MJCF file.

    Parameters
    ----------
    path : Path
        The file; what it includes and its meshes are looked for as MuJoCo does.

    Returns
    -------
    yourdfpy.Robot
        Links with masses and shapes, meshes by absolute paths; joints with ranges, and with the
        largest torques that actuators and joints state. MJCF states no largest speeds.

    Raises
    ------
    DescriptionUnusable
        If MuJoCo refuses it, with MuJoCo's reason; if it holds several robots, or legs that are
        closed loops.
    DescriptionEntryInvalid
        If a joint of the robot is a ball.
    NotAQuadruped
        If nothing in it has joints.
    """
    try:
        with _without_warnings():
            spec = mujoco.MjSpec.from_file(str(path))
            # Bodies that cannot move against each other, and shapes only to look at, stay.
            spec.compiler.fusestatic = False
            spec.compiler.discardvisual = False
            # Postures of a robot alone do not fit a scene, which some versions refuse for it.
            for key in list(spec.keys):
                key.delete() if hasattr(key, 'delete') else spec.delete(key)
            model = spec.compile()
    # MuJoCo's readers raise ValueError; its plugins and decoders of meshes whatever they like.
    except Exception as error:
        reason = ' '.join(str(error).split()) or type(error).__name__
        if reason == _UNNAMED:
            reason = (
                'it needs more memory than may be used, or has a fault that MuJoCo does not name'
            )
        raise DescriptionUnusable(path, f'MuJoCo cannot read it: {reason}') from error
    return _Conversion(path, model, LinkShapes(path, spec, model)).robot(str(spec.modelname))


@contextmanager
def _without_warnings() -> Iterator[None]:
    """Keep MuJoCo from writing its warnings to a file wherever the program was started."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


class _Conversion:
    """
    Turns the bodies of a compiled model into links and joints.

    Parameters
    ----------
    path : Path
        The file, for the sentences of errors.
    model : mujoco.MjModel
        Nothing fused, nothing left out.
    shapes : LinkShapes
        Its shapes.
    """

    def __init__(self, path: Path, model: Any, shapes: LinkShapes) -> None:
        self._path = path
        self._model = model
        self._shapes = shapes
        self._parents = [int(parent) for parent in model.body_parentid]
        self._children: list[list[int]] = [[] for _ in self._parents]
        for body, parent in enumerate(self._parents[1:], start=1):
            self._children[parent].append(body)
        self._links: list[Any] = []
        self._joints: list[Any] = []
        self._names: set[str] = set()

    def robot(self, name: str) -> Any:
        """Return the one robot that is in the model."""
        root = self._root()
        bodies = self._subtree(root)
        self._check(bodies)
        of_bodies = [self._model.body(body).name for body in bodies]
        of_joints = [self._model.joint(j).name for body in bodies for j in self._joints_of(body)]
        self._names = {*of_bodies, *of_joints}
        names = {
            body: self._model.body(body).name
            or self._free('base' if body == root else f'body{body}')
            for body in bodies
        }
        # Of each body: the name of its link, and the body's frame in that of the link.
        ends = {root: (names[root], np.eye(4))}
        self._add_link(names[root], root, np.eye(4), 1.0)
        for body in bodies[1:]:
            ends[body] = self._add_body(body, names[body], *ends[self._parents[body]])
        own = '' if name == _NO_NAME else _SCENE.sub('', name.strip())
        return yourdfpy.urdf.Robot(name=own, links=self._links, joints=self._joints)

    def _add_body(self, body: int, name: str, parent: str, frame: Array) -> tuple[str, Array]:
        """Add a body, its joints, and the links between them."""
        model = self._model
        frame = frame @ pose_from(model.body_pos[body], model.body_quat[body])
        joints = self._joints_of(body)
        if not joints:
            self._joints.append(
                yourdfpy.urdf.Joint(
                    name=self._free(f'{name}_fixed'),
                    type='fixed',
                    parent=parent,
                    child=name,
                    origin=frame,
                )
            )
            self._add_link(name, body, np.eye(4), 1.0)
            return name, np.eye(4)
        share = 1.0 - _BETWEEN * (len(joints) - 1)
        for count, joint in enumerate(joints):
            joint_name = model.joint(joint).name or self._free(f'{name}_joint{count}')
            is_last = count == len(joints) - 1
            child = name if is_last else self._free(f'{name}_after_{joint_name}')
            before, after = self._about(joint)
            self._joints.append(self._joint(joint, joint_name, parent, child, frame @ before))
            self._add_link(child, body, after, share if is_last else _BETWEEN, is_last)
            parent, frame = child, after
        return name, frame

    def _about(self, joint: int) -> tuple[Array, Array]:
        """
        Place a joint's link, and its body.

        Returns
        -------
        before : ndarray, shape (4, 4)
            The link's frame at ``qpos`` 0 in the body's frame as it is without the joint.
        after : ndarray, shape (4, 4)
            The body's frame in the link's.
        """
        model = self._model
        before, after = np.eye(4), np.eye(4)
        reference = float(model.qpos0[model.jnt_qposadr[joint]])
        if model.jnt_type[joint] == _SLIDE:
            before[:3, 3] = -reference * model.jnt_axis[joint]
            return before, after
        before[:3, :3] = Rotation.from_rotvec(-reference * model.jnt_axis[joint]).as_matrix()
        before[:3, 3] = model.jnt_pos[joint]
        after[:3, 3] = -model.jnt_pos[joint]
        return before, after

    def _joint(self, joint: int, name: str, parent: str, child: str, origin: Array) -> Any:
        model = self._model
        is_limited = bool(model.jnt_limited[joint])
        kind = 'revolute' if is_limited else 'continuous'
        lower, upper = model.jnt_range[joint].tolist() if is_limited else (None, None)
        return yourdfpy.urdf.Joint(
            name=name,
            type='prismatic' if model.jnt_type[joint] == _SLIDE else kind,
            parent=parent,
            child=child,
            origin=origin,
            axis=np.array(model.jnt_axis[joint]),
            limit=yourdfpy.urdf.Limit(
                effort=largest_effort(model, joint), velocity=None, lower=lower, upper=upper
            ),
            mimic=self._mimic(joint),
        )

    def _mimic(self, joint: int) -> Any:
        """Say which joint another one follows, by a constraint; None if it moves for itself."""
        model, kind = self._model, int(mujoco.mjtEq.mjEQ_JOINT)
        for k in np.flatnonzero((model.eq_type == kind) & (model.eq_obj1id == joint)):
            if model.eq_active0[k] and (other := int(model.eq_obj2id[k])) >= 0:
                return yourdfpy.urdf.Mimic(joint=model.joint(other).name or f'joint {other}')
        return None

    def _add_link(
        self, name: str, body: int, frame: Array, share: float, has_shapes: bool = True
    ) -> None:
        """Add a link with a share of a body's mass, and its shapes; the frame is the body's."""
        model = self._model
        link = yourdfpy.urdf.Link(name=name)
        mass = share * float(model.body_mass[body])
        if mass > 0.0:
            link.inertial = yourdfpy.urdf.Inertial(
                origin=frame @ pose_from(model.body_ipos[body], model.body_iquat[body]),
                mass=mass,
                inertia=np.diag(share * model.body_inertia[body]),
            )
        if has_shapes:
            link.visuals, link.collisions = self._shapes.of_body(body, frame)
        self._links.append(link)

    def _root(self) -> int:
        """
        Find the body that carries the legs, below whatever moves it in the world.

        It is the world itself if legs stand in it one by one.
        """
        tops = [body for body in self._children[0] if self._ends(body) > 0]
        robots = [body for body in tops if self._ends(body) >= _LEGS] or tops
        if not robots:
            raise NotAQuadruped(self._path, 'no joint that moves')
        if sum(self._ends(body) for body in tops) >= _LEGS > max(map(self._ends, tops)):
            # MuJoCo makes a URDF's root a part of the world, where its mass is lost.
            return 0
        if len(robots) > 1:
            names = ', '.join(f"'{self._model.body(body).name}'" for body in robots[:4])
            raise DescriptionUnusable(
                self._path,
                f'one robot is needed, whose legs hang at one body; {len(robots)} bodies with '
                f'joints stand in the world ({names})',
            )
        root = body = robots[0]
        while not self._is_free(body):
            moving = [child for child in self._children[body] if self._ends(child) > 0]
            if len(moving) != 1 or self._ends(moving[0]) < _LEGS:
                break
            # Planar bases are made of bodies that slide one upon another.
            body = moving[0]
            root = body if self._joints_of(body) else root
        return root

    def _check(self, bodies: list[int]) -> None:
        """Refuse ball joints, and loops that are closed by constraints."""
        model = self._model
        for joint in (j for body in bodies[1:] for j in self._joints_of(body)):
            if model.jnt_type[joint] == _BALL:
                raise DescriptionEntryInvalid(
                    self._path,
                    f"joint '{model.joint(joint).name}'",
                    'is a ball joint; legs need joints that turn about one axis each',
                )
        closing = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))
        for k in range(model.neq):
            ends = self._bodies_of_constraint(k) if int(model.eq_type[k]) in closing else ()
            if ends and model.eq_active0[k] and set(ends) <= set(bodies):
                one, other = (f"'{model.body(body).name}'" for body in ends)
                raise DescriptionUnusable(
                    self._path,
                    f'bodies {one} and {other} are tied together into a closed loop; legs need '
                    'to be chains of joints',
                )

    def _bodies_of_constraint(self, index: int) -> tuple[int, int]:
        model = self._model
        first, second = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
        if int(model.eq_objtype[index]) == int(mujoco.mjtObj.mjOBJ_SITE):
            return int(model.site_bodyid[first]), int(model.site_bodyid[second])
        return first, second

    def _ends(self, body: int) -> int:
        """Count the bodies below one, itself included, that move and carry none that does."""
        below = sum(self._ends(child) for child in self._children[body])
        moves = any(self._model.jnt_type[joint] != _FREE for joint in self._joints_of(body))
        return below or int(moves)

    def _is_free(self, body: int) -> bool:
        return any(self._model.jnt_type[joint] == _FREE for joint in self._joints_of(body))

    def _joints_of(self, body: int) -> range:
        first = int(self._model.body_jntadr[body])
        return range(first, first + int(self._model.body_jntnum[body]))

    def _subtree(self, body: int) -> list[int]:
        """List a body and those below it, each after the one that carries it."""
        children = self._children[body]
        if body == 0:
            # Of what stands in the world the robot's legs alone.
            children = [child for child in children if self._ends(child) > 0]
        return [body, *(b for child in children for b in self._subtree(child))]

    def _free(self, name: str) -> str:
        """Return a name that nothing has yet, and take it."""
        while name in self._names:
            name += '_'
        self._names.add(name)
        return name


def largest_effort(model: Any, joint: int) -> float | None:
    """
    Find the largest torque or force of a joint that holds in both directions.

    Parameters
    ----------
    model : mujoco.MjModel
        The compiled model.
    joint : int
        Index of the joint.

    Returns
    -------
    float or None
        The smaller one of what its actuators can give and what the joint lets through; None where
        neither is limited [N m] or [N].
    """
    at_joints = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    forces = [
        _largest_of_actuator(model, k)
        for k, transmission in enumerate(model.actuator_trntype)
        if int(transmission) in at_joints and model.actuator_trnid[k, 0] == joint
    ]
    known = [force for force in forces if force is not None]
    limits = [max(known)] if known and len(known) == len(forces) else []
    if model.jnt_actfrclimited[joint]:
        limits.append(_both_ways(model.jnt_actfrcrange[joint]))
    return min(limits) or None if limits else None


def _largest_of_actuator(model: Any, actuator: int) -> float | None:
    gear = abs(float(model.actuator_gear[actuator, 0]))
    limits = []
    if model.actuator_forcelimited[actuator]:
        limits.append(_both_ways(model.actuator_forcerange[actuator]))
    is_motor = (
        int(model.actuator_gaintype[actuator]) == int(mujoco.mjtGain.mjGAIN_FIXED)
        and int(model.actuator_biastype[actuator]) == int(mujoco.mjtBias.mjBIAS_NONE)
        and int(model.actuator_dyntype[actuator]) == int(mujoco.mjtDyn.mjDYN_NONE)
    )
    # Newer versions know actuators of several controls; those of one stand where this says.
    addresses = getattr(model, 'actuator_ctrladr', None)
    control = actuator if addresses is None else int(addresses[actuator])
    if is_motor and model.actuator_ctrllimited[control]:
        gain = abs(float(model.actuator_gainprm[actuator, 0]))
        limits.append(gain * _both_ways(model.actuator_ctrlrange[control]))
    return gear * min(limits) if limits else None


def _both_ways(ends: Iterable[float]) -> float:
    low, high = ends
    return max(0.0, min(-float(low), float(high)))
