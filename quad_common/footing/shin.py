"""
Where the shin of a standing foot passes, so that nothing is in its way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot
from quad_common.rotations import matrix_from_angles

Array = NDArray[np.float64]

_STANCE = (0.5, 0.0, -0.5, -1.0)
"""Position of a foot beside its place under the body, in strides, until it is lifted."""

_ON_SHIN = np.linspace(0.0, 0.7, 8)
"""Points between foot and knee, higher than which no step is."""


_AND_SWAYS = (0.5, -0.5)
"""The same where the body sways: when the foot has landed, and halfway to where it is lifted."""

_ON_LOW_SHIN = np.linspace(0.0, 1.0, 11)
"""The same up to the knee, which is as low as a step below a lowered body."""

_HIND = (2, 3)
"""Legs that come down below the body."""

_ASIDE = 0.02
"""Distance by which a foot is put aside to see how its shin leans then [m, of TITAN-VIII]."""


class Shin(NamedTuple):
    """Points on foot and shin while a foot stands, from the point of the ground below the foot."""

    points: Array
    """Where they are if it stands where it was to stand, shape (n, 3) [m]."""
    rates: Array
    """How far they move as the foot is put aside along x and y, shape (n, 3, 2) [1]."""

    @classmethod
    def empty(cls) -> Shin:
        """Return no points."""
        return cls(np.empty((0, 3)), np.empty((0, 3, 2)))

    @classmethod
    def upright(cls, points: Array) -> Shin:
        """Let points (n, 3) [m] follow a foot that is put aside as far as it goes."""
        return cls(points, np.zeros((*points.shape, 2)))

    def beside(self, offsets: Array) -> Array:
        """
        Return the points for feet that stand aside from where they were to stand.

        Parameters
        ----------
        offsets : ndarray, shape (m, 2)
            By how far [m].

        Returns
        -------
        ndarray, shape (m, n, 3)
            [m]
        """
        moved: Array = self.points + np.einsum('nij,mj->mni', self.rates, offsets)
        return moved


def has_flat_shins(robot: Robot) -> bool:
    """
    Tell whether shins of hind legs lie nearly level where their feet come down below the body.

    They do where knees are behind their feet in the initial posture, as for A1.
    """
    return all(_knee_ahead(robot, leg) < 0.0 for leg in _HIND)


def _knee_ahead(robot: Robot, leg: int) -> float:
    """Return how far a knee is ahead of its foot in the initial posture [m]."""
    foot = robot.neutral_feet[leg]
    knee = robot.legs[leg].chain(robot.legs[leg].inverse(foot))[1]
    return float(knee[0] - foot[0])


def leaning_shin(
    robot: Robot, leg: int, stride: Array, yaw: float, sways: Array | None = None
) -> Shin:
    """
    Place points of foot and shin while the foot stands, wherever it is put.

    A foot that is put aside is followed by its shin in part only: the hip stays where it is.

    Parameters
    ----------
    robot : Robot
        The robot.
    leg : int
        Index of the leg.
    stride : ndarray, shape (2,)
        Motion of the body until the foot is lifted again [m].
    yaw : float
        Heading of the body [rad].
    sways : ndarray, shape (m, 3), optional
        How far the body is beside and above its path at times, in its own axes [m]; only its path
        counts if not given.

    Returns
    -------
    Shin
    """
    stance = _STANCE if sways is None else _AND_SWAYS
    shifts = np.zeros((1, 3)) if sways is None else sways
    far = robot.relative_size * _ASIDE
    turn = _turn(yaw)
    # The foot where it was to stand, and put aside: ahead, behind, to the left, to the right.
    aside = far * np.array([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    feet = _feet(robot, leg, stride @ turn[:2, :2], stance, shifts)
    points = np.array([_points(robot, leg, feet + offset) for offset in aside])
    here, ahead, behind, left, right = points[:, ~np.isnan(points[0, :, 0])]
    rates = np.stack([ahead - behind, left - right], axis=-1) / (2.0 * far)
    # Beside the edge of its reach a leg is followed as one that keeps its posture.
    return Shin(here @ turn.T, turn @ np.nan_to_num(rates) @ turn[:2, :2].T)


def shin_points(robot: Robot, leg: int, stride: Array, yaw: float) -> Array:
    """
    Place points of foot and shin while the foot stands where it was to stand.

    The body goes on by one stride until the foot is lifted again; how it sways meanwhile
    does not count.

    Parameters
    ----------
    robot : Robot
        The robot.
    leg : int
        Index of the leg.
    stride : ndarray, shape (2,)
        Motion of the body until the foot is lifted again [m].
    yaw : float
        Heading of the body [rad].

    Returns
    -------
    ndarray, shape (n, 3)
        Points, measured from the point of the ground below the foot [m].
    """
    turn = _turn(yaw)
    points = _points(
        robot, leg, _feet(robot, leg, stride @ turn[:2, :2], _STANCE, np.zeros((1, 3)))
    )
    turned: Array = points[~np.isnan(points[:, 0])] @ turn.T
    return turned


def points_on_shins(robot: Robot, feet: Array) -> Array:
    """
    Place points of the shins of legs whose feet are somewhere below the body.

    Parameters
    ----------
    robot : Robot
        The robot.
    feet : ndarray, shape (n, 4, 3)
        Centers of the feet, body frame [m].

    Returns
    -------
    ndarray, shape (n, 4, m, 3)
        From the center of the foot upwards, body frame [m]; NaN beyond a leg's reach.
    """
    shins = np.stack([_shins(robot, leg, feet[:, leg]) for leg in range(feet.shape[1])], axis=1)
    points: Array = feet[:, :, None] + _ON_LOW_SHIN[:, None] * shins[:, :, None]
    return points


def _turn(yaw: float) -> Array:
    """Return the rotation about z from the body's axes, shape (3, 3)."""
    return matrix_from_angles(np.array([0.0, 0.0, yaw]))


