"""What the simulator says in messages is what it knows, with the noise that it admits."""

import math
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('trajectory_msgs')

from builtin_interfaces.msg import Time
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from trajectory_msgs.msg import JointTrajectoryPoint

from quad_common.errors import TrajectoryError
from quad_common.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot import load_robot
from quad_common.ros_conversions import pose_from_message, tilt_from_odometry
from quad_gait.body_motion import BodyMotion
from quad_gait.gait import load_gait
from quad_gait.gait_generator import generate_cycle
from quad_gait.ros_conversions import joints_from_message, trajectory_message
from quad_sim.kinematic_simulator import KinematicSimulator
from quad_sim.parameters import SimParameters
from quad_sim.ros_conversions import (
    base_transform,
    footprint_transform,
    grid_message,
    imu_message,
    joint_state_message,
    odometry_message,
    trajectory_from_message,
)

ROBOT = load_robot('titan_viii')
STAMP = Time(sec=12, nanosec=345)
POSE = Pose2D(1.0, -2.0, 2.5)


def observation(tilted=False):
    simulator = KinematicSimulator(ROBOT)
    simulator.reset(POSE)
    seen = simulator.observe()
    if not tilted:
        return seen
    quaternion = np.random.default_rng(1).normal(size=4)
    return replace(seen, orientation=quaternion / np.linalg.norm(quaternion))


def product(p, q):
    """Hamilton's product of quaternions xyzw."""
    (a, b, c, d), (e, f, g, h) = p, q
    return np.array(
        [
            d * e + a * h + b * g - c * f,
            d * f - a * g + b * h + c * e,
            d * g + a * f - b * e + c * h,
            d * h - a * e - b * f - c * g,
        ]
    )


def numbers(vector):
    return np.array([getattr(vector, name) for name in 'xyzw' if hasattr(vector, name)])


def odometry(seed=0, tilted=False, **noise):
    parameters = replace(SimParameters(), **noise)
    drawn = np.random.default_rng(seed).standard_normal(4)
    return odometry_message(observation(tilted), parameters, drawn, STAMP)


def test_without_noise_odometry_is_the_truth():
    message = odometry()
    pose = pose_from_message(message.pose.pose)
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.0, -2.0, 2.5))
    assert message.pose.pose.position.z == pytest.approx(ROBOT.standing_height)
    assert (message.header.frame_id, message.child_frame_id) == ('odom', 'base_link')
    assert message.header.stamp == STAMP
    assert tilt_from_odometry(message) == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize('tilted', [False, True])
def test_noise_of_the_heading_is_a_turn_about_the_vertical(tilted):
    seen = observation(tilted)
    angles = []
    for seed in range(300):
        told = numbers(odometry(seed, tilted, odom_yaw_noise=0.1).pose.pose.orientation)
        assert np.linalg.norm(told) == pytest.approx(1.0)
        x, y, z, w = product(told, seen.orientation * [-1.0, -1.0, -1.0, 1.0])
        assert (x, y) == pytest.approx((0.0, 0.0), abs=1e-12)
        angles.append(2.0 * math.atan2(z, w))
    assert np.std(angles) == pytest.approx(0.1, rel=0.15)
    assert np.mean(angles) == pytest.approx(0.0, abs=0.02)


def test_noise_of_the_position_has_the_standard_deviation_that_was_asked_for():
    told = [numbers(odometry(k, odom_position_noise=0.05).pose.pose.position) for k in range(400)]
    assert np.std(told, axis=0) == pytest.approx(np.full(3, 0.05), rel=0.15)
    expected = [1.0, -2.0, ROBOT.standing_height]
    assert np.mean(told, axis=0) == pytest.approx(expected, abs=0.01)


def test_the_covariance_is_the_noise_squared_and_never_zero():
    noisy = odometry(odom_position_noise=0.05, odom_yaw_noise=0.1)
    variances = np.reshape(noisy.pose.covariance, (6, 6)).diagonal()
    assert variances[[0, 1, 2, 5]] == pytest.approx([0.0025, 0.0025, 0.0025, 0.01])
    for message in (noisy, odometry()):
        for covariance in (message.pose.covariance, message.twist.covariance):
            matrix = np.reshape(covariance, (6, 6))
            assert (matrix.diagonal() > 0.0).all()
            assert (matrix == np.diag(matrix.diagonal())).all()


def test_the_same_draw_gives_the_same_message_and_another_draw_another():
    noise = {'odom_position_noise': 0.05, 'odom_yaw_noise': 0.1}
    assert odometry(7, **noise) == odometry(7, **noise)
    assert odometry(7, **noise) != odometry(8, **noise)


def test_the_transform_is_the_odometrys_pose():
    message = odometry(3, odom_position_noise=0.05, odom_yaw_noise=0.1)
    transform = base_transform(message)
    assert transform.header == message.header
    assert transform.child_frame_id == message.child_frame_id
    assert (numbers(transform.transform.translation) == numbers(message.pose.pose.position)).all()
    assert transform.transform.rotation == message.pose.pose.orientation


