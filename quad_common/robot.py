"""
A robot, as data: geometry, masses, limits and the posture it walks in.

Robots are YAML files in which every number carries its source; the ones that ship
lie in ``quad_common/robots``. Joint arrays have one row per leg, in the order
:data:`LEGS`, and one column per joint of a leg.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from quad_common import reach
from quad_common.errors import JointLimitExceeded, JointNotFound, RobotModelError
from quad_common.leg_kinematics import YawPitchPitchLeg

Array = NDArray[np.float64]

LEGS = ('lf', 'rf', 'lh', 'rh')
"""Left front, right front, left hind, right hind: the order of every per-leg array."""

JOINTS_PER_LEG = 3

_ROBOTS = Path(__file__).parent / 'robots'


@dataclass(frozen=True)
class LinkShape:
    """A link as a solid of revolution: enough for inertia, collision and pictures."""

    mass: float
    """[kg]"""
    radius: float
    """[m]"""


@dataclass(frozen=True)
class Robot:
    """One quadruped with four legs of the same build."""

    name: str
    legs: tuple[YawPitchPitchLeg, ...]
    """In the order of :data:`LEGS`."""
    knee_is_absolute: bool
    """Whether the knee drives work from the horizontal (a pantograph)."""
    body_size: tuple[float, float, float]
    """Length, width and height of the body's box [m]."""
    body_center: tuple[float, float, float]
    """Centre of the box, and of the body's mass, in base_link [m]."""
    body_mass: float
    """[kg]"""
    links: Mapping[str, LinkShape]
    """Of a leg: ``hip``, ``thigh``, ``calf``, ``foot``."""
    joint_kinds: tuple[str, ...]
    """Names of a leg's joints from the body outward, for example ``hip_yaw``."""
    lower: Array
    """Lower limits of a leg's joints, shape (3,) [rad]."""
    upper: Array
    """Upper limits of a leg's joints, shape (3,) [rad]."""
    velocity: Array
    """Largest speeds of a leg's joints, shape (3,) [rad/s]."""
    effort: Array
    """Largest torques of a leg's joints, shape (3,) [N m]."""
    initial_joint_angles: Array
    """Initial posture, shape (4, 3) [rad]."""
    roughness: float
    """How much lower than expected the ground may be, S0's dh + dv [m]."""
    sources: Mapping[str, str] = field(repr=False)
    """Where each number of the data file comes from, by its dotted name."""

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """The twelve joints, leg by leg."""
        return tuple(f'{leg}_{kind}_joint' for leg in LEGS for kind in self.joint_kinds)

    @property
    def foot_radius(self) -> float:
        """Radius of the foot's ball [m]: its centre is the leg's end point."""
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
        """Height of the hips above the feet's centres in the initial posture, H0 [m]."""
        return float(self.legs[0].hip[2] - np.mean(self.neutral_feet[:, 2]))

    @cached_property
    def standing_height(self) -> float:
        """Height of base_link above the ground in the initial posture [m]."""
        return float(self.foot_radius - np.mean(self.neutral_feet[:, 2]))

    @cached_property
    def stance_reach(self) -> float:
        """Horizontal distance from yaw axis to foot in the initial posture, L0 [m]."""
        return float(np.linalg.norm(self.neutral_feet[0, :2] - np.array(self.legs[0].hip[:2])))

    @cached_property
    def largest_stride(self) -> float:
        """S_max of S0 [m], from the legs' geometry."""
        stretch = reach.largest_stretch(self.legs[0], self.hip_height, self.roughness)
        return reach.largest_stride(stretch, self.stance_reach)

    @cached_property
    def largest_turn(self) -> float:
        """phi_max of S0 [rad], from the legs' geometry."""
        return reach.largest_turn(self.largest_stride, float(self.neutral_feet[0, 1]))

    @cached_property
    def mesh_size(self) -> float:
        """Mesh of S0 eq. 5 [m]: body length between the hip axes plus S_max."""
        return 2.0 * self.legs[0].hip[0] + self.largest_stride

    @cached_property
    def footprint_radius(self) -> float:
        """Radius of the circle around base_link that holds feet and body [m]."""
        feet = float(np.max(np.linalg.norm(self.neutral_feet[:, :2], axis=1))) + self.foot_radius
        return max(feet, math.hypot(self.body_size[0], self.body_size[1]) / 2.0)

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
        return np.stack(
            [leg.forward(joint_angles[..., k, :]) for k, leg in enumerate(self.legs)], axis=-2
        )

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
        angles = np.stack(
            [leg.inverse(feet[..., k, :]) for k, leg in enumerate(self.legs)], axis=-2
        )
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
        """
        jacobians = np.stack(
            [leg.jacobian(joint_angles[..., k, :]) for k, leg in enumerate(self.legs)], axis=-3
        )
        solution = np.linalg.solve(jacobians, foot_velocities[..., None])[..., 0]
        return np.asarray(solution, dtype=np.float64)

    def center_of_mass(self, joint_angles: Array) -> Array:
        """
        Find the centre of mass of body and legs.

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
        moment = np.zeros(joint_angles.shape[:-2] + (3,))
        moment += self.body_mass * np.asarray(self.body_center)
        mass = {kind: link.mass for kind, link in self.links.items()}
        for k, leg in enumerate(self.legs):
            pitch_axis, knee, foot = leg.chain(joint_angles[..., k, :])
            moment += mass['hip'] * (np.asarray(leg.hip) + pitch_axis) / 2.0
            moment += mass['thigh'] * (pitch_axis + knee) / 2.0
            moment += mass['calf'] * (knee + foot) / 2.0
            moment += mass['foot'] * foot
        return moment / self.mass

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
        kind = joint % JOINTS_PER_LEG
        raise JointLimitExceeded(
            self.joint_names[joint],
            float(joint_angles.reshape(-1)[worst]),
            float(self.lower[kind]),
            float(self.upper[kind]),
        )

    def joint_index(self, name: str) -> int:
        """Return the place of a joint in :attr:`joint_names`; raise JointNotFound."""
        try:
            return self.joint_names.index(name)
        except ValueError:
            raise JointNotFound(name, self.joint_names) from None


