"""
Motion of the body over one cycle, in ground coordinates.

The ground frame of a cycle is the body's pose at its start, projected to the ground:
x forward, y left, z up from the ground (S4's insight: plan body and feet there, and
crawl, turn, crab and any mixture are one generator with different data).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D, Twist2D, wrap_angle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BodyMotion:
    """
    What the body does in one cycle: an arc, run through at a steady rate.

    The translation follows the heading (S4 eq. 3, integrated as an arc).
    """

    forward: float = 0.0
    """Distance along the body's own x axis [m]."""
    left: float = 0.0
    """Distance along the body's own y axis [m]."""
    turn: float = 0.0
    """Angle, counter-clockwise [rad]."""

    def pose_at(self, fraction: Array) -> Array:
        """
        Place the body after a fraction of the motion.

        Parameters
        ----------
        fraction : ndarray, shape (...)
            0 at the start, 1 at the end.

        Returns
        -------
        ndarray, shape (..., 3)
            x, y [m] and yaw [rad] in the ground frame.
        """
        angle = self.turn * fraction
        # sin(a)/a and (1 - cos(a))/a, both smooth through zero.
        along = np.sinc(angle / np.pi)
        across = np.sinc(angle / (2.0 * np.pi)) * np.sin(angle / 2.0)
        x = fraction * (self.forward * along - self.left * across)
        y = fraction * (self.forward * across + self.left * along)
        return np.stack([x, y, angle], axis=-1)

    @property
    def end(self) -> Pose2D:
        """The body's pose at the end of the cycle, in the ground frame."""
        along, across = _along_and_across(self.turn)
        return Pose2D(
            self.forward * along - self.left * across,
            self.forward * across + self.left * along,
            self.turn,
        )

    def scaled(self, factor: float) -> BodyMotion:
        """Return the motion with all three parts multiplied by a factor."""
        return BodyMotion(factor * self.forward, factor * self.left, factor * self.turn)

    def minus(self, other: BodyMotion) -> BodyMotion:
        """Return the motion less another one, part by part."""
        return BodyMotion(
            self.forward - other.forward, self.left - other.left, self.turn - other.turn
        )

    def rate(self, duration: float) -> Twist2D:
        """Return the velocity at which the motion takes a time [s]."""
        return Twist2D(self.forward / duration, self.left / duration, self.turn / duration)

    @classmethod
    def during(cls, twist: Twist2D, duration: float) -> BodyMotion:
        """Return what a velocity does to the body within a time [s]."""
        return cls(twist.forward * duration, twist.left * duration, twist.turn * duration)

    @classmethod
    def reaching(cls, pose: Pose2D) -> BodyMotion:
        """
        Find the arc that ends in a pose.

        Parameters
        ----------
        pose : Pose2D
            Wanted pose, in the frame of the body at the start.

        Returns
        -------
        BodyMotion
            The motion with :attr:`end` equal to the pose.
        """
        turn = wrap_angle(pose.yaw)
        along, across = _along_and_across(turn)
        square = along**2 + across**2
        return cls(
            (along * pose.x + across * pose.y) / square,
            (along * pose.y - across * pose.x) / square,
            turn,
        )


def _along_and_across(turn: float) -> tuple[float, float]:
    """Return sin(a) / a and (1 - cos(a)) / a of an angle [rad], both smooth through zero."""
    # NumPy's own functions take ten times as long for one number.
    return _sinc(turn), _sinc(turn / 2.0) * math.sin(turn / 2.0)


def _sinc(angle: float) -> float:
    return math.sin(angle) / angle if angle else 1.0


def smooth_progress(knots: tuple[tuple[float, float], ...], times: Array) -> tuple[Array, Array]:
    """
    Run smoothly and monotonously through knots, at rest at both ends.

    Parameters
    ----------
    knots : tuple of (float, float)
        Times [s] and values, both rising.
    times : ndarray, shape (n,)
        When to evaluate [s].

    Returns
    -------
    tuple of ndarray, each of shape (n,)
        Value, and rate [1/s].
    """
    t, values = (np.array(column) for column in zip(*knots))
    # A zero slope at both ends comes from holding the end values a little longer.
    padded_t = np.concatenate([[t[0] - 1.0], t, [t[-1] + 1.0]])
    padded = np.concatenate([[values[0]], values, [values[-1]]])
    clipped = np.clip(times, t[0], t[-1])
    inside = (times >= t[0]) & (times <= t[-1])
    value, rate = _monotone_cubics(padded_t, padded, clipped)
    return value, np.where(inside, rate, 0.0)


def _monotone_cubics(knots: Array, values: Array, times: Array) -> tuple[Array, Array]:
    """
    Run through knots by cubics that rise or fall wherever the values do.

    They are those of SciPy's ``PchipInterpolator``, to the last bit, where the values are level at
    both ends; to import it takes a third of a node's start.

    Parameters
    ----------
    knots : ndarray, shape (m,)
        Times [s], rising.
    values : ndarray, shape (m,)
        The first two are equal, and so are the last two.
    times : ndarray, shape (n,)
        When to evaluate, within the knots [s].

    Returns
    -------
    tuple of ndarray, each of shape (n,)
        Value, and rate [1/s].
    """
    h = np.diff(knots)
    m = np.diff(values) / h
    slopes = np.zeros_like(values)
    # Level beside an extremum; else the harmonic mean, of which the shorter side has more.
    w1, w2 = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    rises = (np.sign(m[1:]) == np.sign(m[:-1])) & (m[1:] != 0.0)
    mean = (w1[rises] / m[:-1][rises] + w2[rises] / m[1:][rises]) / (w1 + w2)[rises]
    slopes[1:-1][rises] = 1.0 / mean
    t = (slopes[:-1] + slopes[1:] - 2.0 * m) / h
    k = np.clip(np.searchsorted(knots, times, 'right') - 1, 0, len(h) - 1)
    a, b, c, d = (t / h)[k], ((m - slopes[:-1]) / h - t)[k], slopes[k], values[k]
    s = times - knots[k]
    return d + c * s + b * (s * s) + a * (s * s * s), c + b * s * 2.0 + a * (s * s) * 3.0


def gather_speed(duration: float, times: Array) -> tuple[Array, Array]:
    """
    Displacement that turns a steady motion into one that begins at another speed.

    The quintic that is zero at both ends, has slope 1 at the start and none at the end,
    and no acceleration at either. Mirrored in time it does the same for the end.

    Parameters
    ----------
    duration : float
        [s]
    times : ndarray, shape (n,)
        From 0 to the duration [s].

    Returns
    -------
    tuple of ndarray, each of shape (n,)
        Displacement [s], and its rate, for a difference in speed of 1.
    """
    u = times / duration
    value = duration * u * (1.0 + u**2 * (-6.0 + u * (8.0 - 3.0 * u)))
    rate = 1.0 + u**2 * (-18.0 + u * (32.0 - 15.0 * u))
    return value, rate


def minimum_jerk(start: float, end: float, times: Array) -> tuple[Array, Array]:
    """
    Rise from 0 to 1 between two times, with no speed or acceleration at the ends.

    Parameters
    ----------
    start, end : float
        [s], start < end.
    times : ndarray, shape (n,)
        When to evaluate [s].

    Returns
    -------
    tuple of ndarray, each of shape (n,)
        Value, and rate [1/s].
    """
    u = np.clip((times - start) / (end - start), 0.0, 1.0)
    value = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    rate = 30.0 * u**2 * (1.0 - u) ** 2 / (end - start)
    return value, rate
