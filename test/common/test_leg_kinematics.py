"""Laws of the yaw-pitch-pitch leg: S0 eqs. 11 to 15, corrected."""

import math

import numpy as np
import pytest

from quad_common.errors import FootTargetUnreachable
from quad_common.leg_kinematics import (
    YawPitchPitchLeg,
    drive_angles,
    joint_angles_from_drives,
)
from quad_common.robot import LEGS, load_robot

ROBOT = load_robot('titan_viii')

each_leg = pytest.mark.parametrize('leg', ROBOT.legs, ids=LEGS)

# S0 sec. 6 [mm].
A, B, D, E = 43.0, 200.0, 155.0, 45.0


def random_angles(rng, count):
    """Joint angles of the branch that inverse kinematics keeps to: knee up, foot outside."""
    angles = rng.uniform((-1.4, -1.2, 0.02), (1.4, 1.2, 3.1), (4 * count, 3))
    outside = E + D * np.cos(angles[:, 1]) + B * np.cos(angles[:, 1] + angles[:, 2]) > 1.0
    return angles[outside][:count]


def random_feet(rng, leg, count):
    """Feet drawn in the body frame, anywhere in the annulus around the pitch axis."""
    shortest, longest = leg.reach()
    reach = rng.uniform(shortest * 1.001, longest * 0.999, 4 * count)
    down = rng.uniform(-math.pi / 2, math.pi / 2, 4 * count)
    out = leg.hip_offset + reach * np.cos(down)
    direction = leg.outward + rng.uniform(-math.pi, math.pi, 4 * count)
    feet = np.asarray(leg.hip) + np.column_stack(
        [out * np.cos(direction), out * np.sin(direction), -leg.hip_drop - reach * np.sin(down)]
    )
    return feet[:count]


@each_leg
def test_forward_after_inverse_is_the_identity(leg):
    feet = random_feet(np.random.default_rng(1), leg, 2000)
    assert leg.forward(leg.inverse(feet)) == pytest.approx(feet, abs=1e-12)


@each_leg
def test_inverse_after_forward_is_the_identity_on_the_branch_with_the_knee_up(leg):
    angles = random_angles(np.random.default_rng(2), 1000)
    assert len(angles) == 1000
    assert leg.inverse(leg.forward(angles)) == pytest.approx(angles, abs=1e-7)


@each_leg
def test_inverse_keeps_the_knee_above_the_line_from_pitch_axis_to_foot(leg):
    pitch_axis, knee, foot = leg.chain(leg.inverse(random_feet(np.random.default_rng(3), leg, 200)))
    share = np.sum((knee - pitch_axis) * (foot - pitch_axis), axis=1) / np.sum(
        (foot - pitch_axis) ** 2, axis=1
    )
    off_the_line = knee - pitch_axis - share[:, None] * (foot - pitch_axis)
    assert (off_the_line[:, 2] >= -1e-12).all()


@each_leg
def test_the_jacobian_is_the_derivative_of_the_foot(leg):
    angles = random_angles(np.random.default_rng(4), 200)
    h = 1e-6
    columns = [
        (leg.forward(angles + h * axis) - leg.forward(angles - h * axis)) / (2.0 * h)
        for axis in np.eye(3)
    ]
    assert leg.jacobian(angles) == pytest.approx(np.stack(columns, axis=-1), abs=1e-9)


@each_leg
def test_links_keep_their_lengths(leg):
    pitch_axis, knee, foot = leg.chain(random_angles(np.random.default_rng(5), 100))
    e, a = leg.hip_offset, leg.hip_drop
    for start, end, length in (
        (np.asarray(leg.hip), pitch_axis, math.hypot(e, a)),
        (pitch_axis, knee, leg.thigh_length),
        (knee, foot, leg.calf_length),
    ):
        assert np.linalg.norm(end - start, axis=1) == pytest.approx(length, abs=1e-12)


