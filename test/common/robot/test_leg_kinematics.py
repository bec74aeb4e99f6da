"""Laws of a leg with one turning and two pitching joints: S0, S1 and S2, corrected."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import FootTargetUnreachable, SingularPosture
from quad_common.robot.leg_builds import (
    LegLengths,
    LegPlace,
    drive_angles,
    joint_angles_from_drives,
    roll_pitch_pitch_leg,
    yaw_pitch_pitch_leg,
)
from quad_common.robot.leg_kinematics import Leg, stack_legs
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot

ROBOTS = {name: load_robot(name) for name in ('titan_viii', 'pukyong', 'cuhk', 'genibo')}
ROBOT = ROBOTS['titan_viii']
ORIGIN = (0.0, 0.0, 0.0)

# An axis askew, an offset each way, a knee that bends down and odd signs.
_AXES = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
ODD = Leg(
    name='odd',
    hip=np.array([0.1, -0.2, 0.05]),
    first_axis=_AXES[0],
    radial_direction=_AXES[1],
    axial_offset=-0.03,
    radial_offset=0.04,
    lateral_offset=0.05,
    thigh_length=0.2,
    calf_length=0.17,
    knee_sign=-1.0,
    signs=(-1.0, 1.0, -1.0),
)
ALL = {f'{name}-{leg.name}': leg for name, robot in ROBOTS.items() for leg in robot.legs}
ALL['odd'] = ODD

each_leg = pytest.mark.parametrize('leg', ALL.values(), ids=ALL)
each_titan_leg = pytest.mark.parametrize('leg', ROBOT.legs, ids=LEGS)
each_robot = pytest.mark.parametrize('robot', ROBOTS.values(), ids=ROBOTS)

# S0 sec. 6 [mm].
A, B, D, E = 43.0, 200.0, 155.0, 45.0


def in_plane(leg, angles):
    """Say how far the foot is from the first axis within the leg's plane [m]."""
    q2, q3 = (angles * leg.signs)[..., 1:].T
    out = leg.radial_offset + leg.thigh_length * np.cos(q2)
    return out + leg.calf_length * np.cos(q2 + q3)


def random_angles(rng, leg, count):
    """Joint angles of the branch that inverse kinematics keeps to: foot off the first axis."""
    angles = rng.uniform((-1.4, -1.2, 0.02), (1.4, 1.2, 3.1), (4 * count, 3))
    angles = angles * [1.0, leg.knee_sign, leg.knee_sign] * leg.signs
    outside = in_plane(leg, angles) > 0.02 * leg.reach()[1]
    return angles[outside][:count]


def random_feet(rng, leg, count):
    """Feet drawn in the body frame, anywhere in the annulus around the pitch axis."""
    shortest, longest = leg.reach()
    reach = rng.uniform(shortest + 1e-3 * longest, longest * 0.999, 4 * count)
    down = rng.uniform(-math.pi / 2, math.pi / 2, 4 * count)
    out = leg.radial_offset + reach * np.cos(down)
    turn = rng.uniform(-math.pi, math.pi, 4 * count)[:, None]
    rho = np.cos(turn) * leg.radial_direction + np.sin(turn) * leg.lateral_direction
    nu = np.cross(leg.first_axis, rho)
    height = leg.axial_offset - reach * np.sin(down)
    feet = leg.hip + out[:, None] * rho + leg.lateral_offset * nu
    return (feet + height[:, None] * leg.first_axis)[:count]


def calf_orientation(leg, angles):
    """Rotation matrices of the calf, from its own directions: along, normal, across."""
    _, knee, foot = leg.chain(angles)
    along = (foot - knee) / leg.calf_length
    q1 = (angles * leg.signs)[..., :1]
    normal = np.cos(q1) * leg.lateral_direction - np.sin(q1) * leg.radial_direction
    return np.stack([along, normal, np.cross(along, normal)], axis=-1)


