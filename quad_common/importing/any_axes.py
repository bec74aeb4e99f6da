"""
Legs whose axes fit no closed formulas: their ranges, and the posture around which they walk.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import LegNotFeasible
from quad_common.importing.chains import LegChain
from quad_common.importing.leg_geometry import LegAtZero
from quad_common.importing.options import Notes
from quad_common.importing.ranges import RangedLeg
from quad_common.serial_legs.aspect import posture_grid
from quad_common.serial_legs.serial_leg import AxesAtZero, SerialLeg, serial_leg

Array = NDArray[np.float64]

_FREE = (1.0, 1.5, 2.4)
"""Half ranges of joints without limits, about their 0, from the body outward [rad]."""

_ANGLES = 25
"""Number of angles of each joint that are tried."""

_HEIGHT = 0.72
"""Depth of the foot below its hip that is wanted, as a fraction of the leg's length."""

_ASIDE, _LIMIT, _REGULAR, _WRONG_SIDE = 0.5, 0.3, 0.5, 0.25
"""Weights of a foot beside its hip, of joints near their limits, of a leg that moves well in all
directions, and of a knee on the side that is not wanted."""

_ASKED = 10.0
"""Weight of the knee's side if it was asked for."""

_SINGULAR = 1e-4
"""Determinant of the Jacobian, of a leg of length 1, below which no posture is of use."""


def serial_leg_of(
    leg: LegAtZero, chain: LegChain, knees: str, notes: Notes, path: Path
) -> RangedLeg:
    """
    Find ranges and a posture of a leg of any three axes.

    Parameters
    ----------
    leg : LegAtZero
        The leg.
    chain : LegChain
        Its joints.
    knees : str
        Where knees are to point, one of :data:`~quad_common.importing.options.KNEES`; backward if
        empty.
    notes : Notes
        What is assumed is added to it.
    path : Path
        The description, for the sentence of the error.

    Raises
    ------
    LegNotFeasible
        If the leg moves its foot in one plane only, in all postures.
    """
    lower, upper = np.empty(3), np.empty(3)
    for k, joint in enumerate(chain.joints):
        is_limited = math.isfinite(joint.lower) and math.isfinite(joint.upper)
        if is_limited and joint.upper - joint.lower < 2.0 * math.pi:
            lower[k], upper[k] = joint.lower, joint.upper
            continue
        lower[k], upper[k] = -_FREE[k], _FREE[k]
        text = f'{math.degrees(_FREE[k]):.0f} degrees from 0'
        notes.assume(f'joints like {joint.name} have no limits: +-{text} are assumed')
    points = np.array([leg.hip, *leg.points[1:]])
    at_zero = AxesAtZero(leg.axes, points, leg.foot)
    grid = posture_grid(lower, upper, _ANGLES).reshape(-1, 3)
    made = serial_leg(leg.name, at_zero, lower, upper, 0.5 * (lower + upper))
    costs = _costs(made, grid, knees, notes)
    best = int(np.argmin(costs))
    if not math.isfinite(costs[best]):
        problem = 'moves its foot in one plane only, however its joints turn'
        raise LegNotFeasible(path, chain.joints[0].name, problem)
    low, high = serial_leg(leg.name, at_zero, lower, upper, grid[best]).window()
    return RangedLeg(serial_leg(leg.name, at_zero, low, high, grid[best]), low, high)


def in_window(ranged: RangedLeg, chain: LegChain, initial: Array, notes: Notes) -> RangedLeg:
    """
    Narrow a leg's ranges to those in which it has one posture for each place.

    Parameters
    ----------
    ranged : RangedLeg
        The leg; one in closed form stays as it is.
    chain : LegChain
        Its joints.
    initial : ndarray, shape (3,)
        Its initial posture [rad].
    notes : Notes
        The ranges that are used of those that are stated are added to it.
    """
    leg = ranged.leg
    if not isinstance(leg, SerialLeg):
        return ranged
    leg = replace(leg, lower=ranged.lower, upper=ranged.upper, nominal=np.array(initial))
    low, high = leg.window()
    for k, joint in enumerate(chain.joints):
        lower, upper = joint.lower, joint.upper
        if not upper - lower < 2.0 * math.pi:
            lower, upper = -_FREE[k], _FREE[k]
        if low[k] > lower or high[k] < upper:
            used = f'{math.degrees(low[k]):.0f} to {math.degrees(high[k]):.0f}'
            given = f'{math.degrees(lower):.0f} to {math.degrees(upper):.0f}'
            text = 'beyond, a foot may be in one place in two postures'
            notes.assume(f'{joint.name} is used from {used} degrees, of {given}: {text}')
    return RangedLeg(replace(leg, lower=low, upper=high), low, high)


def _costs(leg: SerialLeg, postures: Array, knees: str, notes: Notes) -> Array:
    """Judge postures (n, 3) [rad] as ones to stand in, infinite for singular ones, (n,)."""
    length = float(leg.thigh_length + leg.calf_length)
    _, knee, foot = leg.chain(postures)
    arm = (foot - leg.hip) / length
    volume = np.abs(np.linalg.det(leg.jacobian(postures))) / length**3
    middle, half = 0.5 * (leg.upper + leg.lower), 0.5 * (leg.upper - leg.lower)
    spent = np.abs((postures - middle) / half).max(axis=-1)
    costs: Array = np.abs(-arm[:, 2] - _HEIGHT) + _ASIDE * np.linalg.norm(arm[:, :2], axis=-1)
    costs += _LIMIT * spent**8 + _REGULAR * (1.0 - volume / max(float(volume.max()), 1e-300))
    is_front = float(leg.hip[0]) > 0.0
    wanted = {'forward': 1.0, 'inward': -1.0 if is_front else 1.0}
    wanted['outward'] = -wanted['inward']
    ahead = knee[:, 0] - 0.5 * (leg.hip[0] + foot[:, 0])
    is_wrong = ahead * wanted.get(knees, -1.0) < 0.0
    if not knees:
        notes.assume('knees point backward; choose otherwise with --knees')
    costs += (_ASKED if knees else _WRONG_SIDE) * is_wrong
    return np.where(volume < _SINGULAR, np.inf, costs)
