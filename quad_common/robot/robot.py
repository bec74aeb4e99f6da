"""
A robot, as data: geometry, masses, limits and the posture it walks in.

Robots are YAML files in which every number carries its source; the ones that ship
lie in ``quad_common/robots``. Joint arrays have one row per leg, in the order
:data:`LEGS`, and one column per joint of a leg.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    FileUnusable,
    JointLimitExceeded,
    JointNotFound,
    OutOfRange,
    RobotModelError,
    RobotValueOutOfRange,
    UnknownKey,
)
from quad_common.files.bounded_file import is_file, user_path
from quad_common.files.yaml_document import check_keys, in_file, read_yaml
from quad_common.quoting import quoted, shown
from quad_common.robot import reach
from quad_common.robot.leg_kinematics import (
    Leg,
    roll_pitch_pitch_leg,
    stack_legs,
    yaw_pitch_pitch_leg,
)
from quad_common.robot.own_parts import LEAST_CLEARANCE, OwnParts
from quad_common.robot.robot_numbers import JOINTS_PER_LEG, RobotNumbers
from quad_common.robot.robot_shape import RobotShape

Array = NDArray[np.float64]

LEGS = ('lf', 'rf', 'lh', 'rh')
"""Left front, right front, left hind, right hind: the order of every per-leg array."""

LEG_TYPES = {
    'yaw_pitch_pitch': ('hip_yaw', 'hip_pitch', 'knee_pitch'),
    'roll_pitch_pitch': ('hip_roll', 'hip_pitch', 'knee_pitch'),
}
"""The builds that a leg may have, and the kinds of their joints from the body outward."""

_HIP_HEIGHT_OF_TITAN_VIII = 0.243
"""S0 sec. 6 [m]."""

_QUANTITIES = ('lower', 'upper', 'velocity', 'effort')

_NOT_NUMBERS = ('name', 'description', 'leg_type', 'stated')
"""Keys of a robot data file that hold no number of the robot."""

_GAIT_KEYS = ('cycle_period', 'swing_height')
"""What a robot may change in a gait."""

_WHAT = 'robot data file'

_LONGEST_NAME = 64
"""Characters of a robot's name."""

ROBOTS_FOLDER = Path(__file__).parents[1] / 'robots'
"""Where the robots that ship are."""


@dataclass(frozen=True)
class LinkShape:
    """A link as a solid of revolution: enough for inertia, collision and pictures."""

    mass: float
    """[kg]"""
    radius: float
    """[m]"""


@dataclass(frozen=True)
class GaitSettings:
    """What a robot changes in a gait; None leaves it as the gait has it."""

    cycle_period: float | None = None
    """[s]"""
    swing_height: float | None = None
    """[m]"""


