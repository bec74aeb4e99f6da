"""
Writes the data file of an imported robot: every number with its source.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike

from quad_common.errors import FileUnusable
from quad_common.files.bounded_file import is_file, make_folder, read_text
from quad_common.files.whole_file import write_text
from quad_common.importing.options import ASSUMED
from quad_common.importing.own_urdf import own_urdf
from quad_common.importing.robot_import import ImportedRobot
from quad_common.robot.leg_kinematics import Leg
from quad_common.robot.robot_build import LEGS
from quad_common.serial_legs.serial_leg import SerialLeg

_ROUGHNESS = 0.04
"""Depth by which the ground may be lower than expected, as a fraction of the hips' height."""

_STATIC_PERIOD = 7.4
"""Period of static gaits over the root of the hips' height: 4 s at A1's [s / m^0.5]."""

_TROT_PERIOD = 0.65
"""Period of the trot over the root of the hips' height: 0.35 s at A1's [s / m^0.5]."""

_LIFT = 0.15
"""Height to which static gaits lift feet, as a fraction of the hips' height."""

_TROT_LIFT = (0.05, 0.12)
"""Least and largest height to which the trot lifts them."""

_USED = (0.9, 0.8, 0.55)
"""Fractions of what legs and joints allow that a trot uses: forward, sideways, in turns."""

_USED_IN_A_WALK = (0.9, 0.6, 0.5)
"""The same of a walk."""

_SWING_FRACTION = 0.46
"""Part of a trot's period in which a foot is in the air."""

_OF_SPEED_TO_LIFT, _OF_SPEED_AT_MOST = 0.35, 0.5
"""Parts of a knee's speed that a trot in place may take: wanted, and with a longer period."""

_STATIC_SWING, _LONGEST_STATIC = 0.15, 8.0
"""Part of a static gait's period in which a foot is in the air, and its largest period over that
of quick knees."""

_WALK_PERIOD = 1.2
"""Period of a walk over that of a trot: feet swing for a smaller part of it."""

_LONGEST = 2.0
"""Largest period of a trot over that of quick knees: with a longer one bodies fall too far."""

_PLACES = 9
"""Decimal places that are written."""


def write_robot(robot: ImportedRobot, path: Path, meshes: Path | None = None) -> tuple[Path, Path]:
    """
    Write an imported robot's data file, and its URDF beside it.

    Parameters
    ----------
    robot : ImportedRobot
        The robot.
    path : Path
        The data file, ``*.yaml``; folders are made.
    meshes : Path, optional
        Folder for meshes that have to be converted; beside the data file if not given.

    Returns
    -------
    data_file, urdf : Path
        What was written.

    Raises
    ------
    FileUnusable
        If a file cannot be written.
    """
    urdf = urdf_path(path, robot.tree.path)
    meshes = path.with_name(f'{path.stem}_meshes') if meshes is None else meshes
    text = own_urdf(robot, meshes)
    document = robot_document(robot, urdf.name)
    make_folder(path.parent)
    write_text(urdf, text, 'URDF')
    header = (
        f'# Imported by "quadwalk robot import" from {robot.tree.path.name}. Legs are\n'
        "# given each for itself, as docs/robots.md says; angles are those of the robot's joints.\n"
    ) + ''.join(f'{ASSUMED}{" ".join(said.split())}\n' for said in robot.notes.assumed)
    body = yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=100)
    write_text(path, header + body, 'robot data file')
    return path, urdf


def urdf_path(path: Path, source: Path) -> Path:
    """
    Return where the URDF of an imported robot goes: over nothing but what an import has written.

    Parameters
    ----------
    path : Path
        The robot's data file.
    source : Path
        The description that is imported.
    """
    text = ''
    if is_file(path):
        # What cannot be read is nobody's import; whether it can be written over is said later.
        with contextlib.suppress(FileUnusable):
            text = read_text(path)
    for number in itertools.count(1):
        urdf = path.with_name(f'{path.stem}{_suffix(number)}.urdf')
        if not is_file(urdf):
            return urdf
        is_source = is_file(source) and urdf.samefile(source)
        if f'\nurdf: {urdf.name}\n' in text and not is_source:
            return urdf
    raise AssertionError('there is always another number')


def _suffix(number: int) -> str:
    """Return what tells the names of files apart."""
    return '' if number == 1 else '_imported' if number == 2 else f'_imported_{number - 1}'


def robot_document(robot: ImportedRobot, urdf: str) -> dict[str, Any]:
    """
    Put an imported robot into the terms of a data file.

    Parameters
    ----------
    robot : ImportedRobot
        The robot.
    urdf : str
        Path of its URDF, relative to the data file.
    """
    stated = f'{robot.tree.path.name}'
    length, width, height = robot.sizes.body_size.tolist()
    forward, left, up = robot.sizes.body_center.tolist()
    shapes = f'{stated}: shapes'
    radii = {**robot.sizes.radii, 'foot': robot.foot_radius}
    return {
        'name': robot.name,
        'description': f'Imported from {robot.tree.path.name}',
        'leg_type': robot.leg_type,
        'urdf': urdf,
        'names': {
            'joints': [joint.name for chain in robot.chains for joint in chain.joints],
            'feet': [foot.link for foot in robot.feet],
            'falls': [robot.parts.body.link, *(leg[0].link for leg in robot.parts.legs)],
        },
        'body': {
            'length': _number(length, shapes),
            'width': _number(width, shapes),
            'height': _number(height, shapes),
            'center_forward': _number(forward, shapes),
            'center_left': _number(left, shapes),
            'center_height': _number(up, shapes),
            'mass': _number(
                robot.masses.body, f'{stated}: {robot.parts.body.link} and what is fixed to it'
            ),
            'center_of_mass': _number(robot.masses.body_center, stated),
        },
        'leg': {f'{kind}_radius': _number(radius, shapes) for kind, radius in radii.items()},
        'legs': {name: _leg(robot, k, stated) for k, name in enumerate(LEGS)},
        'gait': {
            'roughness': _number(
                _ROUGHNESS * robot.hip_height, 'chosen: 4 % of the height of the hips'
            )
        },
        'gaits': _gaits(robot),
    }


