"""
The posture that an imported robot stands and walks in.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError, LegNotFeasible
from quad_common.importing.ranges import RangedLeg
from quad_common.importing.sizes import Sizes
from quad_common.robot.exact_masses import ExactMasses
from quad_common.robot.leg_kinematics import Leg, stack_legs
from quad_common.robot.robot_shape import RobotShape
from quad_common.serial_legs.serial_leg import SerialLeg

Array = NDArray[np.float64]

_HEIGHT = 0.72
"""Height of the pitch axes above the feet, as a fraction of the leg's length: the knee is bent by
88 degrees, and the leg reaches as far forward as backward."""

_OTHERS = (0.76, 0.68, 0.80, 0.64, 0.60, 0.84, 0.56, 0.52, 0.88, 0.48)
"""Fractions that are tried where joints do not turn far enough."""

_SPARE = 0.1
"""Angle that joints keep from their limits in the stance [rad]."""

_SPREADS = (0.0, 0.03, 0.06, 0.09, 0.12)
"""Distances by which feet stand farther out than hips, as fractions of the leg's length."""

_WIDER = (0.2, 0.3, 0.4)
"""The same of legs that closed formulas do not hold for, in addition: they may sprawl."""

_ROOM = 0.035
"""Distance between parts that is enough in the stance, as a fraction of the leg's length: in the
crawl the body sways over its feet."""

_WIDTH = 0.5
"""Distance of the feet from the middle line that is enough, as a fraction of the hips' height
above them: narrow robots rock when they trot sideways."""

_EACH = 0.01
"""Weight of the parts' mean room beside the least: where covers overlap in all stances, the other
parts still get theirs."""

_ALL = 2.0 + _EACH
"""Score of a stance with enough room and width."""

_SPRAWL = (0.0, -0.3, 0.3, -0.6)
"""Pitches of sprawling thighs that are tried, from level; positive is downward [rad]."""


def stance(legs: list[RangedLeg], sizes: Sizes, foot_radius: float, path: Path) -> Array:
    """
    Find the initial posture.

    Legs under the body stand with their feet under the pitch axes, and farther out where that
    keeps them off the body; sprawling legs have their thighs level and their calves upright. All
    feet are at one height.

    Parameters
    ----------
    legs : list of RangedLeg
        The four legs.
    sizes : Sizes
        Sizes of the parts.
    foot_radius : float
        Radius of the feet [m].
    path : Path
        The description, for the sentence of the error.

    Returns
    -------
    ndarray, shape (4, 3)
        Joint angles [rad].

    Raises
    ------
    LegNotFeasible
        If the joints' ranges allow none of the postures that are tried.
    """
    stacked = stack_legs([ranged.leg for ranged in legs])
    lower = np.array([ranged.lower for ranged in legs])
    upper = np.array([ranged.upper for ranged in legs])
    size = sizes.body_size.tolist()
    center = sizes.body_center.tolist()
    radii = {**sizes.radii, 'foot': foot_radius}
    shape = RobotShape(stacked, tuple(center), tuple(size), radii)
    length = float(np.mean(stacked.reach()[1]))
    worst, least = 0, math.inf
    for candidates in _candidates([ranged.leg for ranged in legs]):
        best, most = None, -math.inf
        for feet in candidates:
            try:
                angles = stacked.inverse(feet)
            except GaitError:
                continue
            spare = np.minimum(angles - lower, upper - angles)
            if float(spare.min()) < _SPARE:
                if -float(spare.min()) < least:
                    least, worst = -float(spare.min()), int(np.argmin(spare)) // 3
                continue
            score = _score(_rooms(shape, angles) / (_ROOM * length), feet)
            if score > most:
                best, most = angles, score
            if score >= _ALL - 1e-9:
                break
        if best is not None:
            return best
    problem = 'finds no posture to stand in: the ranges of its joints hold none with level feet'
    raise LegNotFeasible(path, str(legs[worst].leg.name), problem)