@dataclass(frozen=True)
class Robot:
    """One quadruped with four legs of the same build."""

    name: str
    leg_type: str
    """Build of the legs, one of :data:`LEG_TYPES`."""
    legs: tuple[Leg, ...]
    """In the order of :data:`LEGS`."""
    knee_is_absolute: bool
    """Whether the knee drives work from the horizontal (a pantograph)."""
    body_size: tuple[float, float, float]
    """Length, width and height of the body's box [m]."""
    body_center: tuple[float, float, float]
    """Center of the box, and of the body's mass, in base_link [m]."""
    body_mass: float
    """[kg]"""
    links: Mapping[str, LinkShape]
    """Of a leg: ``hip``, ``thigh``, ``calf``, ``foot``."""
    joint_kinds: tuple[str, ...]
    """Names of a leg's joints from the body outward, for example ``hip_yaw``."""
    lower: Array
    """Lower limits of the joints, shape (4, 3) [rad]."""
    upper: Array
    """Upper limits of the joints, shape (4, 3) [rad]."""
    velocity: Array
    """Largest speeds of the joints, shape (4, 3) [rad/s]."""
    effort: Array
    """Largest torques of the joints, shape (4, 3) [N m]."""
    initial_joint_angles: Array
    """Initial posture, shape (4, 3) [rad]."""
    roughness: float
    """How much lower than expected the ground may be, S0's dh + dv [m]."""
    gaits: Mapping[str, GaitSettings]
    """The gaits that suit the robot, and what it changes in them."""
    sources: Mapping[str, str] = field(repr=False)
    """Where each number of the data file comes from, by its dotted name."""

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """The twelve joints, leg by leg."""
        return tuple(f'{leg}_{kind}_joint' for leg in LEGS for kind in self.joint_kinds)

    @cached_property
    def stacked_legs(self) -> Leg:
        """The four legs as one, for arrays of shape (..., 4, 3)."""
        return stack_legs(self.legs)

    @property
    def foot_radius(self) -> float:
        """Radius of the foot's ball [m]: its center is the leg's end point."""
        return self.links['foot'].radius

    @property
    def mass(self) -> float:
        """Mass of the whole robot [kg]."""
        return self.body_mass + len(LEGS) * sum(link.mass for link in self.links.values())

    @cached_property
    def neutral_feet(self) -> Array:
        """Feet in the initial posture, body frame, shape (4, 3) [m]."""
        return self.foot_positions(self.initial_joint_angles)

    @cached_property
    def hip_height(self) -> float:
        """Height of the hips above the feet's centers in the initial posture, H0 [m]."""
        return float(self.legs[0].hip[2] - np.mean(self.neutral_feet[:, 2]))

    @cached_property
    def relative_size(self) -> float:
        """Hip height as a share of TITAN-VIII's, for which many lengths were chosen."""
        return self.hip_height / _HIP_HEIGHT_OF_TITAN_VIII

    @cached_property
    def standing_height(self) -> float:
        """Height of base_link above the ground in the initial posture [m]."""
        return float(self.foot_radius - np.mean(self.neutral_feet[:, 2]))

    @cached_property
    def stance_reach(self) -> float:
        """Horizontal distance from hip point to foot in the initial posture, L0 [m]."""
        return float(np.linalg.norm(self.neutral_feet[0, :2] - self.legs[0].hip[:2]))

    @cached_property
    def largest_stride(self) -> float:
        """S_max of S0 [m], from the legs' geometry."""
        if self.leg_type == 'roll_pitch_pitch':
            return reach.largest_step(self.legs[0], self.neutral_feet[0], self.roughness)
        stretch = reach.largest_stretch(self.legs[0], self.hip_height, self.roughness)
        return reach.largest_stride(stretch, self.stance_reach)

    @cached_property
    def largest_turn(self) -> float:
        """phi_max of S0 [rad], from the legs' geometry."""
        x, y, _ = self.neutral_feet[0]
        distance = math.hypot(x, y) if self.leg_type == 'roll_pitch_pitch' else float(y)
        return reach.largest_turn(self.largest_stride, distance)

    @cached_property
    def step_height(self) -> float:
        """Highest step that the robot climbs [m], from the legs' geometry."""
        stride = reach.STEP_SHARE * self.largest_stride
        if self.leg_type == 'roll_pitch_pitch':
            lower = reach.lowest_at_step(self.legs[0], self.neutral_feet[0], stride)
        else:
            stretch = math.hypot(stride, self.stance_reach)
            lower = reach.lowest_at_stretch(self.legs[0], self.hip_height, stretch)
        return reach.largest_step_height(lower, self.hip_height)

    @cached_property
    def mesh_size(self) -> float:
        """Mesh of S0 eq. 5 [m]: body length between the hip axes plus S_max."""
        return 2.0 * float(self.legs[0].hip[0]) + self.largest_stride

    @cached_property
    def footprint_radius(self) -> float:
        """Radius of the circle around base_link that holds feet and body [m]."""
        feet = float(np.max(np.linalg.norm(self.neutral_feet[:, :2], axis=1))) + self.foot_radius
        return max(feet, math.hypot(self.body_size[0], self.body_size[1]) / 2.0)

    @cached_property
    def own_parts(self) -> OwnParts:
        """The robot's parts, which must keep clear of one another."""
        radii = {kind: link.radius for kind, link in self.links.items()}
        shape = RobotShape(self.stacked_legs, self.body_center, self.body_size, radii)
        least = LEAST_CLEARANCE * self.relative_size
        return OwnParts(shape, self.initial_joint_angles, self.lower, self.upper, least)

    def foot_positions(self, joint_angles: Array) -> Array:
        """
        Place the four feet.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Returns
        -------
        ndarray, shape (..., 4, 3)
            Feet in the body frame [m].
        """
        return self.stacked_legs.forward(joint_angles)

    def foot_jacobians(self, joint_angles: Array) -> Array:
        """
        Differentiate the feet's positions by their own legs' joint angles.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Returns
        -------
        ndarray, shape (..., 4, 3, 3)
            J with foot velocity = J @ joint velocity, in the body frame [m/rad].
        """
        return self.stacked_legs.jacobian(joint_angles)

    def calf_angular_velocities(self, joint_angles: Array, joint_velocities: Array) -> Array:
        """
        Find how fast the calves turn relative to the body.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].
        joint_velocities : ndarray, shape (..., 4, 3)
            [rad/s].

        Returns
        -------
        ndarray, shape (..., 4, 3)
            Angular velocities in the body's axes [rad/s].
        """
        return self.stacked_legs.angular_velocity(joint_angles, joint_velocities)

    def joint_angles(self, feet: Array) -> Array:
        """
        Find joint angles for the four feet, within the joints' limits.

        Parameters
        ----------
        feet : ndarray, shape (..., 4, 3)
            Feet in the body frame [m].

        Returns
        -------
        ndarray, shape (..., 4, 3)
            [rad].

        Raises
        ------
        FootTargetUnreachable
            If a leg is too short or cannot fold that far.
        JointLimitExceeded
            If a joint would leave its range.
        """
        angles = self.stacked_legs.inverse(feet)
        self.check_joint_limits(angles)
        return angles

    def joint_velocities(self, joint_angles: Array, foot_velocities: Array) -> Array:
        """
        Find the joint speeds that give the feet their velocities.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].
        foot_velocities : ndarray, shape (..., 4, 3)
            In the body frame [m/s].

        Returns
        -------
        ndarray, shape (..., 4, 3)
            [rad/s].

        Raises
        ------
        SingularPosture
            If a leg cannot move its foot in every direction.
        """
        return self.stacked_legs.joint_velocities(joint_angles, foot_velocities)

    def center_of_mass(self, joint_angles: Array) -> Array:
        """
        Find the center of mass of body and legs.

        Each link's mass sits halfway between its ends, the foot's at the leg's end.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Returns
        -------
        ndarray, shape (..., 3)
            In the body frame [m].
        """
        return self.center_of_mass_of(self.stacked_legs.chain(joint_angles))

    def center_of_mass_of(self, chain: tuple[Array, Array, Array]) -> Array:
        """
        Find the center of mass from where the legs' joints are.

        Parameters
        ----------
        chain : tuple of ndarray
            Pitch axes, knees and feet in the body frame, each of shape (..., 4, 3) [m].

        Returns
        -------
        ndarray, shape (..., 3)
            As :meth:`center_of_mass` [m].
        """
        mass = {kind: link.mass for kind, link in self.links.items()}
        pitch_axis, knee, feet = chain
        moment = 0.5 * (mass['hip'] + mass['thigh']) * pitch_axis
        moment += 0.5 * (mass['thigh'] + mass['calf']) * knee
        moment += (0.5 * mass['calf'] + mass['foot']) * feet
        fixed = self.body_mass * np.asarray(self.body_center)
        fixed += 0.5 * mass['hip'] * self.stacked_legs.hip.sum(axis=0)
        total: Array = moment.sum(axis=-2)
        return (total + fixed) / self.mass

    def check_joint_limits(self, joint_angles: Array) -> None:
        """
        Raise if a joint angle is outside its range.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Raises
        ------
        JointLimitExceeded
            Naming the joint that is farthest outside.
        """
        outside = np.maximum(self.lower - joint_angles, joint_angles - self.upper)
        if not np.any(outside > 1e-9):
            return
        worst = int(np.argmax(outside))
        joint = worst % len(self.joint_names)
        raise JointLimitExceeded(
            self.joint_names[joint],
            float(joint_angles.reshape(-1)[worst]),
            float(self.lower.flat[joint]),
            float(self.upper.flat[joint]),
        )

    def check_joint_speeds(self, joint_velocities: Array) -> None:
        """
        Raise if a joint is faster than it can be.

        Parameters
        ----------
        joint_velocities : ndarray, shape (..., 4, 3)
            [rad/s].

        Raises
        ------
        JointLimitExceeded
            Naming the joint that is fastest beside its limit.
        """
        excess = np.abs(joint_velocities) / self.velocity
        if not np.max(excess) > 1.0:
            return
        worst = int(np.argmax(excess))
        joint = worst % len(self.joint_names)
        limit = float(np.broadcast_to(self.velocity, (len(LEGS), JOINTS_PER_LEG)).flat[joint])
        speed = float(joint_velocities.reshape(-1)[worst])
        raise JointLimitExceeded(self.joint_names[joint], speed, -limit, limit, 'rad/s')

    def within_joint_limits(self, joint_angles: Array) -> NDArray[np.bool_]:
        """
        Say which postures are within all joints' ranges.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Returns
        -------
        ndarray of bool, shape (...)
            As :meth:`check_joint_limits` judges them.
        """
        outside = np.maximum(self.lower - joint_angles, joint_angles - self.upper)
        return np.asarray((outside <= 1e-9).all(axis=(-2, -1)))

    def joint_index(self, name: str) -> int:
        """Return the place of a joint in :attr:`joint_names`; raise JointNotFound."""
        try:
            return self.joint_names.index(name)
        except ValueError:
            raise JointNotFound(name, self.joint_names) from None