@each_leg
def test_forward_after_inverse_is_the_identity(leg):
    feet = random_feet(np.random.default_rng(1), leg, 2000)
    assert leg.forward(leg.inverse(feet)) == pytest.approx(feet, abs=1e-12)


@each_leg
def test_inverse_after_forward_is_the_identity_on_the_branch_of_its_knee(leg):
    angles = random_angles(np.random.default_rng(2), leg, 500)
    assert len(angles) == 500
    assert leg.inverse(leg.forward(angles)) == pytest.approx(angles, abs=1e-7)


@each_leg
def test_inverse_bends_the_knee_to_its_side_and_keeps_angles_wrapped(leg):
    angles = leg.inverse(random_feet(np.random.default_rng(3), leg, 500))
    knee = angles[:, 2] * leg.signs[2] * leg.knee_sign
    assert (knee >= 0.0).all()
    assert (knee <= math.pi).all()
    assert (angles[:, :2] >= -math.pi).all()
    assert (angles[:, :2] < math.pi).all()


@pytest.mark.parametrize('name', ['titan_viii', 'pukyong'])
def test_a_sprawling_leg_keeps_its_knee_above_the_line_from_pitch_axis_to_foot(name):
    for leg in ROBOTS[name].legs:
        feet = random_feet(np.random.default_rng(3), leg, 200)
        pitch_axis, knee, foot = leg.chain(leg.inverse(feet))
        fraction = np.sum((knee - pitch_axis) * (foot - pitch_axis), axis=1) / np.sum(
            (foot - pitch_axis) ** 2, axis=1
        )
        off_the_line = knee - pitch_axis - fraction[:, None] * (foot - pitch_axis)
        assert (off_the_line[:, 2] >= -1e-12).all()


@pytest.mark.parametrize('name', ['cuhk', 'genibo'])
def test_a_dogs_knees_all_point_inward(name):
    robot = ROBOTS[name]
    for leg, angles in zip(robot.legs, robot.initial_joint_angles):
        pitch_axis, knee, foot = leg.chain(angles)
        inward = -np.sign(leg.hip[0])
        assert inward * (knee - pitch_axis)[0] > 0.01
        assert (foot - pitch_axis)[:2] == pytest.approx([0.0, 0.0], abs=1e-12)


@each_leg
def test_the_jacobian_is_the_derivative_of_the_foot(leg):
    angles = random_angles(np.random.default_rng(4), leg, 200)
    h = 1e-6
    columns = [
        (leg.forward(angles + h * axis) - leg.forward(angles - h * axis)) / (2.0 * h)
        for axis in np.eye(3)
    ]
    assert leg.jacobian(angles) == pytest.approx(np.stack(columns, axis=-1), abs=1e-9)


@each_leg
def test_links_keep_their_lengths(leg):
    pitch_axis, knee, foot = leg.chain(random_angles(np.random.default_rng(5), leg, 100))
    offsets = leg.axial_offset, leg.radial_offset, leg.lateral_offset
    for start, end, length in (
        (leg.hip, pitch_axis, math.hypot(*offsets)),
        (pitch_axis, knee, leg.thigh_length),
        (knee, foot, leg.calf_length),
    ):
        assert np.linalg.norm(end - start, axis=1) == pytest.approx(length, abs=1e-12)


@each_titan_leg
def test_leg_length_and_height_are_those_of_s0_equation_11(leg):
    angles = random_angles(np.random.default_rng(6), leg, 500)
    theta1, theta2, theta3 = drive_angles(angles, knee_is_absolute=True).T
    arm = leg.forward(angles) - np.asarray(leg.hip)
    L = B * np.cos(theta3) + D * np.cos(theta2) + E
    H = B * np.sin(theta3) + D * np.sin(theta2) + A
    assert 1e3 * np.hypot(arm[:, 0], arm[:, 1]) == pytest.approx(L, abs=1e-9)
    assert -1e3 * arm[:, 2] == pytest.approx(H, abs=1e-9)
    yaw = np.arctan2(arm[:, 1], arm[:, 0]) - math.copysign(math.pi / 2, leg.hip[1])
    assert np.sin(yaw) == pytest.approx(np.sin(theta1), abs=1e-12)
    assert np.cos(yaw) == pytest.approx(np.cos(theta1), abs=1e-12)


