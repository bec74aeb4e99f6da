"""
What a data file says of a robot whose legs are each given for themselves.

Such a file is written by ``quadwalk robot import``: nothing in it is mirrored, joints and links
have the names of the robot's own URDF, and that URDF lies beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    AxisNotAUnitVector,
    InitialPostureSingular,
    JointRangeEmpty,
    RobotValueInvalid,
    SingularPosture,
)
from quad_common.files.yaml_document import check_keys
from quad_common.robot.exact_masses import ExactMasses
from quad_common.robot.leg_kinematics import Leg
from quad_common.robot.robot_build import (
    JOINTS_PER_LEG,
    LEG_TYPES,
    LEGS,
    LONGEST_PART_NAME,
    LinkShape,
    PartNames,
)
from quad_common.robot_files.robot_numbers import RobotNumbers
from quad_common.serial_legs.serial_leg import AxesAtZero, SerialLeg, serial_leg

Array = NDArray[np.float64]

NAMES_OF_IMPORTED = ('urdf', 'names')
"""Keys of such a file that hold no number."""

_ROUNDED = 1e-8
"""Moment of inertia by which numbers in a file may be off [kg m^2]."""

_UNIT = 1e-6
"""Deviation from 1 of a unit vector's length, and from 0 of the cosine of a right angle."""


@dataclass(frozen=True, eq=False)
class LegJoints:
    """The four legs and what their joints can do, arrays of shape (4, 3)."""

    legs: tuple[Leg, ...]
    """Legs in the order of ``LEGS``."""
    lower: Array
    """Lower limits of the joints [rad]."""
    upper: Array
    """Upper limits of the joints [rad]."""
    velocity: Array
    """Largest speeds of the joints [rad/s]."""
    effort: Array
    """Largest torques of the joints [N m]."""
    initial: Array
    """Initial posture [rad]."""


def imported_joints(number: RobotNumbers, kinds: tuple[str, ...], path: Path) -> LegJoints:
    """
    Read four legs, each with its own geometry and limits.

    Raises
    ------
    RobotModelError
        If an entry is missing or invalid, an axis is no unit vector, a range is empty, or a leg
        in its initial posture cannot move its foot in every direction.
    """
    rows = {
        quantity: np.array([number.vector(f'legs.{leg}.{quantity}') for leg in LEGS])
        for quantity in ('lower', 'upper', 'velocity', 'effort', 'initial_posture')
    }
    for leg, lower, upper in zip(LEGS, rows['lower'], rows['upper']):
        for kind, low, high in zip(kinds, lower, upper):
            if not low < high:
                raise JointRangeEmpty(path, f'{leg} {kind}', float(low), float(high))
    if kinds == LEG_TYPES['serial']:
        bounds = zip(rows['lower'], rows['upper'], rows['initial_posture'])
        legs: tuple[Leg, ...] = tuple(
            _serial_leg(number, leg, path, own) for leg, own in zip(LEGS, bounds)
        )
    else:
        middles = 0.5 * (rows['lower'] + rows['upper'])
        legs = tuple(_leg(number, leg, path, middle) for leg, middle in zip(LEGS, middles))
    return LegJoints(
        legs=legs,
        lower=rows['lower'],
        upper=rows['upper'],
        velocity=rows['velocity'],
        effort=rows['effort'],
        initial=rows['initial_posture'],
    )


def _leg(number: RobotNumbers, name: str, path: Path, middles: Array) -> Leg:
    first = _unit_vector(number, f'legs.{name}.first_axis', path)
    radial = _unit_vector(number, f'legs.{name}.radial_direction', path)
    if abs(float(first @ radial)) > _UNIT:
        valid = 'at right angles to first_axis'
        raise RobotValueInvalid(
            f'legs.{name}.radial_direction', radial.tolist(), valid, f'{path}: '
        )
    return Leg(
        name=name,
        hip=number.vector(f'legs.{name}.hip'),
        first_axis=first,
        radial_direction=radial,
        axial_offset=number(f'legs.{name}.axial_offset'),
        radial_offset=number(f'legs.{name}.radial_offset'),
        lateral_offset=number(f'legs.{name}.lateral_offset'),
        thigh_length=number(f'legs.{name}.thigh_length'),
        calf_length=number(f'legs.{name}.calf_length'),
        knee_sign=number.sign(f'legs.{name}.knee_sign'),
        signs=number.signs(f'legs.{name}.axis_signs'),
        zeros=number.vector(f'legs.{name}.zeros'),
        middles=middles,
    )


