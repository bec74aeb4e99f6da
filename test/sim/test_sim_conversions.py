"""What the simulator says in messages is what it knows, with the noise that it admits."""

import math
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('trajectory_msgs')

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion, TransformStamped
from sensor_msgs.msg import CameraInfo, Image
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from trajectory_msgs.msg import JointTrajectoryPoint
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import InvalidMessage, TrajectoryError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.parameters import parameters_of
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.image_conversions import (
    camera_info_message,
    camera_model_from_info,
    image_message,
    rgb_from_image,
)
from quad_common.ros.pose_conversions import (
    base_transform,
    camera_transform,
    footprint_transform,
    grid_message,
    orientation_from_odometry,
    pose_from_message,
    pose_message,
)
from quad_common.rotations import (
    matrix_from_angles,
    matrix_from_quaternion,
    quaternion_from_matrix,
    tilt_from_quaternion,
)
from quad_common.vision.camera import CameraModel
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import generate_cycle
from quad_gait.ros_conversions import joints_from_message, trajectory_message
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.entities.obstacle_conversions import obstacle_changes_from_message, obstacles_message
from quad_sim.parameters import SimParameters
from quad_sim.ros_conversions import (
    imu_message,
    joint_state_message,
    odometry_message,
    push_from_message,
    push_message,
    trajectory_from_message,
)
from quad_sim.world.obstacle_changes import ObstacleChange
from quad_sim.world.world import Obstacle

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
    assert tilt_from_quaternion(orientation_from_odometry(message)) == pytest.approx(0.0, abs=1e-7)


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


def frame_of(transform: TransformStamped) -> np.ndarray:
    """Pose of the child in its parent, shape (4, 4)."""
    rotation, frame = transform.transform.rotation, np.eye(4)
    frame[:3, :3] = matrix_from_quaternion(
        np.array([rotation.x, rotation.y, rotation.z, rotation.w])
    )
    frame[:3, 3] = numbers(transform.transform.translation)
    return frame


@pytest.mark.parametrize('seed', range(5))
def test_the_footprint_is_on_the_ground_under_the_body_with_its_heading(seed):
    message, rng = odometry(3), np.random.default_rng(seed)
    roll, pitch, yaw = rng.uniform([-0.6, -0.6, -3.1], [0.6, 0.6, 3.1])
    body = quaternion_from_matrix(matrix_from_angles(np.array([roll, pitch, yaw])))
    pose = message.pose.pose
    pose.orientation = Quaternion(**dict(zip('xyzw', map(float, body))))
    transform = footprint_transform(message, 'base_footprint', 0.07)
    assert transform.header.stamp == message.header.stamp
    # One chain: odom -> base_link -> base_footprint.
    assert transform.header.frame_id == message.child_frame_id == 'base_link'
    assert transform.child_frame_id == 'base_footprint'
    there = frame_of(base_transform(message)) @ frame_of(transform)
    assert there[:3, 3] == pytest.approx([pose.position.x, pose.position.y, 0.07])
    upright = matrix_from_angles(np.array([0.0, 0.0, yaw]))
    assert there[:3, :3] == pytest.approx(upright, abs=1e-9)


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


@pytest.mark.parametrize(
    'name', ['odom_position_noise', 'odom_yaw_noise', 'gyroscope_noise', 'accelerometer_noise']
)
def test_the_largest_noise_that_may_be_asked_for_is_measured_in_finite_numbers(name):
    noisy = next(one for one in parameters_of(SimParameters) if one.name == name)
    largest = 1e300 if noisy.upper is None else noisy.upper
    parameters = replace(SimParameters(), **{name: noisy.check(largest)})
    drawn = np.full((2, 3), 6.0)
    imu = imu_message(observation(), parameters, drawn, STAMP)
    legs = odometry_message(observation(), parameters, np.full(4, 6.0), STAMP)
    vectors = (imu.angular_velocity, imu.linear_acceleration, legs.pose.pose.position)
    assert all(np.isfinite(numbers(vector)).all() for vector in vectors)
    for covariance in (
        imu.angular_velocity_covariance,
        imu.linear_acceleration_covariance,
        legs.pose.covariance,
    ):
        assert np.isfinite(covariance).all()


def test_joint_states_come_back_whatever_their_order():
    seen = replace(
        observation(), joint_positions=np.arange(12.0), joint_velocities=-np.arange(12.0)
    )
    message = joint_state_message(seen, ROBOT.joint_names, STAMP)
    order = np.random.default_rng(3).permutation(12)
    message.name = [message.name[k] for k in order]
    message.position = [message.position[k] for k in order]
    message.velocity = [message.velocity[k] for k in order]
    positions, velocities, *_ = joints_from_message(message, ROBOT)
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


CAMERA = CameraModel.looking_down(
    (4.0, 3.0, 6.0), 0.7, 1.3, (64, 48), (-0.2, 0.05, 0.001, -0.002, 0.01)
)