@each_leg
def test_leg_length_and_height_are_those_of_s0_equation_11(leg):
    angles = random_angles(np.random.default_rng(6), 500)
    theta1, theta2, theta3 = drive_angles(angles, knee_is_absolute=True).T
    arm = leg.forward(angles) - np.asarray(leg.hip)
    L = B * np.cos(theta3) + D * np.cos(theta2) + E
    H = B * np.sin(theta3) + D * np.sin(theta2) + A
    assert 1e3 * np.hypot(arm[:, 0], arm[:, 1]) == pytest.approx(L, abs=1e-9)
    assert -1e3 * arm[:, 2] == pytest.approx(H, abs=1e-9)
    yaw = np.arctan2(arm[:, 1], arm[:, 0]) - leg.outward
    assert np.sin(yaw) == pytest.approx(np.sin(theta1), abs=1e-12)
    assert np.cos(yaw) == pytest.approx(np.cos(theta1), abs=1e-12)


@each_leg
def test_the_initial_posture_has_the_papers_200_and_243_mm(leg):
    theta = np.radians([0.0, 0.0, 90.0])
    foot = leg.forward(joint_angles_from_drives(theta, knee_is_absolute=True))
    L0, H0 = 0.200, 0.243
    outward = np.array([math.cos(leg.outward), math.sin(leg.outward), 0.0])
    expected = np.asarray(leg.hip) + L0 * outward - [0.0, 0.0, H0]
    assert foot == pytest.approx(expected, abs=1e-12)
    assert leg.inverse(expected) == pytest.approx([0.0, 0.0, math.pi / 2], abs=1e-9)


@pytest.mark.parametrize('absolute', [True, False])
def test_drive_angles_and_back_is_the_identity(absolute):
    angles = np.random.default_rng(7).uniform(-3.0, 3.0, (5, 4, 3))
    before = angles.copy()
    drives = drive_angles(angles, absolute)
    assert joint_angles_from_drives(drives, absolute) == pytest.approx(angles, abs=1e-15)
    assert (angles == before).all()
    assert (drives[..., :2] == angles[..., :2]).all()
    assert (drives[..., 2] == angles[..., 2]).all() == (not absolute)