def _serial_leg(
    number: RobotNumbers, name: str, path: Path, bounds: tuple[Array, Array, Array]
) -> SerialLeg:
    """Read a leg of any three axes; `bounds` are lower and upper limits and initial posture."""
    leg = serial_leg(name, _axes(number, name, path), *bounds)
    try:
        # Its inverse starts from there: with a singular posture it finds nothing.
        leg.joint_velocities(bounds[2], np.zeros(3))
    except SingularPosture as error:
        raise InitialPostureSingular(path, f'legs.{name}.initial_posture', error) from error
    return leg


def _axes(number: RobotNumbers, name: str, path: Path) -> AxesAtZero:
    axes = number.vector(f'legs.{name}.axes', 9).reshape(3, 3)
    for axis in axes:
        if abs(float(np.linalg.norm(axis)) - 1.0) > _UNIT:
            raise AxisNotAUnitVector(path, f'legs.{name}.axes', tuple(axis.tolist()))
    points = number.vector(f'legs.{name}.points', 9).reshape(3, 3)
    return AxesAtZero(axes, points, number.vector(f'legs.{name}.foot'))


def _unit_vector(number: RobotNumbers, name: str, path: Path) -> Array:
    vector = number.vector(name)
    if abs(float(np.linalg.norm(vector)) - 1.0) > _UNIT:
        raise AxisNotAUnitVector(path, name, tuple(vector.tolist()))
    return vector


def imported_links(number: RobotNumbers) -> dict[str, LinkShape]:
    """Read how thick the links are; their masses are the means of the four legs'."""
    masses = np.array([number.vector(f'legs.{leg}.masses') for leg in LEGS]).mean(axis=0)
    shares = dict(zip(('hip', 'thigh', 'calf'), masses.tolist()), foot=0.0)
    return {
        kind: LinkShape(mass=mass, radius=number(f'leg.{kind}_radius'))
        for kind, mass in shares.items()
    }


def exact_masses(number: RobotNumbers) -> ExactMasses:
    """Read the masses of all parts, their centers, and their inertias where there are any."""
    centers = [number.vector(f'legs.{leg}.centers_of_mass', 9) for leg in LEGS]
    inertias = None
    # Older files have none.
    if any(number.has(f'legs.{leg}.inertias') for leg in LEGS):
        inertias = np.array([_inertias(number, leg) for leg in LEGS])
    return ExactMasses(
        body=number('body.mass'),
        body_center=number.vector('body.center_of_mass'),
        parts=np.array([number.vector(f'legs.{leg}.masses') for leg in LEGS]),
        centers=np.reshape(centers, (len(LEGS), JOINTS_PER_LEG, 3)),
        inertias=inertias,
    )


def _inertias(number: RobotNumbers, leg: str) -> Array:
    """Read the inertias of a leg's parts, xx, xy, xz, yy, yz and zz each, as (3, 3, 3)."""
    given = number.vector(f'legs.{leg}.inertias', 18).reshape(JOINTS_PER_LEG, 6)
    rows, columns = np.triu_indices(3)
    inertias = np.empty((JOINTS_PER_LEG, 3, 3))
    inertias[:, rows, columns] = inertias[:, columns, rows] = given
    # Rounded, of a part without any size: not below zero by more than that.
    if float(np.linalg.eigvalsh(inertias).min()) < -_ROUNDED:
        raise number.invalid(f'legs.{leg}.inertias', given.ravel(), 'moments of inertia above 0')
    return inertias


def part_names(document: Mapping[str, Any], path: Path) -> PartNames:
    """
    Read the names of joints and links.

    Raises
    ------
    RobotModelError
        If they are not what the file must name, or one joint is named twice.
    """
    names = document.get('names')
    if not isinstance(names, Mapping):
        raise RobotValueInvalid('names', names, 'a mapping with joints, feet, falls', f'{path}: ')
    check_keys(names, ('joints', 'feet', 'falls'), 'names')
    joints = _names(names, 'joints', path, JOINTS_PER_LEG * len(LEGS))
    feet = _names(names, 'feet', path, len(LEGS))
    return PartNames(joints, feet, frozenset(_names(names, 'falls', path)))


def _names(names: Mapping[str, Any], key: str, path: Path, count: int = 0) -> tuple[str, ...]:
    """Read a list of different names; of any length if no count is given."""
    given: Any = names.get(key)
    is_list = isinstance(given, list) and all(isinstance(name, str) for name in given)
    if not is_list or (count and len(given) != count):
        valid = f'a list of {count} names' if count else 'a list of names'
        raise RobotValueInvalid(f'names.{key}', given, valid, f'{path}: ')
    for place, name in enumerate(given):
        valid = ''
        if not (0 < len(name) <= LONGEST_PART_NAME and name.isprintable()):
            valid = f'a text of 1 to {LONGEST_PART_NAME} printable characters, without line breaks'
        elif name in given[:place]:
            valid = 'another name than those before it'
        if valid:
            raise RobotValueInvalid(f'names.{key}[{place}]', name, valid, f'{path}: ')
    return tuple(given)