@each_titan_leg
def test_the_initial_posture_has_the_papers_200_and_243_mm(leg):
    theta = np.radians([0.0, 0.0, 90.0])
    foot = leg.forward(joint_angles_from_drives(theta, knee_is_absolute=True))
    L0, H0 = 0.200, 0.243
    expected = leg.hip + L0 * leg.radial_direction - [0.0, 0.0, H0]
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


@each_titan_leg
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
    angles = np.array([0.3, pitch, knee])
    if in_plane(leg, angles) < 0.0:
        angles[1] += math.pi
    foot = leg.forward(angles)
    back = leg.forward(leg.inverse(foot))
    # The knee is singular here: an error of 1e-16 in the distance is 1e-8 in its angle.
    assert back == pytest.approx(foot, abs=1e-8)


@each_leg
def test_the_straight_leg_is_singular_and_the_bent_one_is_not(leg):
    straight, bent = leg.jacobian(np.array([[0.2, 0.5, 0.0], [0.2, 0.5, 1.2]]))
    assert np.linalg.det(straight) == pytest.approx(0.0, abs=1e-12)
    assert abs(np.linalg.det(bent)) > 1e-4


@each_titan_leg
@pytest.mark.parametrize('distance', [0.04, 0.356, 1.0])
def test_an_unreachable_foot_is_named_with_its_distance_and_the_reach(leg, distance):
    pitch_axis, _, _ = leg.chain(np.zeros(3))
    with pytest.raises(FootTargetUnreachable) as caught:
        leg.inverse(pitch_axis + distance * leg.radial_direction)
    error = caught.value
    assert error.foot == leg.name
    assert error.distance == pytest.approx(distance)
    assert error.reach == pytest.approx((0.045, 0.355))
    assert str(error) == (
        f'foot {leg.name} would have to be {distance:.3f} m from its pitch axis; '
        'the leg reaches 0.045 to 0.355 m'
    )


@each_leg
@pytest.mark.parametrize('distance', [0.9, 1.1])
def test_the_ends_of_the_reach_are_where_the_leg_ends(leg, distance):
    pitch_axis, _, _ = leg.chain(np.zeros(3))
    shortest, longest = leg.reach()
    end = distance * longest
    foot = pitch_axis + end * leg.radial_direction
    if shortest < end < longest:
        assert leg.forward(leg.inverse(foot)) == pytest.approx(foot, abs=1e-12)
    else:
        with pytest.raises(FootTargetUnreachable, match=f'foot {leg.name} .* pitch axis'):
            leg.inverse(foot)


@pytest.mark.parametrize('leg', [ODD, ROBOTS['genibo'].legs[1]], ids=['odd', 'genibo'])
def test_a_foot_nearer_to_the_first_axis_than_the_legs_plane_is_unreachable(leg):
    lateral = abs(leg.lateral_offset)
    inside = leg.hip + 0.6 * lateral * leg.radial_direction - 0.05 * leg.first_axis
    with pytest.raises(FootTargetUnreachable) as caught:
        leg.inverse(inside)
    assert caught.value.distance == pytest.approx(0.6 * lateral)
    assert caught.value.reach[0] == pytest.approx(lateral)
    assert f'{0.6 * lateral:.3f} m from its first axis' in str(caught.value)
    farthest = np.max(np.abs(random_feet(np.random.default_rng(1), leg, 500) - leg.hip))
    assert farthest < math.hypot(caught.value.reach[1], leg.reach()[1])


@each_leg
@pytest.mark.parametrize('bad', [math.nan, math.inf])
@pytest.mark.parametrize('axis', [0, 1, 2])
def test_a_foot_that_is_not_finite_is_unreachable(leg, axis, bad):
    foot = np.array(leg.forward(np.array([0.1, 0.2, 1.5])))
    foot[axis] = bad
    with pytest.raises(FootTargetUnreachable, match=f'foot {leg.name} '):
        leg.inverse(foot)