def available_robots() -> tuple[str, ...]:
    """Return the names of the robots that ship with quadwalk."""
    return tuple(sorted(path.stem for path in _ROBOTS.glob('*.yaml')))


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
    shipped = _ROBOTS / f'{robot}.yaml'
    path = shipped if shipped.is_file() else Path(robot)
    if not path.is_file():
        raise RobotModelError(
            f"there is no robot '{robot}'; available: {', '.join(available_robots())}, "
            f'or the path of a robot data file'
        )
    try:
        document = yaml.safe_load(path.read_text(encoding='utf-8'))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise RobotModelError(f'{path} is not YAML: {" ".join(str(error).split())}') from error
    if not isinstance(document, dict):
        raise RobotModelError(f'{path} must hold a mapping of a robot’s numbers')
    return _robot_from_document(document, path)


class _Numbers:
    """Looks numbers up by their dotted name and remembers where they come from."""

    def __init__(self, document: Mapping[str, Any], path: Path) -> None:
        self._document = document
        self._path = path
        self.sources: dict[str, str] = {}

    def __call__(self, name: str, positive: bool = False) -> float:
        value = self._value(name)
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value):
            raise RobotModelError(f"{self._path}: '{name}' is {value!r}; it must be a number")
        if positive and not value > 0:
            raise RobotModelError(f"{self._path}: '{name}' is {value}; it must be positive")
        return float(value)

    def check_all_used(self, but: tuple[str, ...]) -> None:
        """Raise if the file holds a number that nobody asked for: it may be misspelt."""
        for name in _leaves(self._document, but):
            if name not in self.sources:
                raise RobotModelError(f"{self._path} has '{name}', which means nothing here")

    def is_true(self, name: str) -> bool:
        value = self._value(name)
        if not isinstance(value, bool):
            raise RobotModelError(f"{self._path}: '{name}' is {value!r}; it must be true or false")
        return value

    def _value(self, name: str) -> Any:
        node: Any = self._document
        for key in name.split('.'):
            if not isinstance(node, Mapping) or key not in node:
                raise RobotModelError(f"{self._path} has no number '{name}'")
            node = node[key]
        if not isinstance(node, Mapping) or not node.get('source') or 'value' not in node:
            raise RobotModelError(
                f"{self._path}: '{name}' must be given as {{value: ..., source: ...}}"
            )
        self.sources[name] = str(node['source'])
        return node['value']