def test_a_picture_comes_through_a_message_unharmed():
    rgb = np.random.default_rng(5).integers(0, 256, (48, 64, 3)).astype(np.uint8)
    message = image_message(rgb, 'ceiling_camera', STAMP)
    assert (message.encoding, message.step) == ('rgb8', 192)
    assert (message.header.frame_id, message.header.stamp) == ('ceiling_camera', STAMP)
    assert (rgb_from_image(message) == rgb).all()
    # Columns of a larger picture are not next to each other in memory.
    assert (rgb_from_image(image_message(rgb[:, 10:30], 'c', STAMP)) == rgb[:, 10:30]).all()


@pytest.mark.parametrize('padding', [0, 5])
@pytest.mark.parametrize('encoding', ['rgb8', 'bgr8', 'mono8'])
def test_pictures_of_other_encodings_and_with_padded_rows_are_read(encoding, padding):
    rgb = np.random.default_rng(6).integers(0, 256, (5, 7, 3)).astype(np.uint8)
    if encoding == 'mono8':
        rgb = np.repeat(rgb[..., :1], 3, axis=2)
    pixels = {'rgb8': rgb, 'bgr8': rgb[..., ::-1], 'mono8': rgb[..., :1]}[encoding]
    rows = np.pad(pixels.reshape(5, -1), ((0, 0), (0, padding)), constant_values=99)
    message = Image(height=5, width=7, encoding=encoding, step=rows.shape[1], data=rows.tobytes())
    assert (rgb_from_image(message) == rgb).all()


@pytest.mark.parametrize(
    ('changes', 'told'),
    [
        ({'encoding': '16UC1'}, "its encoding is '16UC1'; known are rgb8, bgr8, mono8"),
        ({'encoding': ''}, "its encoding is ''"),
        ({'width': 0}, 'it has 0 x 4 pixels'),
        ({'step': 5}, r'4 x 4 pixels in rgb8 take 4 rows of at least 12 bytes; it has 48 bytes'),
        ({'step': 13}, 'it has 48 bytes in rows of 13'),
        ({'data': bytes(47)}, 'it has 47 bytes in rows of 12'),
        ({'height': 3}, 'take 3 rows'),
    ],
)
def test_a_malformed_picture_is_refused_in_a_sentence(changes, told):
    fields = {'height': 4, 'width': 4, 'encoding': 'rgb8', 'step': 12, 'data': bytes(48)}
    with pytest.raises(InvalidMessage, match=told):
        rgb_from_image(Image(**{**fields, **changes}))


def test_a_camera_comes_through_its_info_unharmed():
    message = camera_info_message(CAMERA, 'ceiling_camera', STAMP)
    again = camera_model_from_info(message, CAMERA.rotation, CAMERA.position)
    points = np.random.default_rng(7).uniform((2.0, 1.0, 0.0), (6.0, 5.0, 1.0), (50, 3))
    assert again.project(points) == pytest.approx(CAMERA.project(points), abs=1e-9)
    assert (again.width, again.height) == (64, 48)
    assert message.distortion_model == 'plumb_bob'
    # For ROS the first pixel's center is at 0, so the middle of 64 is at 31.5.
    assert (message.k[2], message.k[5]) == pytest.approx((31.5, 23.5))
    assert np.reshape(message.p, (3, 4))[:, :3] == pytest.approx(np.reshape(message.k, (3, 3)))


def test_a_camera_without_distortion_may_leave_it_out():
    message = camera_info_message(CAMERA, 'c', STAMP)
    message.d, message.distortion_model = [], ''
    assert not camera_model_from_info(message, np.eye(3), np.zeros(3)).distortion.any()


@pytest.mark.parametrize(
    ('changes', 'told'),
    [
        ({'k': np.zeros(9)}, 'the camera is not calibrated'),
        ({'distortion_model': 'equidistant', 'd': [0.1] * 4}, "it must be 'plumb_bob'"),
        ({'d': [0.1] * 8}, "'plumb_bob' with 8 numbers"),
        ({'binning_x': 2}, 'binning'),
    ],
)
def test_an_info_that_is_not_understood_is_refused_in_a_sentence(changes, told):
    message = camera_info_message(CAMERA, 'c', STAMP)
    for name, value in changes.items():
        setattr(message, name, value)
    with pytest.raises(InvalidMessage, match=told):
        camera_model_from_info(message, np.eye(3), np.zeros(3))
    assert camera_model_from_info(camera_info_message(CAMERA, 'c', STAMP), np.eye(3), np.zeros(3))


def test_no_info_at_all_is_refused():
    with pytest.raises(InvalidMessage, match='not calibrated'):
        camera_model_from_info(CameraInfo(), np.eye(3), np.zeros(3))