def test_one_unreachable_foot_among_many_is_the_one_that_is_told():
    leg = ROBOT.legs[2]
    feet = random_feet(np.random.default_rng(8), leg, 20)
    feet[13] = leg.hip + [0.0, 0.9, leg.axial_offset]
    with pytest.raises(FootTargetUnreachable, match=r'foot lh would have to be 0\.855 m'):
        leg.inverse(feet)


@each_leg
def test_the_straight_leg_has_no_joint_speeds_and_says_why(leg):
    with pytest.raises(SingularPosture, match=f'leg {leg.name} .* its knee is straight or folded'):
        leg.joint_velocities(np.array([0.2, 0.5, 0.0]), np.ones(3))


@each_leg
def test_a_foot_in_line_with_its_first_axis_has_no_joint_speeds_and_says_why(leg):
    # B = 0: out and back by the same length.
    d, b, radial = leg.thigh_length, leg.calf_length, leg.radial_offset
    q2 = 1.4
    q23 = math.acos(-(radial + d * math.cos(q2)) / b)
    angles = np.array([0.2, q2, q23 - q2]) * leg.signs
    with pytest.raises(SingularPosture, match=f'leg {leg.name} .* in line with the first axis'):
        leg.joint_velocities(angles, np.ones(3))


@each_leg
def test_joint_velocities_are_the_inverse_of_the_jacobian(leg):
    rng = np.random.default_rng(12)
    angles = random_angles(rng, leg, 300)
    angles = angles[np.abs(np.sin(angles[:, 2])) > 0.05]
    wanted = rng.normal(size=angles.shape)
    speeds = leg.joint_velocities(angles, wanted)
    expected = np.linalg.solve(leg.jacobian(angles), wanted[..., None])[..., 0]
    assert speeds == pytest.approx(expected, rel=1e-8, abs=1e-8)


@each_leg
def test_the_angular_velocity_is_that_of_the_calfs_rotation(leg):
    rng = np.random.default_rng(13)
    angles = random_angles(rng, leg, 100)
    speeds = rng.normal(size=angles.shape)
    h = 1e-6
    before, now, after = (calf_orientation(leg, angles + k * h * speeds) for k in (-1, 0, 1))
    assert np.linalg.det(now) == pytest.approx(np.ones(len(now)))
    spin = (after - before) / (2.0 * h) @ now.transpose(0, 2, 1)
    expected = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
    assert leg.angular_velocity(angles, speeds) == pytest.approx(expected, abs=1e-8)


@each_robot
def test_stacked_legs_do_what_each_does_alone(robot):
    rng = np.random.default_rng(14)
    legs = (*robot.legs, ODD)
    stacked = stack_legs(legs)
    angles = np.stack([random_angles(rng, leg, 60) for leg in legs], axis=1).reshape(3, 20, 5, 3)
    vectors = rng.normal(size=angles.shape)
    feet = stacked.forward(angles)
    together = (
        feet,
        stacked.inverse(feet),
        stacked.jacobian(angles),
        stacked.joint_velocities(angles, vectors),
        stacked.angular_velocity(angles, vectors),
        *stacked.chain(angles),
    )
    for k, leg in enumerate(legs):
        own, vector = angles[..., k, :], vectors[..., k, :]
        alone = (
            leg.forward(own),
            leg.inverse(feet[..., k, :]),
            leg.jacobian(own),
            leg.joint_velocities(own, vector),
            leg.angular_velocity(own, vector),
            *leg.chain(own),
        )
        for one, all_legs in zip(alone, together):
            expected = all_legs[:, :, k]
            assert one.shape == expected.shape
            assert one == pytest.approx(expected, rel=1e-9, abs=1e-9)


