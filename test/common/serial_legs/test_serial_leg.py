"""
Legs of any three axes: what closed forms give, and where there are none, what they would have to.
"""

import numpy as np
import pytest

from quad_common.errors import FootOutsideWorkspace, FootTargetUnreachable, SingularPosture
from quad_common.robot.leg_kinematics import stack_legs
from quad_common.robot_files.robot_file import load_robot
from quad_common.serial_legs.serial_leg import AxesAtZero, serial_leg
from quad_lab.robots.numeric_kinematics import iterated_legs

LOWER, UPPER = np.array([-0.9, -0.5, -2.6]), np.array([0.9, 2.2, -0.3])
NOMINAL = np.array([0.0, 0.75, -1.5])
POINTS = np.array([[0.2, 0.06, 0.0], [0.2, 0.14, 0.0], [0.2, 0.14, -0.22]])
FOOT = np.array([0.2, 0.15, -0.44])

BUILDS = {
    'skewed hips': ((0.93, 0.34, -0.16), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)),
    'turned knees': ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.2, 0.96, 0.2)),
    'all askew': ((0.9, 0.3, 0.3), (-0.2, 0.9, 0.1), (0.3, 0.9, -0.3)),
}


RANGES = {'narrow': (LOWER, UPPER), 'nearly whole turns': (np.full(3, -3.1), np.full(3, 3.1))}


def leg_of(axes, name='lf', points=POINTS, nominal=NOMINAL, ranges='narrow'):
    axes = np.array(axes) / np.linalg.norm(axes, axis=1, keepdims=True)
    return serial_leg(name, AxesAtZero(axes, points, FOOT), *RANGES[ranges], nominal)


def near_nominal(count, spread=0.25, seed=3):
    rng = np.random.default_rng(seed)
    return NOMINAL + rng.uniform(-spread, spread, (count, 3))


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('name', ['genibo', 'pukyong', 'cuhk', 'titan_viii'])
def test_it_is_the_closed_form_where_there_is_one(name):
    robot = load_robot(name)
    legs, closed = iterated_legs(robot), robot.stacked_legs
    rng = np.random.default_rng(5)
    spread = rng.uniform(-0.3, 0.3, (100, 4, 3))
    angles = np.clip(robot.initial_joint_angles + spread, robot.lower, robot.upper)
    speeds = rng.normal(size=angles.shape)
    feet = closed.forward(angles)
    assert np.allclose(legs.forward(angles), feet, atol=1e-12)
    for own, other in zip(legs.chain(angles), closed.chain(angles)):
        assert np.allclose(own, other, atol=1e-12)
    assert np.abs(legs.inverse(feet) - closed.inverse(feet)).max() < 1e-6
    assert np.allclose(legs.jacobian(angles), closed.jacobian(angles), atol=1e-12)
    assert np.allclose(
        legs.joint_velocities(angles, speeds), closed.joint_velocities(angles, speeds), atol=1e-8
    )
    assert np.allclose(
        legs.angular_velocity(angles, speeds), closed.angular_velocity(angles, speeds), atol=1e-12
    )
    assert np.allclose(legs.bends(angles), closed.bends(angles), atol=1e-7)


@pytest.mark.parametrize('build', BUILDS)
def test_the_inverse_undoes_the_forward(build):
    leg = leg_of(BUILDS[build])
    angles = near_nominal(300)
    assert np.abs(leg.inverse(leg.forward(angles)) - angles).max() < 1e-6


@pytest.mark.parametrize('ranges', RANGES)
@pytest.mark.parametrize('build', BUILDS)
def test_angles_are_continuous_along_a_path(build, ranges):
    leg = leg_of(BUILDS[build], ranges=ranges)
    turn = np.linspace(0.0, 2.0 * np.pi, 2001)
    circle = 0.08 * np.column_stack([np.cos(turn), 0.4 * np.sin(turn), np.sin(turn)])
    angles = leg.inverse(leg.forward(NOMINAL) + circle)
    # One sample is 0.25 mm from the next.
    assert np.abs(np.diff(angles, axis=0)).max() < 0.01
    assert np.allclose(angles[0], angles[-1], atol=1e-9)