def _feet(robot: Robot, leg: int, stride: Array, stance: tuple[float, ...], shifts: Array) -> Array:
    """Place the foot in the body's axes, of a body that is beside its path, (n, 3) [m]."""
    feet = np.tile(robot.neutral_feet[leg], (len(shifts), len(stance), 1))
    feet[..., :2] += np.multiply.outer(np.array(stance), stride)
    feet -= shifts[:, None]
    return feet.reshape(-1, 3)


def _points(robot: Robot, leg: int, feet: Array) -> Array:
    """Place the points of feet (n, 3) [m] in the body's axes; NaN beyond the leg's reach."""
    shins = _shins(robot, leg, feet)[:, None]
    points = _ON_SHIN[:, None] * shins
    # The foot rolls under its shin, from where it has landed on.
    landed = shins[~np.isnan(shins[:, 0, 0])][:1]
    if len(landed):
        points[..., :2] += robot.foot_radius * (_lean(shins) - _lean(landed))
    points[..., 2] += robot.foot_radius
    return points.reshape(-1, 3)


def _shins(robot: Robot, leg: int, feet: Array) -> Array:
    """Return the way from foot to knee, shape (n, 3) [m]; NaN beyond the leg's reach."""
    kinematics = robot.legs[leg]
    try:
        shins: Array = kinematics.chain(kinematics.inverse(feet))[1] - feet
    except GaitError:
        if len(feet) == 1:
            return np.full((1, 3), np.nan)
        halves = np.array_split(feet, 2)
        shins = np.concatenate([_shins(robot, leg, half) for half in halves])
    return shins


def _lean(shin: Array) -> Array:
    """By which angles a shin, shape (..., 3), leans to x and y, shape (..., 2) [rad]."""
    return np.arctan2(shin[..., :2], shin[..., 2:])
