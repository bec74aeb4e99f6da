"""
Rotations: quaternions x, y, z, w, matrices, and roll, pitch and yaw, in which walks are computed.

Angles are those of REP-103: a rotation is Rz(yaw) Ry(pitch) Rx(roll). The formulas are written
out because most rotations come one at a time, many in each step of a simulation: SciPy's
Rotation takes ten times as long for one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_Three = Array | list[float]


def matrix_from_angles(angles: Array) -> Array:
    """
    Turn roll, pitch and yaw into rotations Rz Ry Rx.

    Parameters
    ----------
    angles : ndarray, shape (..., 3)
        [rad]

    Returns
    -------
    ndarray, shape (..., 3, 3)
        From the body's axes to the frame's.
    """
    if angles.ndim == 1:
        # Of one rotation the same numbers, without arrays for each of them: ten times as fast.
        return np.array(_rows_of(np.cos(angles).tolist(), np.sin(angles).tolist()))
    cosines, sines = (np.moveaxis(f(angles), -1, 0) for f in (np.cos, np.sin))
    rows = _rows_of(cosines, sines)
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _rows_of(cosines: _Three, sines: _Three) -> list[list[Any]]:
    """Return the rows of Rz Ry Rx, of cosines and sines of roll, pitch and yaw."""
    cr, cp, cy = cosines
    sr, sp, sy = sines
    return [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]


def angles_from_quaternion(quaternion: Array) -> tuple[float, float, float]:
    """
    Return roll, pitch and yaw of an orientation.

    Parameters
    ----------
    quaternion : ndarray, shape (4,)
        x, y, z, w, of length 1.

    Returns
    -------
    tuple of float
        [rad]
    """
    x, y, z, w = (float(value) for value in quaternion)
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    return float(roll), float(pitch), yaw_from_quaternion((x, y, z, w))


def yaw_from_quaternion(quaternion: Sequence[float] | Array) -> float:
    """
    Return the heading of an orientation.

    Parameters
    ----------
    quaternion : ndarray, shape (4,)
        x, y, z, w, of length 1.

    Returns
    -------
    float
        Yaw [rad].
    """
    x, y, z, w = (float(value) for value in quaternion)
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def tilt_from_quaternion(quaternion: Sequence[float] | Array) -> float:
    """
    Return the angle between a body's z axis and the vertical.

    Parameters
    ----------
    quaternion : ndarray, shape (4,)
        x, y, z, w, of length 1.

    Returns
    -------
    float
        Tilt, from 0 to pi [rad].
    """
    x, y = float(quaternion[0]), float(quaternion[1])
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))


def matrix_from_quaternion(quaternion: Array) -> Array:
    """
    Convert a rotation.

    Parameters
    ----------
    quaternion : ndarray, shape (4,)
        x, y, z, w; of any length but zero.

    Returns
    -------
    ndarray, shape (3, 3)
        The same rotation.
    """
    return matrix_from_unit_quaternion(quaternion / np.linalg.norm(quaternion))


def matrix_from_unit_quaternion(quaternion: Sequence[float] | Array) -> Array:
    """
    Convert a rotation whose quaternion has length 1, as it is.

    Parameters
    ----------
    quaternion : ndarray, shape (4,)
        x, y, z, w, of length 1.

    Returns
    -------
    ndarray, shape (3, 3)
        The same rotation.
    """
    x, y, z, w = quaternion
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def quaternion_from_matrix(rotation: Array) -> Array:
    """
    Convert a rotation.

    Parameters
    ----------
    rotation : ndarray, shape (3, 3)
        A rotation matrix.

    Returns
    -------
    ndarray, shape (4,)
        x, y, z, w, of length 1, with w >= 0.
    """
    ((r00, r01, r02), (r10, r11, r12), (r20, r21, r22)) = rotation
    # 4 q q^T, of which the longest column is taken: no division by little.
    products = np.array(
        [
            [1.0 + r00 - r11 - r22, r10 + r01, r20 + r02, r21 - r12],
            [r10 + r01, 1.0 - r00 + r11 - r22, r21 + r12, r02 - r20],
            [r20 + r02, r21 + r12, 1.0 - r00 - r11 + r22, r10 - r01],
            [r21 - r12, r02 - r20, r10 - r01, 1.0 + r00 + r11 + r22],
        ]
    )
    column = products[:, int(np.argmax(np.diag(products)))]
    quaternion: Array = column / np.linalg.norm(column)
    return quaternion if quaternion[3] >= 0.0 else -quaternion