def test_the_footprint_is_on_the_ground_under_the_body_with_its_heading():
    message = odometry(3)
    transform = footprint_transform(message, 'base_footprint')
    assert transform.header == message.header
    assert transform.child_frame_id == 'base_footprint'
    assert transform.transform.translation.z == 0.0
    assert transform.transform.translation.x == message.pose.pose.position.x
    rotation = transform.transform.rotation
    assert (rotation.x, rotation.y) == (0.0, 0.0)
    assert 2.0 * math.atan2(rotation.z, rotation.w) == pytest.approx(POSE.yaw)


def test_the_imu_measures_gravity_upward_with_the_noise_that_it_admits():
    parameters = replace(SimParameters(), gyroscope_noise=0.01, accelerometer_noise=0.1)
    rng = np.random.default_rng(2)
    messages = [
        imu_message(observation(), parameters, rng.standard_normal((2, 3)), STAMP)
        for _ in range(300)
    ]
    forces = np.array([numbers(message.linear_acceleration) for message in messages])
    rates = np.array([numbers(message.angular_velocity) for message in messages])
    assert forces.mean(axis=0) == pytest.approx([0.0, 0.0, 9.80665], abs=0.03)
    assert forces.std(axis=0) == pytest.approx(np.full(3, 0.1), rel=0.2)
    assert rates.std(axis=0) == pytest.approx(np.full(3, 0.01), rel=0.2)
    message = messages[0]
    for covariance, sigma in (
        (message.linear_acceleration_covariance, 0.1),
        (message.angular_velocity_covariance, 0.01),
    ):
        assert np.reshape(covariance, (3, 3)) == pytest.approx(sigma**2 * np.eye(3))
    assert message.header.frame_id == 'base_link'


def test_joint_states_come_back_whatever_their_order():
    seen = replace(
        observation(), joint_positions=np.arange(12.0), joint_velocities=-np.arange(12.0)
    )
    message = joint_state_message(seen, ROBOT.joint_names, STAMP)
    order = np.random.default_rng(3).permutation(12)
    message.name = [message.name[k] for k in order]
    message.position = [message.position[k] for k in order]
    message.velocity = [message.velocity[k] for k in order]
    positions, velocities = joints_from_message(message, ROBOT)
    assert (positions == np.arange(12.0)).all()
    assert (velocities == -np.arange(12.0)).all()


def test_a_gait_cycle_comes_through_a_message_unharmed():
    cycle = generate_cycle(ROBOT, load_gait('crawl'), BodyMotion(forward=0.2))
    sent = cycle.trajectory(ROBOT, stamp=1234.567891234)
    received = trajectory_from_message(trajectory_message(sent))
    assert received.joint_names == sent.joint_names
    assert (received.positions == sent.positions).all()
    assert (received.velocities == sent.velocities).all()
    assert received.times == pytest.approx(sent.times, abs=1e-9)
    assert received.stamp == pytest.approx(sent.stamp, abs=1e-6)


def test_points_without_velocities_are_points_of_rest():
    message = JointTrajectoryMessage(joint_names=['a', 'b'])
    message.points = [JointTrajectoryPoint(positions=[1.0, 2.0])]
    trajectory = trajectory_from_message(message)
    assert trajectory.velocities.tolist() == [[0.0, 0.0]]
    assert trajectory.stamp == 0.0


@pytest.mark.parametrize(
    ('positions', 'velocities', 'told'),
    [
        ([1.0], [], 'point 0 has 1 positions and 0 velocities for 2 joints'),
        ([1.0, 2.0], [1.0], 'point 0 has 2 positions and 1 velocities for 2 joints'),
        ([1.0, math.nan], [], 'positions that are not finite'),
    ],
)
def test_a_malformed_trajectory_message_is_refused_in_a_sentence(positions, velocities, told):
    message = JointTrajectoryMessage(joint_names=['a', 'b'])
    message.points = [JointTrajectoryPoint(positions=positions, velocities=velocities)]
    with pytest.raises(TrajectoryError, match=told):
        trajectory_from_message(message)


@pytest.mark.parametrize('names', [[], ['a']])
def test_an_empty_trajectory_message_is_refused_in_a_sentence(names):
    with pytest.raises(TrajectoryError, match='it needs at least one'):
        trajectory_from_message(JointTrajectoryMessage(joint_names=names))


def test_a_grid_is_written_row_by_row_with_its_place():
    cells = np.random.default_rng(4).choice(np.array([-1, 0, 100], np.int8), (4, 7))
    message = grid_message(OccupancyGrid(cells, 0.05, POSE), 'map', STAMP)
    assert (message.info.width, message.info.height) == (7, 4)
    assert message.info.resolution == pytest.approx(0.05)
    assert list(message.data) == cells.reshape(-1).tolist()
    origin = pose_from_message(message.info.origin)
    assert (origin.x, origin.y, origin.yaw) == pytest.approx((POSE.x, POSE.y, POSE.yaw))
