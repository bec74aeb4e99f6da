"""Of a hostile message every conversion makes a valid value, or a `QuadError`; nothing else."""

from __future__ import annotations

import dataclasses
import math
import warnings
from array import array
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, PoseStamped, Twist
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import ColorRGBA
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import InvalidMessage, QuadError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.height_map_conversions import height_map_from_message, height_map_message
from quad_common.ros.image_conversions import (
    camera_info_message,
    camera_model_from_info,
    image_message,
    rgb_from_image,
)
from quad_common.ros.map_conversions import grid_from_message
from quad_common.ros.pose_conversions import (
    base_transform,
    check_clock,
    footprint_transform,
    grid_message,
    orientation_from_odometry,
    plan_from_message,
    pose_from_message,
    pose_message,
    seconds_from_time,
)
from quad_common.vision.camera import CameraModel
from quad_gait.ros_conversions import (
    imu_from_message,
    joints_from_message,
    polygon_message,
    twist_from_message,
)
from quad_lab.attacks.messages.changes import changes_of
from quad_lab.attacks.messages.mutations import leaves_of, replaced
from quad_perception.ros_conversions import legs_pose, robot_transforms
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.entities.obstacle_conversions import obstacle_changes_from_message
from quad_sim.ros_conversions import push_from_message, push_message, trajectory_from_message

pytestmark = pytest.mark.ros

ROBOT = load_robot('titan_viii')
FRAMES = ('map', 'odom')
STANDING = KinematicSimulator(ROBOT).observe()
STAMP = Time(sec=3, nanosec=5)


def stamped(message: Any, frame: str = 'map') -> Any:
    message.header.frame_id = frame
    message.header.stamp = STAMP
    return message


def odometry() -> Odometry:
    message = stamped(Odometry(child_frame_id='base_link'), 'odom')
    message.pose.pose = pose_message(Pose2D(1.0, 2.0, 0.5))
    message.twist.twist.linear.x = 0.1
    return message


def plan() -> Path:
    points = [Pose2D(0.0, 0.0, 0.0), Pose2D(1.0, 0.0, 1.5), Pose2D(1.0, 1.0, 0.0)]
    poses = [stamped(PoseStamped(pose=pose_message(pose))) for pose in points]
    return stamped(Path(poses=poses))


def grid() -> Any:
    cells = np.zeros((4, 5), np.int8)
    cells[1, 2] = 100
    return grid_message(OccupancyGrid(cells, 0.05, Pose2D(1.0, 2.0, 0.3)), 'map', STAMP)


def heights() -> Any:
    values = np.linspace(0.0, 0.1, 12).reshape(3, 4)
    return height_map_message(HeightMap(values, 0.05, (1.0, 2.0)), 'map', STAMP)


def joints() -> JointState:
    zeros = [0.1] * 12
    message = JointState(name=list(ROBOT.joint_names), position=zeros, velocity=zeros, effort=zeros)
    return stamped(message)


def imu() -> Imu:
    message = stamped(Imu())
    message.orientation.w = 1.0
    return message


def trajectory() -> JointTrajectory:
    message = stamped(JointTrajectory(joint_names=list(ROBOT.joint_names)))
    message.points = [
        JointTrajectoryPoint(
            positions=[0.1] * 12, velocities=[0.0] * 12, time_from_start=Duration(sec=second)
        )
        for second in (1, 2, 3)
    ]
    return message


def obstacles() -> MarkerArray:
    marker = stamped(Marker(ns='boxes', id=1, type=Marker.CUBE, action=Marker.ADD))
    marker.pose = pose_message(Pose2D(3.0, 3.0, 0.0))
    marker.scale.x = marker.scale.y = marker.scale.z = 0.5
    marker.color = ColorRGBA(r=1.0, g=0.5, b=0.0, a=1.0)
    marker.points = [Point()]
    return MarkerArray(markers=[marker])


CAMERA = CameraModel.looking_down((0.0, 0.0, 5.0), 0.0, 1.2, (32, 24), [0.1, 0.0, 0.0, 0.0, 0.0])


def camera_model(message: Any) -> CameraModel:
    return camera_model_from_info(message, CAMERA.rotation, CAMERA.position)


def leg_transforms(message: Odometry) -> Any:
    legs_pose(message, ('map',), 'odom')
    return robot_transforms(message, Pose2D(0.0, 0.0, 0.0), 'map', 'base_footprint')


def support_polygon(message: Odometry) -> Any:
    """Publish what stands around the robot, as the gait node does: in single precision."""
    pose = pose_from_message(message.pose.pose)
    corners = pose.transform(np.array([[0.4, 0.3], [-0.4, 0.3], [-0.4, -0.3]]))
    return polygon_message(corners, 'odom', STAMP)