def available_robots() -> tuple[str, ...]:
    """Return the names of the robots that ship with quadwalk."""
    return tuple(sorted(path.stem for path in ROBOTS_FOLDER.glob('*.yaml')))


def robot_file(robot: str | Path) -> Path:
    """
    Find the data file of a robot.

    Parameters
    ----------
    robot : str or Path
        Name of one that ships (``titan_viii``), or path of a YAML file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    RobotModelError
        If there is no such robot.
    """
    shipped = ROBOTS_FOLDER / f'{robot}.yaml'
    try:
        path = shipped if is_file(shipped) else user_path(robot, _WHAT)
    except FileUnusable as error:
        raise RobotModelError(str(error)) from error
    if not is_file(path):
        raise RobotModelError(
            f'there is no robot {quoted(str(robot))}; available: '
            f'{", ".join(available_robots())}, '
            f'or the path of a robot data file'
        )
    return path


def load_robot(robot: str | Path) -> Robot:
    """
    Load a robot by the name of one that ships, or from a data file.

    Parameters
    ----------
    robot : str or Path
        Name (``titan_viii``) or path of a YAML file.

    Returns
    -------
    Robot
        The robot, checked.

    Raises
    ------
    RobotModelError
        If there is no such robot, or its file is incomplete or contradicts itself.
    """
    path = robot_file(robot)
    try:
        document = read_yaml(path, _WHAT, "a robot's numbers")
        return _robot_from_document(document, path)
    except FileUnusable as error:
        raise RobotModelError(str(error)) from error
    except (OutOfRange, UnknownKey) as error:
        raise in_file(error, _WHAT, path, RobotModelError, RobotValueOutOfRange) from error


