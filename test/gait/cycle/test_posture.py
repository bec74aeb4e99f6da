"""Sitting down and standing up: the feet stay, the body goes down and up."""

import numpy as np
import pytest

from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.posture import crouching_joint_angles, posture_trajectory

ROBOTS = {name: load_robot(name) for name in available_robots()}
CROUCHING = {name: crouching_joint_angles(robot) for name, robot in ROBOTS.items()}

each_robot = pytest.mark.parametrize('name', ROBOTS)


@each_robot
def test_crouching_the_feet_stay_where_they_are_and_the_body_is_lower(name):
    robot = ROBOTS[name]
    off = robot.foot_positions(CROUCHING[name]) - robot.neutral_feet
    assert off[:, :2] == pytest.approx(np.zeros((4, 2)), abs=1e-9)
    # All by the same height, up in the body's frame: and by a good part of it.
    assert np.ptp(off[:, 2]) == pytest.approx(0.0, abs=1e-9)
    assert 0.2 * robot.hip_height < off[0, 2] < robot.standing_height


@each_robot
def test_crouching_the_joints_are_within_their_limits(name):
    ROBOTS[name].check_joint_limits(CROUCHING[name])


@each_robot
def test_crouching_nothing_is_below_the_ground(name):
    robot, angles = ROBOTS[name], CROUCHING[name]
    feet = robot.foot_positions(angles)
    height = robot.foot_radius - feet[:, 2].mean()
    bottom = height + robot.body_center[2] - robot.body_size[2] / 2.0
    assert bottom >= 0.01 - 1e-9
    pitch_axis, knee, _ = robot.stacked_legs.chain(angles)
    assert (pitch_axis[:, 2] + height - robot.links['hip'].radius > 0.0).all()
    assert (knee[:, 2] + height - robot.links['thigh'].radius > 0.0).all()
    assert (knee[:, 2] + height - robot.links['calf'].radius > 0.0).all()


@each_robot
def test_crouching_left_mirrors_right(name):
    robot = ROBOTS[name]
    pitch_axis, knee, feet = robot.stacked_legs.chain(CROUCHING[name])
    for points in (pitch_axis, knee, feet):
        assert points[[1, 0, 3, 2]] * [1.0, -1.0, 1.0] == pytest.approx(points, abs=1e-9)


@each_robot
def test_on_the_way_down_the_feet_stay_near_their_places_and_above_nothing(name):
    robot = ROBOTS[name]
    trajectory = posture_trajectory(
        robot, robot.initial_joint_angles.reshape(-1), CROUCHING[name], 5.0, 2.0, 0.05
    )
    feet = robot.foot_positions(trajectory.positions.reshape(-1, 4, 3))
    # All four rise alike in the body's frame, so that the body comes down level.
    assert np.ptp(feet[..., 2], axis=1).max() < 0.05 * robot.hip_height
    off = np.linalg.norm(feet[..., :2] - robot.neutral_feet[:, :2], axis=-1)
    assert off.max() < 0.35 * robot.hip_height


@each_robot
def test_a_posture_is_reached_from_any_other_at_rest_at_both_ends(name):
    robot = ROBOTS[name]
    rng = np.random.default_rng(1)
    start = rng.uniform(robot.lower, robot.upper).reshape(-1)
    trajectory = posture_trajectory(robot, start, robot.initial_joint_angles, 5.0, 2.0, 0.03)
    assert trajectory.joint_names == robot.joint_names
    assert (trajectory.stamp, trajectory.times[0], trajectory.end) == (5.0, 0.0, 7.0)
    assert np.diff(trajectory.times).max() <= 0.03 + 1e-9
    assert trajectory.positions[0] == pytest.approx(start)
    assert trajectory.positions[-1] == pytest.approx(robot.initial_joint_angles.reshape(-1))
    assert trajectory.velocities[[0, -1]] == pytest.approx(np.zeros((2, 12)), abs=1e-12)


def test_every_joint_goes_straight_to_its_place_and_its_velocity_is_the_derivative():
    robot = ROBOTS['titan_viii']
    start = robot.initial_joint_angles.reshape(-1) + np.linspace(-0.3, 0.3, 12)
    trajectory = posture_trajectory(robot, start, CROUCHING['titan_viii'], 0.0, 2.0, 0.001)
    change = trajectory.positions[-1] - start
    steps = np.diff(trajectory.positions, axis=0)
    assert (steps * np.sign(change) >= -1e-12).all()
    h = trajectory.times[1]
    difference = (trajectory.positions[2:] - trajectory.positions[:-2]) / (2.0 * h)
    assert trajectory.velocities[1:-1] == pytest.approx(difference, abs=1e-5)
    # Minimum jerk is at most 1.875 times as fast as evenly.
    fastest = np.abs(trajectory.velocities).max(axis=0)
    assert fastest == pytest.approx(1.875 * np.abs(change) / 2.0, rel=1e-3)