CONVERSIONS: dict[str, tuple[Callable[[], Any], Callable[[Any], Any]]] = {
    'goal': (lambda: plan().poses[0], lambda m: pose_from_message(m.pose, 'goal')),
    'odometry pose': (odometry, lambda m: pose_from_message(m.pose.pose)),
    'odometry orientation': (odometry, orientation_from_odometry),
    'odometry stamp': (odometry, lambda m: seconds_from_time(m.header.stamp)),
    'base transform': (odometry, base_transform),
    'footprint transform': (odometry, lambda m: footprint_transform(m, 'base_footprint')),
    'support polygon': (odometry, support_polygon),
    'legs': (odometry, leg_transforms),
    'clock': (lambda: Clock(clock=STAMP), check_clock),
    'plan': (plan, plan_from_message),
    'map': (grid, grid_from_message),
    'height map': (heights, lambda m: height_map_from_message(m, FRAMES)),
    'joint states': (joints, lambda m: joints_from_message(m, ROBOT)),
    'imu': (imu, imu_from_message),
    'cmd_vel': (Twist, twist_from_message),
    'trajectory': (trajectory, trajectory_from_message),
    'obstacles': (obstacles, lambda m: obstacle_changes_from_message(m, FRAMES)),
    'push': (
        lambda: push_message(np.array([3.0, 4.0, 0.0]), 'map'),
        lambda m: push_from_message(m, ROBOT, STANDING, ('base_link', *FRAMES)),
    ),
    'camera_info': (lambda: camera_info_message(CAMERA, 'camera', STAMP), camera_model),
    'picture': (
        lambda: image_message(np.full((4, 5, 3), 90, np.uint8), 'camera', STAMP),
        rgb_from_image,
    ),
}


def mutations(message: Any) -> Iterator[tuple[str, Any]]:
    """Yield every message that differs in one field, with what is changed and how."""
    for leaf in leaves_of(message):
        value = message
        for part in leaf.path:
            value = value[part] if isinstance(part, int) else getattr(value, part)
        for kind, make in changes_of(value, leaf.kind):
            yield f'{leaf.name}: {kind}', replaced(message, leaf.path, make())


def numbers_of(value: Any) -> Iterator[float]:
    """Yield every number of a value, however it is nested."""
    if isinstance(value, HeightMap):
        # Unknown heights are NaN; all others are finite.
        yield from value.heights[~np.isnan(value.heights)].tolist()
    elif isinstance(value, (float, int, np.generic)):
        yield float(value)
    elif isinstance(value, np.ndarray):
        yield from value.astype(float).reshape(-1).tolist()
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from numbers_of(getattr(value, field.name))
    elif hasattr(value, 'get_fields_and_field_types'):
        for name in value.get_fields_and_field_types():
            yield from numbers_of(getattr(value, name))
    elif isinstance(value, (tuple, list)):
        for item in value:
            yield from numbers_of(item)


@pytest.mark.parametrize('name', CONVERSIONS)
def test_a_valid_message_is_converted(name):
    make, convert = CONVERSIONS[name]
    assert all(map(math.isfinite, numbers_of(convert(make()))))


@pytest.mark.parametrize('name', CONVERSIONS)
def test_of_a_hostile_message_comes_a_valid_value_or_a_refusal(name):
    make, convert = CONVERSIONS[name]
    refused, wrong = 0, []
    for what, message in mutations(make()):
        try:
            with warnings.catch_warnings():
                # An overflow that NumPy only warns of is one that was not thought of.
                warnings.simplefilter('error')
                value = convert(message)
        except QuadError as error:
            refused += 1
            if len(str(error)) > 1000 or not str(error).isprintable():
                wrong.append(f'{what}: says {str(error)[:300]!r}')
        except Exception as error:
            wrong.append(f'{what}: {type(error).__name__}: {error}')
        else:
            if not all(map(math.isfinite, numbers_of(value))):
                wrong.append(f'{what}: made {value}')
    assert not wrong, '\n'.join(wrong)
    assert refused > 0


@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1e7, 1e-45])
@pytest.mark.parametrize('channel', range(3))
@pytest.mark.parametrize('place', [slice(0, 1), slice(5, 6), slice(None)])
def test_of_hostile_points_comes_a_valid_height_map_or_a_refusal(channel, value, place):
    message = heights()
    points = np.frombuffer(message.data, np.float32).reshape(-1, 3).copy()
    points[place, channel] = value
    message.data = array('B', points.tobytes())
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        try:
            read = height_map_from_message(message, FRAMES)
        except InvalidMessage:
            return
    assert channel == 2 or abs(value) < 1.0
    assert all(map(math.isfinite, numbers_of(read)))
