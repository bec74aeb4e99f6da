"""
Which directions are up and forward for a robot, and where its middle is.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import LegNotFeasible
from quad_common.importing.chains import LegChain
from quad_common.importing.leg_axes import LegAxes, unlike_formulas
from quad_common.importing.options import DIRECTIONS, Notes
from quad_common.robot.robot_build import LEGS

Array = NDArray[np.float64]

_CLEARLY = 0.5
"""Depth of the feet below the hips, as a fraction of their distance, that tells up from down."""

_LEVEL = 0.7
"""Cosine between a leg's first axis and the vertical above which the axis is upright."""

_FRONT = re.compile(r'(^|[^a-z])f[lr]?([^a-z]|$)|front|fore|(^|[^a-z])[lr]f([^a-z]|$)')
_HIND = re.compile(r'(^|[^a-z])[rhb][lr]([^a-z]|$)|rear|hind|back|(^|[^a-z])[lr][hb]([^a-z]|$)')


def body_frame(
    path: Path, legs: list[LegChain], axes: LegAxes, feet: Array, forward: str, notes: Notes
) -> tuple[Array, str]:
    """
    Find base_link's frame: x forward, y left, z up, in the middle of the hips.

    Parameters
    ----------
    path : Path
        The description, for the sentences of errors.
    legs : list of LegChain
        The four legs.
    axes : LegAxes
        Their axes.
    feet : ndarray, shape (4, 3)
        Their feet at the zero of all joints, in the root's frame [m].
    forward : str
        Where the robot is to walk, one of :data:`~quad_common.importing.options.DIRECTIONS`;
        empty to find it.
    notes : Notes
        What was found and assumed is added to it.

    Returns
    -------
    pose : ndarray, shape (4, 4)
        Takes points of the root's frame to base_link's.
    leg_type : str
        ``roll_pitch_pitch`` or ``yaw_pitch_pitch``; ``serial`` if no closed formulas hold.
    """
    hips = axes.hips
    up = _up(hips, feet, notes)
    first = _common(axes.directions[:, 0])
    is_upright = abs(float(first @ up)) > _LEVEL
    reason = unlike_formulas(legs, axes)
    if reason:
        notes.found.append(
            f'the legs have no closed-form inverse kinematics ({reason}): it is solved iteratively'
        )
        ahead = _ahead_of_serial(up, legs, axes)
    elif is_upright:
        up = first * np.sign(first @ up)
        ahead = _level(np.eye(3)[0], up, np.eye(3)[2])
    else:
        up = _level(up, first, up)
        ahead = first * np.sign(first[int(np.argmax(np.abs(first)))])
    ahead = _forward(ahead, up, legs, axes, forward, notes)
    rotation = np.array([ahead, np.cross(up, ahead), up])
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = -rotation @ hips.mean(axis=0)
    if reason:
        return pose, 'serial'
    if not is_upright and abs(float(first @ ahead)) < _LEVEL:
        problem = (
            'has a first joint that pitches (its axis lies across the body); the first joint must '
            'roll (axis along the body) or yaw (vertical axis)'
        )
        raise LegNotFeasible(path, legs[0].joints[0].name, problem)
    return pose, 'yaw_pitch_pitch' if is_upright else 'roll_pitch_pitch'


def corners(hips: Array, path: Path) -> list[int]:
    """Return the indices of the legs in the order of ``LEGS``, of hips (4, 3) in base_link [m]."""
    order = {
        ('l' if y > 0.0 else 'r') + ('f' if x > 0.0 else 'h'): k for k, (x, y, _) in enumerate(hips)
    }
    if set(order) != set(LEGS):
        raise LegNotFeasible(path, 'placement', 'is not one at each corner of the body')
    return [order[leg] for leg in LEGS]


def _up(hips: Array, feet: Array, notes: Notes) -> Array:
    """Return the direction in which hips spread least, away from the feet."""
    up: Array = np.linalg.svd(hips - hips.mean(axis=0))[2][2]
    arms = feet - hips
    depth = float((arms @ up).mean())
    if abs(depth) > _CLEARLY * float(np.linalg.norm(arms, axis=1).mean()):
        return np.asarray(-up * np.sign(depth))
    main = int(np.argmax(np.abs(up)))
    notes.assume(
        f"up is the root link's +{'xyz'[main]}: the legs at 0 do not show it, they are folded"
    )
    return np.asarray(up * np.sign(up[main]))


def _common(directions: Array) -> Array:
    """Return the direction that four axes have in common, whatever their signs, shape (3,)."""
    common: Array = np.linalg.svd(directions)[2][0]
    return common


def _level(direction: Array, normal: Array, otherwise: Array) -> Array:
    """Return a direction without its part along a unit normal, of length 1."""
    for candidate in (direction, otherwise):
        rest = candidate - normal * float(candidate @ normal)
        length = float(np.linalg.norm(rest))
        if length > 0.1:
            level: Array = rest / length
            return level
    raise AssertionError('one of two directions at right angles is not along the normal')


def _forward(
    ahead: Array, up: Array, legs: list[LegChain], axes: LegAxes, forward: str, notes: Notes
) -> Array:
    """Choose the sign of forward, by what was asked for or by the legs' names."""
    if forward:
        wanted = np.eye(3)[DIRECTIONS.index(forward) // 2]
        wanted = wanted if forward.startswith('+') else -wanted
        chosen = _level(wanted, up, ahead)
        notes.found.append(f"forward is the root link's {forward}, as asked for")
        # Along the legs' axes exactly, where they lie that way.
        along = float(chosen @ ahead)
        return ahead * np.sign(along) if abs(along) > _LEVEL else chosen
    middle = axes.points[:, 1].mean(axis=0)
    votes = sum(
        np.sign((point - middle) @ ahead) * end
        for end, point in zip(_named_ends(legs), axes.points[:, 1])
    )
    named = ahead if votes >= 0.0 else -ahead
    text = _axis_text(named)
    if votes:
        notes.found.append(f"forward is the root link's {text}: the legs' names say so")
    else:
        notes.assume(f"forward is the root link's {text}; choose otherwise with --forward")
    return named


def _named_ends(legs: list[LegChain]) -> list[float]:
    """Return 1 for legs whose names say that they are in front, -1 for hind ones, otherwise 0."""
    ends = []
    for leg in legs:
        name = ' '.join([joint.name for joint in leg.joints[:2]] + list(leg.links[:2])).lower()
        name = re.sub(r'_to_\S*|_2_\S*', ' ', name)
        is_front, is_hind = bool(_FRONT.search(name)), bool(_HIND.search(name))
        ends.append(float(is_front) - float(is_hind))
    return ends


def _ahead_of_serial(up: Array, legs: list[LegChain], axes: LegAxes) -> Array:
    """
    Find the line along which a robot with legs of any axes walks.

    It is across the knees' axes; along them if the names of the legs say so.
    """
    across = _level(_common(axes.directions[:, 2]), up, _common(axes.directions[:, 1]))
    ahead = np.asarray(np.cross(across, up), dtype=np.float64)
    named = np.array(_named_ends(legs)) @ axes.points[:, 1]
    if abs(float(named @ across)) > abs(float(named @ ahead)):
        ahead = across
    signed: Array = ahead * np.sign(ahead[int(np.argmax(np.abs(ahead)))])
    return signed


def _axis_text(direction: Array) -> str:
    main = int(np.argmax(np.abs(direction)))
    return f'{"+" if direction[main] > 0.0 else "-"}{"xyz"[main]}'
