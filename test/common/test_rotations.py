"""Quaternions, matrices and angles are the same rotations."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from quad_common.rotations import (
    angles_from_quaternion,
    matrix_from_angles,
    matrix_from_quaternion,
    matrix_from_unit_quaternion,
    quaternion_from_matrix,
    tilt_from_quaternion,
    yaw_from_quaternion,
)


@pytest.mark.parametrize('seed', range(20))
def test_quaternions_and_matrices_are_the_same_rotations(seed):
    rng = np.random.default_rng(seed)
    quaternion = rng.normal(size=4)
    if seed < 6:
        # Half turns, whose w is zero, and a quarter turn.
        quaternion = np.eye(4)[seed % 3] + (seed // 3) * np.eye(4)[(seed + 1) % 3]
    quaternion /= np.linalg.norm(quaternion)
    matrix = matrix_from_quaternion(quaternion)
    assert matrix @ matrix.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(matrix) == pytest.approx(1.0)
    back = quaternion_from_matrix(matrix)
    assert abs(back @ quaternion) == pytest.approx(1.0)
    assert back[3] >= 0.0


def test_angles_and_rotations_belong_together():
    angles = np.array([0.2, -0.3, 2.5])
    rotation = matrix_from_angles(angles)
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    half = 0.5 * angles[2]
    assert angles_from_quaternion(
        np.array([0.0, 0.0, math.sin(half), math.cos(half)])
    ) == pytest.approx((0.0, 0.0, 2.5))
    # Roll to the right lowers the right side; pitch lowers the nose.
    assert matrix_from_angles(np.array([0.1, 0.0, 0.0]))[2] @ [0, -1, 0] < 0.0
    assert matrix_from_angles(np.array([0.0, 0.1, 0.0]))[2] @ [1, 0, 0] < 0.0


@pytest.mark.parametrize('seed', range(20))
def test_rotations_are_those_of_scipy(seed):
    quaternion = np.random.default_rng(seed).normal(size=4)
    quaternion /= np.linalg.norm(quaternion)
    known = Rotation.from_quat(quaternion)
    assert matrix_from_quaternion(3.0 * quaternion) == pytest.approx(known.as_matrix(), abs=1e-12)
    assert matrix_from_unit_quaternion(quaternion) == pytest.approx(known.as_matrix(), abs=1e-12)
    roll, pitch, yaw = angles_from_quaternion(quaternion)
    assert (yaw, pitch, roll) == pytest.approx(known.as_euler('ZYX'))
    assert matrix_from_angles(np.array([roll, pitch, yaw])) == pytest.approx(known.as_matrix())
    assert yaw_from_quaternion(quaternion) == yaw
    up = known.apply([0.0, 0.0, 1.0])[2]
    assert tilt_from_quaternion(quaternion) == pytest.approx(math.acos(up))


def test_one_rotation_is_bit_for_bit_what_it_is_among_others():
    for angles in np.random.default_rng(2).uniform(-4.0, 4.0, (200, 3)):
        assert np.array_equal(matrix_from_angles(angles), matrix_from_angles(angles[None])[0])
