"""
Reads robots' data files: YAML in which every number carries its source.

The robots that ship lie in ``quad_common/robots``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    CenterOfMassBelowGround,
    FileUnusable,
    InitialPostureOutOfRange,
    JointLimitExceeded,
    JointRangeEmpty,
    LegTypeUnknown,
    LinkTooThick,
    OutOfRange,
    RobotEntryInvalid,
    RobotFileMissing,
    RobotFileUnusable,
    RobotNameInvalid,
    RobotUnknown,
    RobotValueOutOfRange,
    UnknownKey,
)
from quad_common.files.bounded_file import is_file, user_path
from quad_common.files.package_path import is_in_package, is_package_found
from quad_common.files.yaml_document import check_keys, in_file, read_yaml
from quad_common.named_robots.known_robots import known_names
from quad_common.named_robots.robot_cache import DESCRIPTIONS, imported_file, known_robot_file
from quad_common.robot.leg_builds import (
    LegLengths,
    LegPlace,
    roll_pitch_pitch_leg,
    yaw_pitch_pitch_leg,
)
from quad_common.robot.leg_kinematics import Leg
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEG_TYPES, LEGS, GaitSettings, LinkShape, PartNames
from quad_common.robot_files.imported_entries import (
    NAMES_OF_IMPORTED,
    LegJoints,
    exact_masses,
    imported_joints,
    imported_links,
    part_names,
)
from quad_common.robot_files.named_urdf import named_urdf
from quad_common.robot_files.robot_numbers import RobotNumbers

Array = NDArray[np.float64]

_QUANTITIES = ('lower', 'upper', 'velocity', 'effort')

_NOT_NUMBERS = ('name', 'description', 'leg_type', 'stated')
"""Keys of a robot data file that hold no number of the robot."""

_GAIT_KEYS = ('cycle_period', 'swing_height', 'largest_fractions')
"""What a robot may change in a gait."""

_WHAT = 'robot data file'

_THICKEST = 0.5
"""Largest radius of a link over the length of thigh and calf: with more it is in the ground, and
imports have 0.35 at most."""

_LONGEST_NAME = 64
"""Characters of a robot's name."""

ROBOTS_FOLDER = Path(__file__).parents[1] / 'robots'
"""Where the robots that ship are."""


def available_robots() -> tuple[str, ...]:
    """Return the names of the robots that ship with quadwalk."""
    return tuple(sorted(path.stem for path in ROBOTS_FOLDER.glob('*.yaml')))


def robot_file(robot: str | Path) -> Path:
    """
    Find the data file of a robot.

    Parameters
    ----------
    robot : str or Path
        Name of one that ships (``titan_viii``) or of one whose description is installed
        (``a1``), path of a data file, ``package://PACKAGE/path`` of one, or a description (URDF,
        xacro, MJCF), which is imported.

    Returns
    -------
    Path
        The data file.

    Raises
    ------
    RobotModelError
        If there is no such robot.
    DescriptionError
        If it is to be imported and cannot be.
    """
    shipped = ROBOTS_FOLDER / f'{robot}.yaml'
    try:
        path = shipped if is_file(shipped) else user_path(robot, _WHAT)
        if is_file(path):
            return imported_file(path) if path.suffix in DESCRIPTIONS else path
        known = known_robot_file(str(robot))
    except FileUnusable as error:
        raise error.of_kind(RobotFileUnusable) from error
    if known is None:
        raise _unknown(str(robot))
    return known


def _unknown(robot: str) -> RobotUnknown:
    """Say that there is no such robot: no such name, or no such file."""
    available = (*available_robots(), *known_names())
    if is_in_package(robot):
        package = robot.partition('://')[2].partition('/')[0]
        return RobotFileMissing(robot, available, package, is_package_found(robot))
    if '/' in robot or robot.endswith(('.yaml', *DESCRIPTIONS)):
        return RobotFileMissing(robot, available)
    return RobotUnknown(robot, available)


