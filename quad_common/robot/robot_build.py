"""
How a quadruped is built: legs, masses, limits and the posture it walks in, as numbers.

Joint arrays have one row per leg, in the order :data:`LEGS`, and one column per joint of
a leg, from the body outward.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.exact_masses import ExactMasses
from quad_common.robot.leg_kinematics import Leg

Array = NDArray[np.float64]

LEGS = ('lf', 'rf', 'lh', 'rh')
"""Left front, right front, left hind, right hind: the order of every per-leg array."""

JOINTS_PER_LEG = 3

LONGEST_PART_NAME = 200
"""Characters of the name of a joint or a link."""

LEG_TYPES = {
    'yaw_pitch_pitch': ('hip_yaw', 'hip_pitch', 'knee_pitch'),
    'roll_pitch_pitch': ('hip_roll', 'hip_pitch', 'knee_pitch'),
    # Any three axes, of robots that were imported.
    'serial': ('first_joint', 'second_joint', 'third_joint'),
}
"""The builds that a leg may have, and the kinds of their joints from the body outward."""


@dataclass(frozen=True)
class LinkShape:
    """A link as a solid of revolution: enough for inertia, collision and pictures."""

    mass: float
    """Mass [kg]."""
    radius: float
    """Radius about its axis [m]."""


@dataclass(frozen=True)
class PartNames:
    """Names of a robot's joints and links, on topics and in its URDF."""

    joints: tuple[str, ...]
    """Names of the twelve joints, leg by leg."""
    feet: tuple[str, ...]
    """Names of the links that stand on the ground, one for each leg."""
    falls: frozenset[str]
    """Names of the links that touch the ground only if the robot has fallen."""

    @classmethod
    def of_kinds(cls, joint_kinds: tuple[str, ...]) -> PartNames:
        """Name the parts of a robot by the legs and the kinds of their joints."""
        return cls(
            joints=tuple(f'{leg}_{kind}_joint' for leg in LEGS for kind in joint_kinds),
            feet=tuple(f'{leg}_foot' for leg in LEGS),
            falls=frozenset({'base_link', *(f'{leg}_hip' for leg in LEGS)}),
        )


@dataclass(frozen=True)
class GaitSettings:
    """What a robot changes in a gait; None leaves it as the gait has it."""

    cycle_period: float | None = None
    """Duration of a cycle [s]."""
    swing_height: float | None = None
    """Height to which feet are lifted [m]."""
    largest_fractions: tuple[float, float, float] | None = None
    """Fractions of what legs and joints allow that are walked at most forward, sideways and in
    turns: of a gait whose dynamics allow less."""


@dataclass(frozen=True)
class RobotBuild:
    """The numbers of a robot; :class:`~quad_common.robot.robot.Robot` adds what follows."""

    name: str
    """Name of the robot."""
    leg_type: str
    """Build of the legs, one of :data:`LEG_TYPES`."""
    legs: tuple[Leg, ...]
    """Legs in the order of :data:`LEGS`."""
    knee_is_absolute: bool
    """Whether the knee drives work from the horizontal (a pantograph)."""
    body_size: tuple[float, float, float]
    """Length, width and height of the body's box [m]."""
    body_center: tuple[float, float, float]
    """Center of the box, in base_link [m]; of the body's mass too without exact masses."""
    body_mass: float
    """Mass of the body without its legs [kg]."""
    links: Mapping[str, LinkShape]
    """Links of a leg: ``hip``, ``thigh``, ``calf``, ``foot``."""
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
    """Depth by which the ground may be lower than expected, S0's dh + dv [m]."""
    gaits: Mapping[str, GaitSettings]
    """Gaits that suit the robot, and what it changes in them."""
    sources: Mapping[str, str] = field(repr=False)
    """Sources of the data file's numbers, by their dotted names."""
    part_names: PartNames = field(repr=False)
    """Names of joints and links."""
    exact_masses: ExactMasses | None = field(default=None, repr=False)
    """Masses and their centers, where they are known link by link."""
    own_urdf: str = field(default='', repr=False)
    """Text of the robot's own URDF, with base_link's frame at its root; empty if it has none."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The twelve joints, leg by leg."""
        return self.part_names.joints

    @property
    def foot_radius(self) -> float:
        """Radius of the foot's ball [m]: its center is the leg's end point."""
        return self.links['foot'].radius

    @property
    def mass(self) -> float:
        """Mass of the whole robot [kg]."""
        if self.exact_masses is not None:
            return self.exact_masses.total
        return self.body_mass + len(LEGS) * sum(link.mass for link in self.links.values())