def _robot_from_document(document: Mapping[str, Any], path: Path) -> Robot:
    number = RobotNumbers(document, path)
    leg_type = document.get('leg_type')
    if not isinstance(leg_type, str) or leg_type not in LEG_TYPES:
        available = ', '.join(f"'{name}'" for name in LEG_TYPES)
        raise RobotModelError(f'{path}: leg_type is {shown(leg_type)}; available: {available}')
    name = document.get('name', path.stem)
    if not isinstance(name, str) or len(name) > _LONGEST_NAME or not name.isprintable():
        raise RobotModelError(
            f'{path}: the name is {shown(name)}; '
            f'it must be a text of up to {_LONGEST_NAME} printable characters'
        )
    kinds = LEG_TYPES[leg_type]
    build = _roll_leg if leg_type == 'roll_pitch_pitch' else _yaw_leg
    legs = tuple(build(number, leg, _hip(number, leg), _side(leg)) for leg in LEGS)
    foot_radius = number('leg.foot_radius')
    links = {
        kind: LinkShape(
            mass=number(f'leg.{kind}_mass'),
            radius=foot_radius if kind == 'foot' else number(f'leg.{kind}_radius'),
        )
        for kind in ('hip', 'thigh', 'calf', 'foot')
    }
    in_file = {
        quantity: np.array([number(f'joints.{kind}.{quantity}') for kind in kinds])
        for quantity in _QUANTITIES
    }
    for kind, low, high in zip(kinds, in_file['lower'], in_file['upper']):
        if not low < high:
            raise RobotModelError(f'{path}: joint {kind} has lower {low} not below upper {high}')
    initial = np.array([number(f'initial_posture.{kind}') for kind in kinds])
    signs = np.array([_signs_of_the_file(leg_type, leg) for leg in legs])
    ends = signs * in_file['lower'], signs * in_file['upper']
    robot = Robot(
        name=name,
        leg_type=leg_type,
        legs=legs,
        knee_is_absolute=number.is_true('drive.knee_is_absolute'),
        body_size=(
            number('body.length'),
            number('body.width'),
            number('body.height'),
        ),
        body_center=(0.0, 0.0, number('body.center_height')),
        body_mass=number('body.mass'),
        links=links,
        joint_kinds=kinds,
        lower=np.minimum(*ends),
        upper=np.maximum(*ends),
        velocity=np.tile(in_file['velocity'], (len(LEGS), 1)),
        effort=np.tile(in_file['effort'], (len(LEGS), 1)),
        initial_joint_angles=signs * initial,
        roughness=number('gait.roughness'),
        gaits=_gaits(number),
        sources=number.sources,
    )
    number.check_all_used(but=_NOT_NUMBERS)
    try:
        robot.check_joint_limits(robot.initial_joint_angles)
    except JointLimitExceeded as error:
        raise RobotModelError(f'{path}: the initial posture is out of range: {error}') from error
    return robot