def load_robot(robot: str | Path) -> Robot:
    """
    Load a robot by the name of one that ships, or from a data file.

    Parameters
    ----------
    robot : str or Path
        As for :func:`robot_file`.

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
        raise error.of_kind(RobotFileUnusable) from error
    except (OutOfRange, UnknownKey) as error:
        raise in_file(error, _WHAT, path, RobotEntryInvalid, RobotValueOutOfRange) from error


def _robot_from_document(document: Mapping[str, Any], path: Path) -> Robot:
    number = RobotNumbers(document, path)
    leg_type = _leg_type(document, path)
    kinds = LEG_TYPES[leg_type]
    name = _name(document, path)
    # Asked for first: what either format misspells is told from what it leaves out.
    is_imported = number.has('legs') or leg_type == 'serial'
    joints = imported_joints(number, kinds, path) if is_imported else _joints(number, kinds, path)
    names = part_names(document, path) if is_imported else PartNames.of_kinds(kinds)
    robot = Robot(
        name=name,
        leg_type=leg_type,
        legs=joints.legs,
        knee_is_absolute=number.is_true('drive.knee_is_absolute'),
        body_size=(
            number('body.length'),
            number('body.width'),
            number('body.height'),
        ),
        body_center=(
            number.or_zero('body.center_forward'),
            number.or_zero('body.center_left'),
            number('body.center_height'),
        ),
        body_mass=number('body.mass'),
        links=imported_links(number) if is_imported else _links(number),
        joint_kinds=kinds,
        lower=joints.lower,
        upper=joints.upper,
        velocity=joints.velocity,
        effort=joints.effort,
        initial_joint_angles=joints.initial,
        roughness=number('gait.roughness'),
        gaits=_gaits(number),
        sources=number.sources,
        part_names=names,
        exact_masses=exact_masses(number) if is_imported else None,
        own_urdf=named_urdf(document, names, path) if is_imported else '',
    )
    number.check_all_used(but=(*_NOT_NUMBERS, *(NAMES_OF_IMPORTED if is_imported else ())))
    _check_radii(robot, path)
    _check_posture(robot, path)
    return robot


def _check_radii(robot: Robot, path: Path) -> None:
    """Raise if a link is thicker than legs are: every number may be in its range for itself."""
    length = float(np.mean([leg.thigh_length + leg.calf_length for leg in robot.legs]))
    for kind, link in robot.links.items():
        if link.radius > _THICKEST * length:
            name, most = f'leg.{kind}_radius', _THICKEST * length
            raise LinkTooThick(path, name, link.radius, length, most)


def _check_posture(robot: Robot, path: Path) -> None:
    """Raise unless the robot could stand in its initial posture."""
    posture = robot.initial_joint_angles
    try:
        robot.check_joint_limits(posture)
    except JointLimitExceeded as error:
        raise InitialPostureOutOfRange(path, error) from error
    if not robot.center_height > 0.0:
        raise CenterOfMassBelowGround(path, robot.center_height)


def _joints(number: RobotNumbers, kinds: tuple[str, ...], path: Path) -> LegJoints:
    """Read legs that are all of one build: each is the mirror image of the one that is written."""
    build = _roll_leg if kinds == LEG_TYPES['roll_pitch_pitch'] else _yaw_leg
    legs = tuple(build(number, LegPlace(leg, _hip(number, leg), _side(leg))) for leg in LEGS)
    limits = _joint_limits(number, kinds, path)
    initial = np.array([number(f'initial_posture.{kind}') for kind in kinds])
    signs = np.array([_signs_of_the_file(kinds, leg) for leg in legs])
    ends = signs * limits['lower'], signs * limits['upper']
    return LegJoints(
        legs=legs,
        lower=np.minimum(*ends),
        upper=np.maximum(*ends),
        velocity=np.tile(limits['velocity'], (len(LEGS), 1)),
        effort=np.tile(limits['effort'], (len(LEGS), 1)),
        initial=signs * initial,
    )


def _leg_type(document: Mapping[str, Any], path: Path) -> str:
    leg_type = document.get('leg_type')
    if not isinstance(leg_type, str) or leg_type not in LEG_TYPES:
        raise LegTypeUnknown(path, leg_type, tuple(LEG_TYPES))
    return leg_type


def _name(document: Mapping[str, Any], path: Path) -> str:
    name = document.get('name', path.stem)
    if not isinstance(name, str) or len(name) > _LONGEST_NAME or not name.isprintable():
        raise RobotNameInvalid(path, name, _LONGEST_NAME)
    return name


def _links(number: RobotNumbers) -> dict[str, LinkShape]:
    foot_radius = number('leg.foot_radius')
    return {
        kind: LinkShape(
            mass=number(f'leg.{kind}_mass'),
            radius=foot_radius if kind == 'foot' else number(f'leg.{kind}_radius'),
        )
        for kind in ('hip', 'thigh', 'calf', 'foot')
    }


def _joint_limits(number: RobotNumbers, kinds: Iterable[str], path: Path) -> dict[str, Array]:
    limits = {
        quantity: np.array([number(f'joints.{kind}.{quantity}') for kind in kinds])
        for quantity in _QUANTITIES
    }
    for kind, low, high in zip(kinds, limits['lower'], limits['upper']):
        if not low < high:
            raise JointRangeEmpty(path, kind, float(low), float(high))
    return limits


def _side(leg: str) -> int:
    """Return +1 for a left leg and -1 for a right one."""
    return 1 if leg.startswith('l') else -1


def _hip(number: RobotNumbers, leg: str) -> tuple[float, float, float]:
    half_length = number('body.hip_half_length')
    half_width = number('body.hip_half_width')
    return half_length if leg.endswith('f') else -half_length, _side(leg) * half_width, 0.0


def _lengths(number: RobotNumbers) -> LegLengths:
    return LegLengths(
        hip_offset=number('leg.hip_offset'),
        hip_drop=number('leg.hip_drop'),
        thigh=number('leg.thigh_length'),
        calf=number('leg.calf_length'),
    )


def _yaw_leg(number: RobotNumbers, place: LegPlace) -> Leg:
    return yaw_pitch_pitch_leg(
        place,
        _lengths(number),
        lateral_offset=number.or_zero('leg.lateral_offset'),
        signs=number.signs(f'leg.axis_signs.{place.name}'),
    )


def _roll_leg(number: RobotNumbers, place: LegPlace) -> Leg:
    return roll_pitch_pitch_leg(
        place,
        _lengths(number),
        knee_sign=number.sign(f'leg.knee_sign_{"front" if place.name.endswith("f") else "hind"}'),
        forward_offset=number.or_zero('leg.forward_offset'),
        signs=number.signs(f'leg.axis_signs.{place.name}'),
    )


def _signs_of_the_file(kinds: tuple[str, ...], leg: Leg) -> Array:
    """
    Say which of a leg's angles stand in the file with the other sign, shape (3,).

    For roll legs the file has those of a left leg with knee_sign +1: roll is mirrored
    by side, and pitch and knee by knee_sign. Yaw legs are all written alike.
    """
    signs = np.array(leg.signs)
    if kinds == LEG_TYPES['roll_pitch_pitch']:
        signs *= [_side(str(leg.name)), float(leg.knee_sign), float(leg.knee_sign)]
    return signs


def _setting(number: RobotNumbers, gait: str, key: str) -> Any:
    name = f'gaits.{gait}.{key}'
    if key != 'largest_fractions':
        return number(name)
    return tuple(number.vector(name).tolist())


def _gaits(number: RobotNumbers) -> dict[str, GaitSettings]:
    gaits = {}
    for name in number.names_under('gaits'):
        changed = number.names_under(f'gaits.{name}')
        check_keys(dict.fromkeys(changed), _GAIT_KEYS, f'gaits.{name}')
        gaits[name] = GaitSettings(**{key: _setting(number, name, key) for key in changed})
    return gaits