@each_robot
@pytest.mark.parametrize('index', range(4), ids=LEGS)
@pytest.mark.parametrize('bad', [math.nan, math.inf, 9.0])
def test_of_stacked_legs_the_one_that_cannot_reach_is_named(robot, index, bad):
    feet = np.tile(robot.neutral_feet, (6, 1, 1))
    feet[3, index, 1] = bad
    with pytest.raises(FootTargetUnreachable, match=f'foot {LEGS[index]} '):
        robot.stacked_legs.inverse(feet)


@each_robot
@pytest.mark.parametrize('index', range(4), ids=LEGS)
def test_of_stacked_legs_the_singular_one_is_named(robot, index):
    angles = np.tile(robot.initial_joint_angles, (6, 1, 1))
    angles[3, index, 2] = 0.0
    with pytest.raises(SingularPosture, match=f'leg {LEGS[index]} '):
        robot.stacked_legs.joint_velocities(angles, np.ones_like(angles))


@each_robot
@pytest.mark.parametrize(('left', 'right'), [(0, 1), (2, 3)], ids=['fore', 'hind'])
def test_left_mirrors_right(robot, left, right):
    left_leg, right_leg = robot.legs[left], robot.legs[right]
    angles = random_angles(np.random.default_rng(9), left_leg, 200)
    mirrored = angles * [-1.0, 1.0, 1.0]
    feet = left_leg.forward(angles)
    across = np.array([1.0, -1.0, 1.0])
    assert right_leg.forward(mirrored) == pytest.approx(feet * across, abs=1e-12)
    jacobian = left_leg.jacobian(angles)
    turned = across[:, None] * jacobian * [-1.0, 1.0, 1.0]
    assert right_leg.jacobian(mirrored) == pytest.approx(turned, abs=1e-12)


def test_a_lateral_offset_of_a_sprawling_leg_is_forward_on_both_sides():
    for side in (1, -1):
        leg = yaw_pitch_pitch_leg(
            LegPlace('lf', ORIGIN, side), LegLengths(0.1, 0.0, 0.2, 0.2), lateral_offset=0.03
        )
        assert leg.forward(np.zeros(3)) == pytest.approx([0.03, side * 0.5, 0.0], abs=1e-15)


def test_offsets_of_a_standing_leg_are_outward_downward_and_forward():
    for side in (1, -1):
        leg = roll_pitch_pitch_leg(
            LegPlace('lf', (1.0, side, 0.0), side),
            LegLengths(0.03, 0.02, 0.2, 0.1),
            forward_offset=0.04,
        )
        foot = leg.forward(np.zeros(3))
        assert foot == pytest.approx([1.04, side * 1.03, -0.32], abs=1e-15)
        # REP-103: about y, positive pitch carries what hangs down backward.
        assert leg.forward(np.array([0.0, 0.1, 0.0]))[0] < foot[0]
        assert leg.forward(np.array([0.1, 0.0, 0.0]))[1] > foot[1]


@pytest.mark.parametrize('name', ['titan_viii', 'pukyong'])
@pytest.mark.parametrize(('fore', 'hind'), [(0, 2), (1, 3)], ids=['left', 'right'])
def test_a_sprawling_hind_leg_is_a_fore_leg_moved_back(name, fore, hind):
    robot = ROBOTS[name]
    angles = random_angles(np.random.default_rng(10), robot.legs[fore], 50)
    back = robot.legs[hind].hip - robot.legs[fore].hip
    moved = robot.legs[fore].forward(angles) + back
    assert robot.legs[hind].forward(angles) == pytest.approx(moved, abs=1e-12)


@pytest.mark.parametrize('name', ['cuhk', 'genibo'])
@pytest.mark.parametrize(('fore', 'hind'), [(0, 2), (1, 3)], ids=['left', 'right'])
def test_a_dogs_hind_leg_mirrors_its_fore_leg(name, fore, hind):
    robot = ROBOTS[name]
    angles = random_angles(np.random.default_rng(10), robot.legs[fore], 50)
    feet = robot.legs[fore].forward(angles) * [-1.0, 1.0, 1.0]
    mirrored = angles * [1.0, -1.0, -1.0]
    assert robot.legs[hind].forward(mirrored) == pytest.approx(feet, abs=1e-12)
    assert robot.legs[hind].inverse(feet) == pytest.approx(mirrored, abs=1e-7)


