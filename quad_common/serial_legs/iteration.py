"""
The iteration that inverts a serial leg: Newton's, damped where the leg is nearly singular.

With e the way that the foot still has to go and J its Jacobian, a step solves
(J^T J + mu e^T e I) dq = J^T e (Levenberg and Marquardt): far away it is damped, and near the
solution it is Newton's, whose error squares from step to step.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled, compiled_part

Array = NDArray[np.float64]

_MOST_STEPS = 60
"""Number of steps after which a foot is out of reach: those in reach take 3 to 6."""

_DAMPING = 10.0
"""Damping of a step, by the squared error [1]."""

_LONGEST_STEP = 0.3
"""Largest change of a joint in a step [rad]."""

_LINE = 24
"""Number of parts of the line from the nominal posture to another that are looked at."""

_DIP = 0.02
"""Determinant on that line, of the lesser one of its ends, below which it counts as changed."""


@compiled_part
def _turn(axis: Array, angle: float, before: Array, after: Array) -> None:
    """Turn a rotation (3, 3) on about an axis of its own frame (Rodrigues)."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = axis[0], axis[1], axis[2]
    d = 1.0 - c
    for row in range(3):
        p, q, r = before[row, 0], before[row, 1], before[row, 2]
        after[row, 0] = p * (c + d * x * x) + q * (d * x * y + s * z) + r * (d * x * z - s * y)
        after[row, 1] = p * (d * x * y - s * z) + q * (c + d * y * y) + r * (d * y * z + s * x)
        after[row, 2] = p * (d * x * z + s * y) + q * (d * y * z - s * x) + r * (c + d * z * z)


@compiled_part
def _place(axes: Array, arms: Array, q: Array, work: Array) -> None:
    """
    Place joints and foot of a leg: rotations in ``work[:4]``, and axes and places behind them.

    Parameters
    ----------
    axes, arms : ndarray, shape (3, 3)
        Axes of the joints, and from each joint to the next, or to the foot, at 0 [m].
    q : ndarray, shape (3,)
        Joint angles [rad].
    work : ndarray, shape (8, 3, 3)
        Rotations of body and links, then axes, then places of joints 2 and 3 and the foot from
        joint 1, then the Jacobian, and the inverse of its square.
    """
    for row in range(3):
        for column in range(3):
            work[0, row, column] = 1.0 if row == column else 0.0
    for joint in range(3):
        _turn(axes[joint], q[joint], work[joint], work[joint + 1])
        for row in range(3):
            axis, place = 0.0, 0.0
            for k in range(3):
                axis += work[joint, row, k] * axes[joint, k]
                place += work[joint + 1, row, k] * arms[joint, k]
            work[4, joint, row] = axis
            work[5, joint, row] = place + (work[5, joint - 1, row] if joint > 0 else 0.0)
    for joint in range(3):
        for row in range(3):
            a, b = (row + 1) % 3, (row + 2) % 3
            from_a = work[5, 2, a] - (work[5, joint - 1, a] if joint > 0 else 0.0)
            from_b = work[5, 2, b] - (work[5, joint - 1, b] if joint > 0 else 0.0)
            work[6, row, joint] = work[4, joint, a] * from_b - work[4, joint, b] * from_a


@compiled_part
def _step(work: Array, error: Array, damping: float, change: Array) -> None:
    """Solve for the change of the joint angles (3,), by the adjugate of J^T J + damping I."""
    m = work[7]
    for row in range(3):
        for column in range(3):
            value = damping if row == column else 0.0
            for k in range(3):
                value += work[6, k, row] * work[6, k, column]
            m[row, column] = value
    c00 = m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1]
    c01 = m[1, 2] * m[2, 0] - m[1, 0] * m[2, 2]
    c02 = m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0]
    c11 = m[0, 0] * m[2, 2] - m[0, 2] * m[2, 0]
    c12 = m[0, 1] * m[2, 0] - m[0, 0] * m[2, 1]
    c22 = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    size = m[0, 0] * c00 + m[0, 1] * c01 + m[0, 2] * c02
    if size < 1e-300:
        size = 1e-300
    g0, g1, g2 = 0.0, 0.0, 0.0
    for k in range(3):
        g0 += work[6, k, 0] * error[k]
        g1 += work[6, k, 1] * error[k]
        g2 += work[6, k, 2] * error[k]
    change[0] = (c00 * g0 + c01 * g1 + c02 * g2) / size
    change[1] = (c01 * g0 + c11 * g1 + c12 * g2) / size
    change[2] = (c02 * g0 + c12 * g1 + c22 * g2) / size