def _side(leg: str) -> int:
    """Return +1 for a left leg and -1 for a right one."""
    return 1 if leg.startswith('l') else -1


def _hip(number: RobotNumbers, leg: str) -> tuple[float, float, float]:
    half_length = number('body.hip_half_length')
    half_width = number('body.hip_half_width')
    return half_length if leg.endswith('f') else -half_length, _side(leg) * half_width, 0.0


def _yaw_leg(number: RobotNumbers, leg: str, hip: tuple[float, float, float], side: int) -> Leg:
    return yaw_pitch_pitch_leg(
        leg,
        hip,
        side,
        hip_offset=number('leg.hip_offset'),
        hip_drop=number('leg.hip_drop'),
        thigh_length=number('leg.thigh_length'),
        calf_length=number('leg.calf_length'),
        lateral_offset=number.or_zero('leg.lateral_offset'),
        signs=number.signs(f'leg.axis_signs.{leg}'),
    )


def _roll_leg(number: RobotNumbers, leg: str, hip: tuple[float, float, float], side: int) -> Leg:
    return roll_pitch_pitch_leg(
        leg,
        hip,
        side,
        hip_offset=number('leg.hip_offset'),
        hip_drop=number('leg.hip_drop'),
        thigh_length=number('leg.thigh_length'),
        calf_length=number('leg.calf_length'),
        knee_sign=number.sign(f'leg.knee_sign_{"front" if leg.endswith("f") else "hind"}'),
        forward_offset=number.or_zero('leg.forward_offset'),
        signs=number.signs(f'leg.axis_signs.{leg}'),
    )


def _signs_of_the_file(leg_type: str, leg: Leg) -> Array:
    """
    Say which of a leg's angles stand in the file with the other sign, shape (3,).

    For roll legs the file has those of a left leg with knee_sign +1: roll is mirrored
    by side, and pitch and knee by knee_sign. Yaw legs are all written alike.
    """
    signs = np.array(leg.signs)
    if leg_type == 'roll_pitch_pitch':
        signs *= [_side(str(leg.name)), float(leg.knee_sign), float(leg.knee_sign)]
    return signs


def _gaits(number: RobotNumbers) -> dict[str, GaitSettings]:
    gaits = {}
    for name in number.names_under('gaits'):
        changed = number.names_under(f'gaits.{name}')
        check_keys(dict.fromkeys(changed), _GAIT_KEYS, f'gaits.{name}')
        settings = {key: number(f'gaits.{name}.{key}') for key in changed}
        gaits[name] = GaitSettings(**settings)
    return gaits