@each_leg
def test_signs_turn_the_angles_and_nothing_else(leg):
    signs = np.array([1.0, -1.0, -1.0])
    turned = replace(leg, signs=signs * leg.signs)
    angles = random_angles(np.random.default_rng(15), leg, 50)
    vectors = np.random.default_rng(16).normal(size=angles.shape)
    foot = leg.forward(angles)
    assert turned.forward(signs * angles) == pytest.approx(foot, abs=1e-15)
    assert turned.inverse(foot) == pytest.approx(signs * leg.inverse(foot), abs=1e-12)
    assert turned.jacobian(signs * angles) == pytest.approx(leg.jacobian(angles) * signs)
    speeds = leg.joint_velocities(angles, vectors)
    assert turned.joint_velocities(signs * angles, vectors) == pytest.approx(signs * speeds)
    spin = leg.angular_velocity(angles, vectors)
    assert turned.angular_velocity(signs * angles, signs * vectors) == pytest.approx(spin)


def test_any_number_of_leading_axes_is_a_batch():
    leg = ROBOT.legs[1]
    angles = random_angles(np.random.default_rng(11), leg, 24).reshape(2, 3, 4, 3)
    feet = leg.forward(angles)
    assert feet.shape == (2, 3, 4, 3)
    assert leg.jacobian(angles).shape == (2, 3, 4, 3, 3)
    assert feet[1, 2, 3] == pytest.approx(leg.forward(angles[1, 2, 3]), abs=1e-15)
    assert leg.inverse(feet)[1, 2, 3] == pytest.approx(leg.inverse(feet[1, 2, 3]), abs=1e-14)


@each_robot
def test_nothing_is_done_to_what_is_given(robot):
    angles = robot.initial_joint_angles.copy()
    feet = robot.neutral_feet.copy()
    velocities = np.ones_like(feet)
    legs = robot.stacked_legs
    for array, use in (
        (angles, lambda: legs.forward(angles)),
        (angles, lambda: legs.jacobian(angles)),
        (feet, lambda: legs.inverse(feet)),
        (velocities, lambda: legs.joint_velocities(angles, velocities)),
    ):
        before = array.copy()
        use()
        assert (array == before).all()


def test_links_of_equal_length_may_fold_completely():
    leg = yaw_pitch_pitch_leg(LegPlace('lf', ORIGIN, 1), LegLengths(0.1, 0.0, 0.2, 0.2))
    assert leg.reach() == (0.0, 0.4)
    on_the_axis = np.array([0.0, 0.1, 0.0])
    angles = leg.inverse(on_the_axis)
    assert np.isfinite(angles).all()
    assert leg.forward(angles) == pytest.approx(on_the_axis, abs=1e-8)


def test_a_foot_on_the_first_axis_is_reached_at_any_turn():
    leg = ROBOT.legs[0]
    below = leg.hip - [0.0, 0.0, 0.25]
    angles = leg.inverse(below)
    assert np.isfinite(angles).all()
    assert leg.forward(angles) == pytest.approx(below, abs=1e-12)


def test_a_foot_just_beside_the_first_axis_by_the_lateral_offset_is_reached():
    leg = ROBOTS['genibo'].legs[0]
    beside = leg.hip + leg.lateral_offset * leg.lateral_direction + [0.05, 0.0, 0.0]
    assert leg.forward(leg.inverse(beside)) == pytest.approx(beside, abs=1e-9)