@each_leg
def test_the_pantograph_keeps_the_calf_upright_while_the_thigh_turns(leg):
    theta = np.zeros((50, 3))
    theta[:, 1] = np.linspace(-1.2, 1.2, 50)
    theta[:, 2] = math.radians(70.0)
    _, knee, foot = leg.chain(joint_angles_from_drives(theta, knee_is_absolute=True))
    calf = foot - knee
    assert np.ptp(knee, axis=0).max() > 0.1
    assert np.ptp(calf, axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    assert -calf[0, 2] == pytest.approx(0.2 * math.sin(math.radians(70.0)))


@pytest.mark.parametrize('knee_is_absolute', [True, False])
def test_without_a_pantograph_the_calf_turns_with_the_thigh(knee_is_absolute):
    drives = np.array([[0.0, 0.0, 1.0], [0.0, 0.4, 1.0]])
    leg = ROBOT.legs[0]
    _, knee, foot = leg.chain(joint_angles_from_drives(drives, knee_is_absolute))
    pitch = np.arcsin(-(foot - knee)[:, 2] / leg.calf_length)
    assert pitch[1] - pitch[0] == pytest.approx(0.0 if knee_is_absolute else 0.4)


@each_leg
@pytest.mark.parametrize('pitch', [-1.0, 0.0, 0.7])
@pytest.mark.parametrize('knee', [0.0, math.pi])
def test_the_straight_and_the_folded_leg_are_reached_exactly_at_the_edge(leg, pitch, knee):
    foot = leg.forward(np.array([0.3, pitch, knee]))
    back = leg.forward(leg.inverse(foot))
    # The knee is singular here: an error of 1e-16 in the distance is 1e-8 in its angle.
    assert back == pytest.approx(foot, abs=1e-8)


@each_leg
def test_the_straight_leg_is_singular_and_the_bent_one_is_not(leg):
    straight, bent = leg.jacobian(np.array([[0.2, 0.5, 0.0], [0.2, 0.5, 1.2]]))
    assert np.linalg.det(straight) == pytest.approx(0.0, abs=1e-12)
    assert abs(np.linalg.det(bent)) > 1e-4


@each_leg
@pytest.mark.parametrize('distance', [0.04, 0.356, 1.0])
def test_an_unreachable_foot_is_named_with_its_distance_and_the_reach(leg, distance):
    pitch_axis, _, _ = leg.chain(np.zeros(3))
    outward = np.array([math.cos(leg.outward), math.sin(leg.outward), 0.0])
    with pytest.raises(FootTargetUnreachable) as caught:
        leg.inverse(pitch_axis + distance * outward)
    error = caught.value
    assert error.foot == leg.name
    assert error.distance == pytest.approx(distance)
    assert error.reach == pytest.approx((0.045, 0.355))
    assert str(error) == (
        f'foot {leg.name} would have to be {distance:.3f} m from its pitch axis; '
        'the leg reaches 0.045 to 0.355 m'
    )


@each_leg
@pytest.mark.parametrize('bad', [math.nan, math.inf])
@pytest.mark.parametrize('axis', [0, 1, 2])
def test_a_foot_that_is_not_finite_is_unreachable(leg, axis, bad):
    foot = np.array(leg.forward(np.array([0.0, 0.0, 1.5])))
    foot[axis] = bad
    with pytest.raises(FootTargetUnreachable, match=f'foot {leg.name} '):
        leg.inverse(foot)


def test_one_unreachable_foot_among_many_is_the_one_that_is_told():
    leg = ROBOT.legs[2]
    feet = random_feet(np.random.default_rng(8), leg, 20)
    feet[13] = np.asarray(leg.hip) + [0.0, 0.9, -leg.hip_drop]
    with pytest.raises(FootTargetUnreachable, match=r'foot lh would have to be 0\.855 m'):
        leg.inverse(feet)


@pytest.mark.parametrize(('left', 'right'), [(0, 1), (2, 3)], ids=['fore', 'hind'])
def test_left_mirrors_right(left, right):
    angles = random_angles(np.random.default_rng(9), 200)
    mirrored = angles * [-1.0, 1.0, 1.0]
    feet = ROBOT.legs[left].forward(angles)
    across = np.array([1.0, -1.0, 1.0])
    assert ROBOT.legs[right].forward(mirrored) == pytest.approx(feet * across, abs=1e-12)
    jacobian = ROBOT.legs[left].jacobian(angles)
    turned = across[:, None] * jacobian * [-1.0, 1.0, 1.0]
    assert ROBOT.legs[right].jacobian(mirrored) == pytest.approx(turned, abs=1e-12)


@pytest.mark.parametrize(('fore', 'hind'), [(0, 2), (1, 3)], ids=['left', 'right'])
def test_a_hind_leg_is_a_fore_leg_moved_back(fore, hind):
    angles = random_angles(np.random.default_rng(10), 50)
    back = np.asarray(ROBOT.legs[hind].hip) - ROBOT.legs[fore].hip
    moved = ROBOT.legs[fore].forward(angles) + back
    assert ROBOT.legs[hind].forward(angles) == pytest.approx(moved, abs=1e-12)
    assert back == pytest.approx([-0.402, 0.0, 0.0])


def test_any_number_of_leading_axes_is_a_batch():
    leg = ROBOT.legs[1]
    angles = random_angles(np.random.default_rng(11), 24).reshape(2, 3, 4, 3)
    feet = leg.forward(angles)
    assert feet.shape == (2, 3, 4, 3)
    assert leg.jacobian(angles).shape == (2, 3, 4, 3, 3)
    assert feet[1, 2, 3] == pytest.approx(leg.forward(angles[1, 2, 3]), abs=1e-15)
    assert leg.inverse(feet)[1, 2, 3] == pytest.approx(leg.inverse(feet[1, 2, 3]), abs=1e-15)


def test_links_of_equal_length_may_fold_completely():
    leg = YawPitchPitchLeg('lf', (0.0, 0.0, 0.0), math.pi / 2, 0.1, 0.0, 0.2, 0.2)
    assert leg.reach() == (0.0, 0.4)
    on_the_axis = np.array([0.0, 0.1, 0.0])
    angles = leg.inverse(on_the_axis)
    assert np.isfinite(angles).all()
    assert leg.forward(angles) == pytest.approx(on_the_axis, abs=1e-8)