def _leaves(node: Mapping[str, Any], but: tuple[str, ...] = (), prefix: str = '') -> Iterator[str]:
    """List the dotted names of a document's numbers."""
    for key, value in node.items():
        if not prefix and key in but:
            continue
        if isinstance(value, Mapping) and 'value' not in value:
            yield from _leaves(value, prefix=f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}'


def _robot_from_document(document: Mapping[str, Any], path: Path) -> Robot:
    number = _Numbers(document, path)
    leg_type = document.get('leg_type')
    if leg_type != 'yaw_pitch_pitch':
        raise RobotModelError(f"{path}: leg_type is {leg_type!r}; available: 'yaw_pitch_pitch'")
    half_length = number('body.hip_half_length', positive=True)
    half_width = number('body.hip_half_width', positive=True)
    legs = tuple(
        YawPitchPitchLeg(
            name=leg,
            hip=(
                half_length if leg.endswith('f') else -half_length,
                half_width if leg.startswith('l') else -half_width,
                0.0,
            ),
            outward=math.pi / 2 if leg.startswith('l') else -math.pi / 2,
            hip_offset=number('leg.hip_offset'),
            hip_drop=number('leg.hip_drop'),
            thigh_length=number('leg.thigh_length', positive=True),
            calf_length=number('leg.calf_length', positive=True),
        )
        for leg in LEGS
    )
    kinds = ('hip_yaw', 'hip_pitch', 'knee_pitch')
    foot_radius = number('leg.foot_radius', positive=True)
    links = {
        kind: LinkShape(
            mass=number(f'leg.{kind}_mass', positive=True),
            radius=foot_radius if kind == 'foot' else number(f'leg.{kind}_radius', positive=True),
        )
        for kind in ('hip', 'thigh', 'calf', 'foot')
    }
    limits = {
        quantity: np.array(
            [
                number(f'joints.{kind}.{quantity}', positive=quantity in ('velocity', 'effort'))
                for kind in kinds
            ]
        )
        for quantity in ('lower', 'upper', 'velocity', 'effort')
    }
    initial = np.array([number(f'initial_posture.{kind}') for kind in kinds])
    robot = Robot(
        name=str(document.get('name', path.stem)),
        legs=legs,
        knee_is_absolute=number.is_true('drive.knee_is_absolute'),
        body_size=(
            number('body.length', positive=True),
            number('body.width', positive=True),
            number('body.height', positive=True),
        ),
        body_center=(0.0, 0.0, number('body.center_height')),
        body_mass=number('body.mass', positive=True),
        links=links,
        joint_kinds=kinds,
        initial_joint_angles=np.tile(initial, (len(LEGS), 1)),
        roughness=number('gait.roughness'),
        sources=number.sources,
        **limits,
    )
    number.check_all_used(but=('name', 'description', 'leg_type', 'stated'))
    for kind, low, high in zip(kinds, robot.lower, robot.upper):
        if not low < high:
            raise RobotModelError(f'{path}: joint {kind} has lower {low} not below upper {high}')
    try:
        robot.check_joint_limits(robot.initial_joint_angles)
    except JointLimitExceeded as error:
        raise RobotModelError(f'{path}: the initial posture is out of range: {error}') from error
    return robot