def test_the_posture_of_s1s_tables_is_its_foots_place():
    # Table II's lengths; Table III's angles have z downward.
    angles = np.array([0.0, -math.pi / 4, 3.0 * math.pi / 4])
    for a1, a2, a3, out, down in ((2.0, 6.0, 10.0, 6.243, 5.757), (1.0, 3.0, 5.0, 3.121, 2.879)):
        leg = yaw_pitch_pitch_leg(LegPlace('lf', ORIGIN, 1), LegLengths(a1, 0.0, a2, a3))
        assert leg.forward(angles) == pytest.approx([0.0, out, -down], abs=5e-4)
    assert ROBOTS['pukyong'].initial_joint_angles == pytest.approx(np.tile(angles, (4, 1)))
    arms = ROBOTS['pukyong'].neutral_feet - [leg.hip for leg in ROBOTS['pukyong'].legs]
    assert 100.0 * np.abs(arms[:, 1]) == pytest.approx(np.full(4, 6.243), abs=5e-4)
    assert 100.0 * arms[:, 2] == pytest.approx(np.full(4, -5.757), abs=5e-4)


def test_the_printed_height_of_s1s_table_is_not_that_of_its_angles():
    leg = yaw_pitch_pitch_leg(LegPlace('lf', ORIGIN, 1), LegLengths(1.0, 0.0, 3.0, 5.0))
    foot = leg.forward(np.array([0.0, -math.pi / 4, 3.0 * math.pi / 4]))
    assert abs(-foot[2] - 2.829) > 0.049


def s2_inverse(x, y, z, l1, l2, l3):
    """S2's eqs. 9 to 15, with y/x in (9) and arc tangents of two arguments."""
    theta1 = np.arctan2(y, x)
    X = x * np.cos(theta1) + y * np.sin(theta1)
    D = (l3**2 - l2**2 - l1**2 - z**2 + 2.0 * l1 * X - X**2) / (2.0 * l2)
    A, B = -z, l1 - X
    R = np.hypot(A, B)
    theta2 = np.arctan2(D, np.sqrt(R**2 - D**2)) - np.arctan2(B, A)
    theta23 = np.arctan2(z - l2 * np.sin(theta2), X - l1 - l2 * np.cos(theta2))
    return np.stack([theta1, theta2, theta23 - theta2], axis=-1)


@pytest.mark.parametrize('leg', ROBOTS['cuhk'].legs[:2], ids=LEGS[:2])
def test_the_inverse_is_that_of_s2_equations_9_to_15_for_front_legs(leg):
    # The paper's leg frame: x down, y to the left, z backward.
    l1, l2, l3 = 0.022, 0.053, 0.042
    feet = leg.forward(random_angles(np.random.default_rng(17), leg, 500))
    forward, left, up = (feet - leg.hip).T
    expected = s2_inverse(-up, left, -forward, l1, l2, l3)
    difference = leg.inverse(feet) - expected
    assert np.sin(difference) == pytest.approx(np.zeros((500, 3)), abs=1e-7)
    assert np.cos(difference) == pytest.approx(np.ones((500, 3)), abs=1e-7)


@pytest.mark.parametrize('leg', ROBOTS['cuhk'].legs, ids=LEGS)
def test_the_foot_is_where_s2_equation_8_puts_it(leg):
    l1, l2, l3 = 0.022, 0.053, 0.042
    angles = np.random.default_rng(18).uniform(-1.5, 1.5, (200, 3))
    q1, q2, q3 = angles.T
    length = l1 + l2 * np.cos(q2) + l3 * np.cos(q2 + q3)
    x, y = length * np.cos(q1), length * np.sin(q1)
    z = l2 * np.sin(q2) + l3 * np.sin(q2 + q3)
    assert leg.forward(angles) - leg.hip == pytest.approx(np.stack([-z, y, -x], axis=-1), abs=1e-15)


def test_the_circle_through_the_feet_is_that_of_s2_equation_1():
    L, W = 0.230, 0.115
    r = math.hypot(L / 2.0, W / 2.0)
    distances = np.linalg.norm(ROBOTS['cuhk'].neutral_feet[:, :2], axis=1)
    assert distances == pytest.approx(np.full(4, r), abs=1e-12)
