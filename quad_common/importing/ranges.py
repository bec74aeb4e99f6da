"""
How far joints turn, and to which side knees bend.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.importing.chains import LegChain
from quad_common.importing.options import Notes
from quad_common.robot.leg_kinematics import Leg

Array = NDArray[np.float64]

_TURN = 2.0 * math.pi

_ONE_SIDE = 0.2
"""Angle by which a knee's range may pass the straight leg and still be of one side [rad]."""

_BENT = 0.1
"""Angle from straight, and from folded, at which a knee at 0 shows its side [rad]."""

_FREE_FIRST, _FREE_PITCH = 1.0, 2.0
"""Half ranges of first and pitch joints without limits, about straight down, or out [rad]."""

_FREE_KNEE = (0.05, 2.75)
"""Least and largest bend of knees without limits [rad]."""


@dataclass(frozen=True, eq=False)
class RangedLeg:
    """A leg with its ranges."""

    leg: Leg
    """Geometry; its zeros are those turns that put the ranges about the formulas' 0."""
    lower: Array
    """Lower limits, shape (3,) [rad]."""
    upper: Array
    """Upper limits, shape (3,) [rad]."""


def with_ranges(leg: Leg, chain: LegChain, knees: str, notes: Notes) -> RangedLeg:
    """
    Find a leg's ranges and the side of its knee.

    Parameters
    ----------
    leg : Leg
        Geometry of the leg.
    chain : LegChain
        Its joints.
    knees : str
        Where knees are to point, one of :data:`~quad_common.importing.options.KNEES`; empty to
        find it.
    notes : Notes
        What is assumed is added to it.
    """
    zeros = np.array(leg.zeros)
    sign = _knee_sign(leg, chain, knees, notes)
    for k, joint in enumerate(chain.joints):
        ends = _formula_ends(leg, k, joint.lower, joint.upper)
        if ends is not None:
            zeros[k] -= _TURN * round(0.5 * (ends[0] + ends[1]) / _TURN)
    leg = replace(leg, zeros=tuple(zeros.tolist()), knee_sign=sign)
    free = (
        (-_FREE_FIRST, _FREE_FIRST),
        (-_FREE_PITCH, _FREE_PITCH),
        (sign * _FREE_KNEE[0], sign * _FREE_KNEE[1]),
    )
    lower, upper = np.empty(3), np.empty(3)
    for k, joint in enumerate(chain.joints):
        ends = _formula_ends(leg, k, joint.lower, joint.upper)
        if ends is None:
            ends = free[k]
            kind = ('first joints', 'pitch joints', 'knees')[k]
            own = np.degrees(np.sort(np.abs(ends)))
            text = f'{own[0]:.0f} to {own[1]:.0f}' if k == 2 else f'+-{own[1]:.0f}'
            notes.assume(f'{kind} have no limits: {text} degrees from the straight leg are assumed')
        own_ends = [leg.signs[k] * (end - zeros[k]) for end in ends]
        lower[k], upper[k] = min(own_ends), max(own_ends)
    leg = replace(leg, middles=tuple((0.5 * (lower + upper)).tolist()))
    return RangedLeg(leg, lower, upper)


def _formula_ends(leg: Leg, joint: int, lower: float, upper: float) -> tuple[float, float] | None:
    """Return a range in the formulas' angles; None without limits, or with those of a full turn."""
    if not (math.isfinite(lower) and math.isfinite(upper)) or upper - lower >= _TURN - 1e-6:
        return None
    ends = [float(leg.zeros[joint] + leg.signs[joint] * own) for own in (lower, upper)]
    return min(ends), max(ends)


def _knee_sign(leg: Leg, chain: LegChain, knees: str, notes: Notes) -> float:
    """Return the sign of the knee's angle in the formulas: the user's, the range's, the pose's."""
    is_upright = abs(float(leg.first_axis[2])) > 0.7
    if is_upright:
        # Sprawling legs stand with their knees up.
        return 1.0
    is_front = float(leg.hip[0]) > 0.0
    if knees:
        forward = {'forward': True, 'backward': False, 'inward': not is_front, 'outward': is_front}
        return 1.0 if forward[knees] else -1.0
    ends = _formula_ends(leg, 2, chain.joints[2].lower, chain.joints[2].upper)
    if ends is not None:
        turns = _TURN * round(0.5 * (ends[0] + ends[1]) / _TURN)
        low, high = ends[0] - turns, ends[1] - turns
        if high <= _ONE_SIDE:
            return -1.0
        if low >= -_ONE_SIDE:
            return 1.0
    bend = float(leg.zeros[2])
    if _BENT < abs(bend) < math.pi - _BENT:
        return math.copysign(1.0, bend)
    notes.assume('knees point backward; choose otherwise with --knees')
    return -1.0