@pytest.mark.parametrize('ranges', RANGES)
@pytest.mark.parametrize('build', BUILDS)
def test_a_foot_led_along_regular_postures_is_found_in_them(build, ranges):
    leg = leg_of(BUILDS[build], ranges=ranges)
    lower, upper = leg.window()
    ends = np.clip(near_nominal(150, 1.2), lower, upper)
    lines = NOMINAL + np.linspace(0.0, 1.0, 60)[None, :, None] * (ends - NOMINAL)[:, None]
    sizes = np.linalg.det(leg.jacobian(lines)) / np.linalg.det(leg.jacobian(NOMINAL))
    is_regular = np.cumprod(sizes > 0.05, axis=1).astype(bool)
    assert is_regular.mean() > 0.7
    feet = leg.forward(lines[is_regular])
    assert np.abs(leg.inverse(feet) - lines[is_regular]).max() < 1e-6


def test_narrow_ranges_are_used_whole():
    for axes in BUILDS.values():
        lower, upper = leg_of(axes).window()
        assert np.array_equal(lower, LOWER)
        assert np.array_equal(upper, UPPER)


@pytest.mark.parametrize('build', BUILDS)
def test_an_answer_depends_on_its_place_alone(build):
    leg = leg_of(BUILDS[build])
    feet = leg.forward(near_nominal(50))
    one_by_one = np.array([leg.inverse(foot) for foot in feet])
    assert np.array_equal(one_by_one, leg.inverse(feet))


@pytest.mark.parametrize('build', BUILDS)
def test_the_jacobian_is_what_differences_give(build):
    leg = leg_of(BUILDS[build])
    angles = near_nominal(20)
    for joint in range(3):
        step = 1e-6 * np.eye(3)[joint]
        difference = (leg.forward(angles + step) - leg.forward(angles - step)) / 2e-6
        assert np.allclose(leg.jacobian(angles)[..., joint], difference, atol=1e-8)
    speeds = np.random.default_rng(4).normal(size=(20, 3))
    feet = np.einsum('nij,nj->ni', leg.jacobian(angles), speeds)
    assert np.allclose(leg.joint_velocities(angles, feet), speeds, atol=1e-9)


def test_stacked_legs_are_the_single_ones():
    legs = [leg_of(axes, name) for name, axes in zip(('lf', 'rf', 'lh'), BUILDS.values())]
    stacked = stack_legs(legs)
    angles = near_nominal(30).reshape(10, 3, 3)
    feet = stacked.forward(angles)
    found = stacked.inverse(feet)
    for k, leg in enumerate(legs):
        assert np.allclose(leg.forward(angles[:, k]), feet[:, k], atol=1e-15)
        assert np.array_equal(leg.inverse(feet[:, k]), found[:, k])
    least, largest = stacked.reach()
    assert least.shape == largest.shape == (3,)


@pytest.mark.parametrize(
    'place', [(0.2, 0.14, -1.0), (3.0, 0.0, 0.0), (0.2, 0.14, np.nan), (np.inf, 0.0, 0.0)]
)
def test_what_a_leg_does_not_reach_is_said(place):
    leg = leg_of(BUILDS['skewed hips'])
    with pytest.raises(FootOutsideWorkspace, match='foot lf') as error:
        leg.inverse(np.array([leg.forward(NOMINAL), place]))
    assert isinstance(error.value, FootTargetUnreachable)
    assert leg.reaches(np.array([leg.forward(NOMINAL), place])).tolist() == [True, False]


def test_how_far_it_falls_short_is_said():
    leg = leg_of(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)))
    longest = POINTS[1] + [0.0, 0.01, -0.44]
    with pytest.raises(FootOutsideWorkspace) as error:
        leg.inverse(longest - [0.0, 0.0, 0.05])
    assert error.value.short == pytest.approx(0.05, abs=0.005)


def test_legs_that_move_in_one_plane_are_refused():
    leg = leg_of([(0.0, 1.0, 0.0)] * 3)
    with pytest.raises(SingularPosture, match='lf'):
        leg.inverse(leg.forward(NOMINAL))
    with pytest.raises(SingularPosture):
        leg.joint_velocities(NOMINAL, np.ones(3))


def test_the_other_posture_of_a_place_is_another_legs():
    backward = leg_of(BUILDS['skewed hips'])
    lower, upper = np.array([-0.9, -2.2, -2.6]), np.array([0.9, 2.2, 2.6])
    at_zero = AxesAtZero(backward.axes, backward.points, backward.foot)
    forward = serial_leg('lf', at_zero, lower, upper, NOMINAL * [1.0, -1.0, -1.0])
    feet = backward.forward(near_nominal(50, 0.15))
    found = forward.inverse(feet)
    assert np.allclose(forward.forward(found), feet, atol=1e-9)
    assert (found[:, 2] > 0.0).all()
    assert (backward.inverse(feet)[:, 2] < 0.0).all()
