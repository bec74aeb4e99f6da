"""
The moments that legs exert on a robot and its joints: their weight and inertia, link by link.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.exact_masses import ExactMasses
from quad_common.robot.leg_kinematics import Leg
from quad_common.robot.robot import Robot

Array = NDArray[np.float64]

GRAVITY = 9.80665
"""[m/s^2]"""

_STEP = 1e-5
"""Step of joint angles, for a difference quotient [rad]."""


class LegCycle(NamedTuple):
    """Motion of four legs that repeats, at n even times without that at which it begins again."""

    joints: Array
    """Joint angles, shape (n, 4, 3) [rad]."""
    heights: Array
    """Heights of base_link above the ground, shape (n,) [m]."""
    period: float
    """Time after which it repeats [s]."""


def leg_moments(legs: Leg, masses: ExactMasses, cycle: LegCycle) -> Array:
    """
    Add up what the legs' weight and inertia do about the ground below base_link.

    By the balance of angular momentum about a point on the ground: of masses m at r = (x, y, z)
    that turn with angular velocities omega and have inertias I, the sum of

        m (g x - z x'' + x z'') - (I omega)'_y  and  m (g y - z y'' + y z'') + (I omega)'_x

    is what a mass would exert that stands ahead, or to the left, by as much over its weight. The
    body neither turns nor accelerates but upward; what its own acceleration adds is not in it.

    Parameters
    ----------
    legs : Leg
        The four stacked legs.
    masses : ExactMasses
        Masses of the legs' parts, with their inertias.
    cycle : LegCycle
        How the legs move.

    Returns
    -------
    ndarray, shape (n, 2)
        Moments forward and to the left [N m].

    Raises
    ------
    ValueError
        If the inertias are not known.
    """
    if masses.inertias is None:
        raise ValueError('the inertias of the links are not known')
    shape = (*cycle.joints.shape[:-1], 3)
    moments = np.zeros((len(cycle.joints), 2))
    for part, (start, axes) in enumerate(legs.part_frames(cycle.joints, legs.chain(cycle.joints))):
        frame = np.stack([np.broadcast_to(axis, shape) for axis in axes], axis=-2)
        place = np.broadcast_to(masses.places(part, start, axes), shape).copy()
        place[..., 2] += cycle.heights[:, None]
        momentum = _angular_momentum(frame, masses.inertias[:, part], cycle.period)
        acceleration = _rate(_rate(place, cycle.period), cycle.period)
        turning = _rate(momentum, cycle.period)
        along, height = place[..., :2], place[..., 2, None]
        pull = (GRAVITY + acceleration[..., 2, None]) * along - height * acceleration[..., :2]
        pull *= masses.parts[:, part, None]
        pull += np.stack([-turning[..., 1], turning[..., 0]], axis=-1)
        moments += pull.sum(axis=-2)
    return moments


def weight_torques(robot: Robot, joint_angles: Array, up: Array) -> Array:
    """
    Find the torques that hold the weight of the legs themselves, feet in the air.

    They are the slope of the potential energy: m g times that of the center of mass.

    Parameters
    ----------
    robot : Robot
        The robot.
    joint_angles : ndarray, shape (..., 4, 3)
        [rad].
    up : ndarray, shape (3,)
        The vertical, upward, in the body's axes.

    Returns
    -------
    ndarray, shape (..., 4, 3)
        [N m].
    """
    shape = joint_angles.shape[-2:]
    joints = shape[0] * shape[1]
    change = _STEP * np.eye(joints).reshape(joints, *shape)
    angles = joint_angles[..., None, :, :]
    height = robot.center_of_mass(np.stack([angles + change, angles - change])) @ up
    slope = (height[0] - height[1]) / (2.0 * _STEP)
    torques: Array = robot.mass * GRAVITY * slope.reshape(joint_angles.shape)
    return torques


def _angular_momentum(frame: Array, inertia: Array, period: float) -> Array:
    """Return I omega of parts with axes (n, 4, 3, 3), in rows, and inertias (4, 3, 3) in them."""
    # R' R^T is omega as a matrix, so omega is half the sum of the axes times their rates.
    omega = 0.5 * np.cross(frame, _rate(frame, period)).sum(axis=-2)
    in_part = np.einsum('nlij,nlj->nli', frame, omega)
    in_body: Array = np.einsum('nlij,lik,nlk->nlj', frame, inertia, in_part)
    return in_body


def _rate(values: Array, period: float) -> Array:
    """Differentiate values (n, ...) that repeat after a period by time, exactly for few waves."""
    count = len(values)
    waves = 2.0 * np.pi * np.fft.rfftfreq(count, period / count)
    if count % 2 == 0:
        # The shortest wave has no derivative that could be told.
        waves[-1] = 0.0
    spectrum = np.fft.rfft(values, axis=0) * (1j * waves).reshape(-1, *[1] * (values.ndim - 1))
    rate: Array = np.fft.irfft(spectrum, n=count, axis=0)
    return rate