def _leg(robot: ImportedRobot, index: int, stated: str) -> dict[str, Any]:
    ranged = robot.legs[index]
    leg, masses = ranged.leg, robot.masses
    assert masses.inertias is not None
    return {
        **_geometry(leg, stated),
        'lower': _number(ranged.lower, f'{stated}, or assumed'),
        'upper': _number(ranged.upper, f'{stated}, or assumed'),
        'velocity': _number(robot.velocity[index], f'{stated}, or given'),
        'effort': _number(robot.effort[index], f'{stated}, or given'),
        'initial_posture': _number(
            robot.initial[index], 'chosen: upright, the knee bent by a right angle'
        ),
        'masses': _number(masses.parts[index], stated),
        'centers_of_mass': _number(masses.centers[index].reshape(-1), stated),
        'inertias': _number(
            masses.inertias[index][(slice(None), *np.triu_indices(3))].reshape(-1),
            f'{stated}, or replaced',
        ),
    }


def _geometry(leg: Leg, stated: str) -> dict[str, Any]:
    """Put a leg's geometry into the terms of its build."""
    geometry = f'{stated}: axes at 0'
    if isinstance(leg, SerialLeg):
        return {
            'axes': _number(leg.axes.reshape(-1), geometry),
            'points': _number(leg.points.reshape(-1), geometry),
            'foot': _number(leg.foot, f'{stated}: middle of the foot at 0'),
        }
    return {
        'hip': _number(leg.hip, geometry),
        'first_axis': _number(leg.first_axis, geometry),
        'radial_direction': _number(leg.radial_direction, geometry),
        'axial_offset': _number(float(leg.axial_offset), geometry),
        'radial_offset': _number(float(leg.radial_offset), geometry),
        'lateral_offset': _number(float(leg.lateral_offset), geometry),
        'thigh_length': _number(float(leg.thigh_length), geometry),
        'calf_length': _number(float(leg.calf_length), f'{geometry}, to the middle of the foot'),
        'knee_sign': _number(int(float(leg.knee_sign)), f'{stated}: ranges, or assumed'),
        'axis_signs': _number([int(sign) for sign in leg.signs], geometry),
        'zeros': _number(leg.zeros, geometry),
    }


def _gaits(robot: ImportedRobot) -> dict[str, Any]:
    period = _STATIC_PERIOD * math.sqrt(robot.hip_height)
    needed = _speed_to_lift(robot, _LIFT, _STATIC_SWING * period)
    period *= min(_LONGEST_STATIC, max(1.0, needed / _OF_SPEED_AT_MOST))
    static = {
        'cycle_period': _number(period, 'chosen: grows as the root of the height, for quick knees'),
        'swing_height': _number(_LIFT * robot.hip_height, 'chosen: 15 % of the height of the hips'),
    }
    gaits = {name: dict(static) for name in ('crawl', 'turn', 'crab', 'wave')}
    period, lift = _quick_steps(robot)
    gaits['trot'] = _dynamic(period, lift, _USED)
    gaits['walk'] = _dynamic(_WALK_PERIOD * period, lift, _USED_IN_A_WALK)
    return gaits


def _speed_to_lift(robot: ImportedRobot, lift: float, duration: float) -> float:
    """
    Return the fraction of the knees' speed that lifting a foot in place takes.

    A foot that is lifted by h in a swing of the duration t, along half a sine, is as fast as
    pi h / t; the knee of a leg of two equal links l, bent by k, gives it l sin(k / 2) per rad/s.
    """
    bends = [float(leg.leg.bends(angles)) for leg, angles in zip(robot.legs, robot.initial)]
    lever = 0.5 * robot.leg_length * math.sin(0.5 * float(np.mean(bends)))
    speed = float(robot.velocity[:, 2].min())
    return math.pi * lift * robot.hip_height / duration / lever / speed


def _quick_steps(robot: ImportedRobot) -> tuple[float, float]:
    """Choose a trot's period [s] and lift [m]: as quick as the height asks for, if knees are."""
    period, (least, lift) = _TROT_PERIOD * math.sqrt(robot.hip_height), _TROT_LIFT

    def needed(lift: float, period: float) -> float:
        return _speed_to_lift(robot, lift, _SWING_FRACTION * period)

    lift = max(least, lift * min(1.0, _OF_SPEED_TO_LIFT / needed(lift, period)))
    period *= min(_LONGEST, max(1.0, needed(lift, period) / _OF_SPEED_AT_MOST))
    return period, lift * robot.hip_height


def _dynamic(period: float, lift: float, used: tuple[float, float, float]) -> dict[str, Any]:
    return {
        'largest_fractions': _number(used, 'chosen: faster ones leave their course in simulation'),
        'cycle_period': _number(period, 'chosen: grows as the root of the height, for quick knees'),
        'swing_height': _number(lift, 'chosen: so that the knees are fast enough'),
    }


def _number(value: ArrayLike, source: str) -> dict[str, Any]:
    rounded: Any = np.round(np.asarray(value), _PLACES)
    # No minus before a zero.
    return {
        'value': (rounded + 0).tolist() if rounded.dtype.kind == 'i' else (rounded + 0.0).tolist(),
        'source': source,
    }