def _score(rooms: Array, feet: Array) -> float:
    """Judge a stance by its rooms, as fractions of what is enough, and by its width."""
    wide = float(np.abs(feet[:, 1]).min() / np.abs(feet[:, 2]).max())
    rooms = np.clip(rooms, 0.0, 1.0)
    return float(rooms.min()) + min(wide / _WIDTH, 1.0) + _EACH * float(rooms.mean())


def over_feet(legs: list[RangedLeg], masses: ExactMasses, angles: Array) -> Array:
    """
    Shift the feet so that they stand around the center of mass.

    Parameters
    ----------
    legs : list of RangedLeg
        The four legs.
    masses : ExactMasses
        Masses of the robot.
    angles : ndarray, shape (4, 3)
        Posture with the feet around the hips [rad].

    Returns
    -------
    ndarray, shape (4, 3)
        Joint angles [rad]; as given where legs do not reach that far.
    """
    stacked = stack_legs([ranged.leg for ranged in legs])
    chain = stacked.chain(angles)
    feet = chain[2]
    shift = masses.center(stacked, angles, chain) - feet.mean(axis=0)
    try:
        shifted = stacked.inverse(feet + np.array([shift[0], shift[1], 0.0]))
    except GaitError:
        return angles
    lower = np.array([ranged.lower for ranged in legs])
    upper = np.array([ranged.upper for ranged in legs])
    spare = float(np.minimum(shifted - lower, upper - shifted).min())
    return shifted if spare >= _SPARE / 2.0 else angles


def _rooms(shape: RobotShape, angles: Array) -> Array:
    """Return the distances between the body and thighs and calves, negative in it, (n,) [m]."""
    segments = shape.segments(shape.legs.chain(angles))
    with_body = [group for group in shape.groups if group.with_body]
    return np.concatenate([np.ravel(shape.group_clearances(g, segments)) for g in with_body])


def _candidates(legs: list[Leg]) -> Iterator[list[Array]]:
    """Yield places of the four feet in base_link, (4, 3) [m]: by height, then by spread."""
    is_serial = isinstance(legs[0], SerialLeg)
    if not is_serial and abs(float(legs[0].first_axis[2])) > 0.7:
        for pitch in _SPRAWL:
            yield [_level([_sprawled(leg, pitch) for leg in legs])]
        return
    for fraction in (_HEIGHT, *_OTHERS):
        spreads = (*_SPREADS, *_WIDER) if is_serial else _SPREADS
        yield [_level([_upright(leg, fraction, spread) for leg in legs]) for spread in spreads]


def _upright(leg: Leg, fraction: float, spread: float) -> Array:
    """Place a foot under a leg's pitch axis, or as far away but farther out."""
    length = float(leg.thigh_length + leg.calf_length)
    down = float(leg.radial_offset) + math.sqrt(fraction**2 - spread**2) * length
    side = math.copysign(1.0, float(leg.hip[1]))
    if isinstance(leg, SerialLeg):
        depth = math.sqrt(fraction**2 - spread**2) * length
        below: Array = leg.points[1] + np.array([0.0, side * spread * length, -depth])
        return below
    foot: Array = (
        leg.hip
        + leg.first_axis * float(leg.axial_offset)
        + leg.lateral_direction * float(leg.lateral_offset)
        + leg.radial_direction * down
        + np.array([0.0, side * spread * length, 0.0])
    )
    return foot


def _sprawled(leg: Leg, pitch: float) -> Array:
    """Place the foot of a leg straight to the side, the calf upright."""
    thigh = float(leg.thigh_length)
    out = float(leg.radial_offset) + thigh * math.cos(pitch)
    down = thigh * math.sin(pitch) + float(leg.calf_length) - float(leg.axial_offset)
    foot: Array = (
        leg.hip
        + leg.radial_direction * out
        + leg.lateral_direction * float(leg.lateral_offset)
        - leg.first_axis * down
    )
    return foot


def _level(feet: list[Array]) -> Array:
    """Bring feet to the height of the highest of them, so that each leg reaches its own."""
    level = np.array(feet)
    level[:, 2] = level[:, 2].max()
    return level
