"""
The laws of balance: where feet land, how standing legs give way, how they right the body.

All of it is beside the level body: x as the body's heading, z up, from base_link. Feet are plain
numbers, one foot at a time, and what is here is compiled as a part of
:mod:`~quad_gait.balance.foot_march`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_part

Array = NDArray[np.float64]

GRAVITY = 9.80665
"""Acceleration of free fall [m/s^2]."""


class Pace(NamedTuple):
    """A velocity of the body in the plane."""

    forward: float
    """Velocity along x [m/s]."""
    left: float
    """Velocity along y [m/s]."""
    turn: float
    """Angular velocity, counter-clockwise [rad/s]."""


STILL = Pace(0.0, 0.0, 0.0)
"""No velocity."""


def pendulum_time(height: float) -> float:
    """Return the time constant of an inverted pendulum, sqrt(h / g) [s], h in [m]."""
    return math.sqrt(height / GRAVITY)


@compiled_part
def landing_place(
    x: float,
    y: float,
    drift: tuple[float, float],
    excess: tuple[float, float],
    stance: float,
    largest: float,
) -> tuple[float, float]:
    """
    Find where a foot is to land beside the body.

    It lands so far ahead of its neutral place p that it is there in mid-stance (Raibert), and
    farther by the step to the capture point (Pratt)::

        p - u T / 2 + k sqrt(h / g) (v_measured - v)

    Parameters
    ----------
    x, y : float
        Neutral place p of the foot, under a standing body [m].
    drift : tuple of float
        Velocity u of a foot that stands there, beside the body [m/s].
    excess : tuple of float
        Step to the capture point, k sqrt(h / g) (v_measured - v) [m].
    stance : float
        Duration of its stance, T [s].
    largest : float
        Distance from the neutral place at most [m].

    Returns
    -------
    tuple of float
        Place x and y [m].
    """
    half = stance / 2.0
    dx, dy = excess[0] - half * drift[0], excess[1] - half * drift[1]
    distance = math.hypot(dx, dy)
    if distance > largest:
        dx, dy = dx * largest / distance, dy * largest / distance
    return x + dx, y + dy


@compiled_part
def ground_velocity(x: float, y: float, pace: Pace) -> tuple[float, float]:
    """Return how fast the ground under a place moves beside a body with a pace [m/s]."""
    return pace.turn * y - pace.forward, -pace.turn * x - pace.left


@compiled_part
def sway_velocity(phase: float, sway: tuple[float, float]) -> float:
    """
    Return how fast a body sways to the left at a phase.

    Parameters
    ----------
    phase : float
        Cycles since it began to trot.
    sway : tuple of float
        Parts that go as the cosine and the sine of the phase [m/s].

    Returns
    -------
    float
        [m/s]
    """
    angle = 2.0 * math.pi * phase
    return sway[0] * math.cos(angle) + sway[1] * math.sin(angle)


@compiled_part
def pace_after(
    last: Array, wanted: Pace, dt: float, acceleration: float, turn_acceleration: float
) -> Pace:
    """
    Return the pace after a time, gathered no faster than is wanted.

    Parameters
    ----------
    last : ndarray, shape (3,)
        Velocity before [m/s], [rad/s].
    wanted : Pace
        Velocity to be gathered.
    dt : float
        Time [s].
    acceleration : float
        Largest acceleration, as a fraction of g.
    turn_acceleration : float
        The same of turns [rad/s^2].

    Returns
    -------
    Pace
    """
    step, turn_step = dt * GRAVITY * acceleration, dt * turn_acceleration
    return Pace(
        _toward(last[0], wanted.forward, step),
        _toward(last[1], wanted.left, step),
        _toward(last[2], wanted.turn, turn_step),
    )


@compiled_part
def _toward(value: float, wanted: float, step: float) -> float:
    return value + min(max(wanted - value, -step), step)


@compiled_part
def swing_on(
    place: float, velocity: float, target: float, at_landing: float, left: float, dt: float
) -> tuple[float, float]:
    """
    Move a swinging foot on, in one coordinate.

    It follows the cubic from where and how fast it is to where, and how fast, it is to land.

    Parameters
    ----------
    place, velocity : float
        Where it is [m], and how fast [m/s].
    target, at_landing : float
        Where it is to land, and how fast then.
    left : float
        Time until it lands [s]; less than ``dt`` counts as that.
    dt : float
        Time to move on by [s].

    Returns
    -------
    tuple of float
        Place and velocity then.
    """
    h = max(left, dt)
    s = dt / h
    u, v, d = velocity * h, at_landing * h, target - place
    b, c = 3.0 * d - 2.0 * u - v, u + v - 2.0 * d
    return place + s * (u + s * (b + s * c)), (u + s * (2.0 * b + 3.0 * s * c)) / h


@compiled_part
def swing_height(fraction: float, easing: float = 0.0) -> float:
    """
    Return how high a foot is at a fraction of its swing, as a fraction of the most.

    Half an ellipse over time, as S2's (5) has it: it leaves and meets the ground fast, and meets
    it in time where the ground is not quite where it should be. A little of the swing is for
    gathering that speed and losing it, so that knots some way apart tell when it lands.

    Parameters
    ----------
    fraction : float
        From 0 to 1; beyond them the foot stands.
    easing : float
        Fraction of the swing in which it gathers its speed, and again loses it.

    Returns
    -------
    float
        From 0 to 1.
    """
    u = min(max(fraction, 0.0), 1.0)
    if easing > 0.0:
        near = min(u, 1.0 - u)
        gone = near - easing / 2.0 if near > easing else near * near / (2.0 * easing)
        u = gone / (1.0 - easing)
    return math.sin(math.pi * u)


@compiled_part
def tilted_back(
    x: float, y: float, z: float, roll: float, pitch: float
) -> tuple[float, float, float]:
    """Turn a place beside the level body into a tilted body's axes: R^T p, R = Ry Rx [m]."""
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    up = sp * x + cp * z
    return cp * x - sp * z, cr * y + sr * up, cr * up - sr * y


def leveled(places: Array, roll: Array, pitch: Array) -> tuple[Array, Array]:
    """Return x and y beside the level body of places in the axes of tilted ones, (..., 3) [m]."""
    x, y, z = np.moveaxis(places, -1, 0)
    cr, sr = np.cos(roll), np.sin(roll)
    return np.cos(pitch) * x + np.sin(pitch) * (sr * y + cr * z), cr * y - sr * z