@pytest.mark.parametrize('yaw', [0.0, 0.7, math.pi / 2, math.pi, -2.5])
def test_the_cameras_transform_is_its_pose(yaw):
    model = CameraModel.looking_down((1.0, 2.0, 3.0), yaw, 1.0)
    transform = camera_transform(model, 'map', 'ceiling_camera', STAMP)
    x, y, z, w = numbers(transform.transform.rotation)
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    assert rotation == pytest.approx(model.rotation, abs=1e-9)
    assert numbers(transform.transform.translation) == pytest.approx([1.0, 2.0, 3.0])
    assert (transform.header.frame_id, transform.child_frame_id) == ('map', 'ceiling_camera')


def marker(**fields):
    one = Marker(ns='n', id=4, type=Marker.CUBE, action=Marker.ADD)
    one.header.frame_id = 'odom'
    one.pose = pose_message(POSE)
    one.scale.x, one.scale.y, one.scale.z = 0.8, 0.4, 0.6
    for name, value in fields.items():
        setattr(one, name, value)
    return one


def changes_from(*markers):
    return obstacle_changes_from_message(MarkerArray(markers=list(markers)), ('map', 'odom'))


def test_markers_become_obstacles_in_order():
    gone = Marker(ns='n', id=5, action=Marker.DELETE)
    put, removed, cleared = changes_from(marker(), gone, Marker(action=Marker.DELETEALL))
    assert put.name == ('n', 4)
    assert (put.obstacle.kind, put.obstacle.color) == ('box', None)
    assert (put.obstacle.length, put.obstacle.width, put.obstacle.height) == (0.8, 0.4, 0.6)
    assert put.obstacle.pose.distance_to(POSE) < 1e-9
    assert removed == ObstacleChange(('n', 5), None)
    assert cleared == ObstacleChange(None, None)


def test_a_markers_color_is_the_obstacles_and_a_cylinders_scale_its_diameter():
    one = marker(type=Marker.CYLINDER)
    one.scale.y = 0.8
    one.color.r, one.color.b, one.color.a = 1.0, 0.5, 1.0
    (put,) = changes_from(one)
    assert put.obstacle.kind == 'cylinder'
    assert put.obstacle.outer_radius == 0.4
    assert put.obstacle.color == (255, 0, 128)


def test_a_marker_with_a_color_out_of_range_or_too_large_is_refused():
    one = marker()
    one.color.g = 2.0
    with pytest.raises(InvalidMessage, match=r"marker 'n' 4 on 'obstacles' .* from 0 to 1"):
        changes_from(one)
    one = marker()
    one.scale.x = 1e6
    with pytest.raises(InvalidMessage, match=r'each side must be from 0\.001 to 100 m'):
        changes_from(one)


def test_obstacles_that_stand_are_published_as_they_were_put():
    put = {
        ('mine', 3): Obstacle.box(Pose2D(1.0, 2.0, 0.5), 0.4, 0.3, 0.2, (10, 20, 30)),
        ('room', 0): Obstacle.cylinder(-1.0, 0.0, 0.25, 0.6),
    }
    message = obstacles_message(put, 'map', (205, 50, 35))
    cleared, *changes = obstacle_changes_from_message(message, ('map',))
    assert cleared == ObstacleChange(None, None)
    assert [change.name for change in changes] == list(put)
    for change, obstacle in zip(changes, put.values(), strict=True):
        read = change.obstacle
        assert (read.kind, read.length, read.width, read.height) == (
            obstacle.kind, obstacle.length, obstacle.width, obstacle.height,
        )  # fmt: skip
        assert read.pose.distance_to(obstacle.pose) < 1e-9
        assert read.color == (obstacle.color or (205, 50, 35))
    assert message.markers[1].pose.position.z == pytest.approx(0.1)


def push(x=0.0, y=0.0, z=0.0, frame='map'):
    return push_message(np.array([x, y, z]), frame)


def force_of(message):
    return push_from_message(message, ROBOT, observation(tilted=True), ('base_link', 'map'))


def test_a_push_is_along_the_axes_of_its_frame():
    force = np.array([30.0, -20.0, 100.0])
    np.testing.assert_array_equal(force_of(push(*force)), force)
    turned = matrix_from_quaternion(observation(tilted=True).orientation)
    np.testing.assert_allclose(force_of(push(*force, frame='base_link')), turned @ force)


@pytest.mark.parametrize('part', [math.nan, math.inf, -1e308, 7846.0])
def test_a_push_that_nobody_can_give_is_refused(part):
    with pytest.raises(InvalidMessage, match=r'N; it must be at most 7845 N, 20 times the weight'):
        force_of(push(y=part))
    assert force_of(push(y=7845.0))[1] == 7845.0


def test_the_weight_limits_a_push_and_not_its_parts():
    with pytest.raises(InvalidMessage, match=r'force is \(6000, 6000, 0\) N'):
        force_of(push(6000.0, 6000.0))


def test_a_push_that_turns_or_has_no_frame_is_refused():
    message = push(1.0)
    message.wrench.torque.x = math.nan
    with pytest.raises(InvalidMessage, match='its torque is not zero'):
        force_of(message)
    with pytest.raises(InvalidMessage, match="in frame ''; give it in 'base_link'"):
        force_of(push(1.0, frame=''))