@compiled
def iterate(axes: Array, arms: Array, targets: Array, q: Array, left: Array, near: float) -> None:
    """
    Turn joints until the feet are where they are wanted.

    Parameters
    ----------
    axes, arms : ndarray, shape (3, 3)
        Axes of the joints in the body frame at 0, and from each joint to the next, or to the
        foot [m].
    targets : ndarray, shape (n, 3)
        Feet from the first joint in the body frame [m].
    q : ndarray, shape (n, 3)
        Joint angles to begin with; those that were found afterwards [rad].
    left : ndarray, shape (n,)
        Made the distances that are left [m].
    near : float
        Distance that is near enough [m].
    """
    work, error, change = np.zeros((8, 3, 3)), np.zeros(3), np.zeros(3)
    # Damped in the leg's own size: a leg twice as long takes the same steps.
    for sample in range(len(targets)):
        distance = math.inf
        for _ in range(_MOST_STEPS):
            _place(axes, arms, q[sample], work)
            squared = 0.0
            for k in range(3):
                error[k] = targets[sample, k] - work[5, 2, k]
                squared += error[k] * error[k]
            distance = math.sqrt(squared)
            # Also what is no number ends here.
            if not distance > near:
                break
            _step(work, error, _DAMPING * squared, change)
            largest = max(abs(change[0]), abs(change[1]), abs(change[2]))
            part = _LONGEST_STEP / largest if largest > _LONGEST_STEP else 1.0
            for k in range(3):
                q[sample, k] += part * change[k]
        left[sample] = distance


@compiled
def place_feet(axes: Array, arms: Array, postures: Array, feet: Array) -> None:
    """
    Place feet.

    Parameters
    ----------
    axes, arms : ndarray, shape (3, 3)
        As of :func:`iterate`.
    postures : ndarray, shape (n, 3)
        Joint angles [rad].
    feet : ndarray, shape (n, 3)
        Made the feet from the first joint in the body frame [m].
    """
    work = np.zeros((8, 3, 3))
    for sample in range(len(postures)):
        _place(axes, arms, postures[sample], work)
        for k in range(3):
            feet[sample, k] = work[5, 2, k]


@compiled_part
def _determinant(work: Array) -> float:
    """Return the determinant of the Jacobian that :func:`_place` leaves."""
    m = work[6]
    return float(
        m[0, 0] * (m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1])
        - m[0, 1] * (m[1, 0] * m[2, 2] - m[1, 2] * m[2, 0])
        + m[0, 2] * (m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0])
    )


@compiled
def stays_regular(
    axes: Array, arms: Array, nominal: Array, postures: Array, is_regular: NDArray[np.bool_]
) -> None:
    """
    Find the postures to which the Jacobian keeps the sign of its determinant.

    Parameters
    ----------
    axes, arms : ndarray, shape (3, 3)
        As of :func:`iterate`.
    nominal : ndarray, shape (3,)
        A regular posture [rad].
    postures : ndarray, shape (n, 3)
        Postures at the other ends of straight lines from it [rad].
    is_regular : ndarray, shape (n,)
        Made true where no posture of the line is singular, nor nearly so beside its ends.
    """
    work, q = np.zeros((8, 3, 3)), np.zeros(3)
    _place(axes, arms, nominal, work)
    own = _determinant(work)
    for sample in range(len(postures)):
        _place(axes, arms, postures[sample], work)
        end = _determinant(work) / own
        is_kept = end > 0.0
        # Two changes of sign between neighbors of the line show as a dip.
        least = _DIP * min(end, 1.0)
        for k in range(1, _LINE):
            if not is_kept:
                break
            for joint in range(3):
                way = postures[sample, joint] - nominal[joint]
                q[joint] = nominal[joint] + k / _LINE * way
            _place(axes, arms, q, work)
            is_kept = _determinant(work) / own > least
        is_regular[sample] = is_kept
