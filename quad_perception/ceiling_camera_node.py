"""
The node that sees the room from the ceiling: map, goal and the robot's pose (S1).
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_perception.__main__ import main as start

    raise SystemExit(start())

from typing import Any

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.qos import (
    DurabilityPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from sensor_msgs.msg import CameraInfo, Image

from quad_common.errors import QuadError
from quad_common.robot.robot import load_robot
from quad_common.ros.image_conversions import (
    camera_model_from_info,
    image_message,
    rgb_from_image,
)
from quad_common.ros.pose_conversions import (
    camera_transform,
    checked_name,
    grid_message,
    pose_message,
    seconds_from_time,
)
from quad_common.ros.ros_node import OK, STALE, WARN, QuadNode
from quad_common.ros.run_node import run_node
from quad_common.ros.stamp_order import StampOrder
from quad_common.vision.camera import CameraModel
from quad_common.vision.camera_file import load_camera
from quad_common.vision.markers import Color, GoalMarker, RobotMarker
from quad_perception.parameters import CeilingCameraParameters
from quad_perception.picture.annotated import annotated
from quad_perception.picture.perception import Perceiver, default_ranges
from quad_perception.ros_conversions import (
    fused_odometry,
    is_same_lens,
    legs_pose,
    robot_transforms,
    seen_pose_message,
)
from quad_perception.tracking.pose_fusion import FusionOptions
from quad_perception.tracking.scene_tracker import SceneTracker, Sighting, TrackerOptions

try:
    from tf2_msgs.msg import TFMessage
except ImportError:
    TFMessage = None

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Of pictures that come faster than they are worked on, the newest counts."""

_LONGEST_PAUSE = 60.0
"""Odometry that goes on farther ahead is of another time [s]."""


class CeilingCameraNode(QuadNode[CeilingCameraParameters]):
    """Publishes the map, the goal, and where the robot is: the fused pose as odometry."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('ceiling_camera_node', CeilingCameraParameters, **kwargs)
        p = self.parameters
        self._robot = load_robot(p.robot)
        self._robot_marker = RobotMarker.on(
            self._robot, color_of(p.front_color), color_of(p.rear_color)
        )
        self._goal_marker = GoalMarker(
            color=color_of(p.goal_color), heading_color=color_of(p.goal_heading_color)
        )
        self._place = self._camera_place()
        self._info: CameraInfo | None = None
        self._watch: SceneTracker | None = None
        self._camera_problem: QuadError | None = None
        self._picture_problem: QuadError | None = None
        self._odometry_problem: QuadError | None = None
        self._robot_problem: QuadError | None = None
        self._goal_problem: QuadError | None = None
        self._picture_order = StampOrder('image', patience=3)
        self._odometry_order = StampOrder(p.odometry_topic, _LONGEST_PAUSE)
        self._legs_at: float | None = None
        self._seen_at: float | None = None
        self._goal: PoseStamped | None = None

        sensor = qos_profile_sensor_data
        self._maps = self.create_publisher(OccupancyGrid, 'map', _LATCHED)
        self._goals = self.create_publisher(PoseStamped, 'goal_pose', 10)
        self._poses = self.create_publisher(
            PoseWithCovarianceStamped, 'ceiling_camera/robot_pose', 10
        )
        self._odometry = self.create_publisher(Odometry, 'odom/camera', sensor)
        self._pictures = self.create_publisher(Image, 'ceiling_camera/image_annotated', sensor)
        self._static_transforms, self._transforms = self._make_transforms()
        self.create_subscription(CameraInfo, 'ceiling_camera/camera_info', self._on_info, sensor)
        self.create_subscription(Image, 'ceiling_camera/image_raw', self._on_picture, _NEWEST)
        self.create_subscription(Odometry, p.odometry_topic, self._on_odometry, sensor)
        self.update_status()

    def update_status(self) -> None:
        """Say what is seen, or what is missing."""
        clock_problem = self.clock_problem()
        problem = self._camera_problem or self._picture_problem or self._odometry_problem
        if clock_problem is not None:
            self.report(STALE, clock_problem)
        elif problem is not None:
            self.report_error(problem)
        elif self._info is None:
            self.report(WARN, "no camera_info: waiting for it on 'ceiling_camera/camera_info'")
        elif self._seen_at is None:
            self.report(WARN, "no picture: waiting for one on 'ceiling_camera/image_raw'")
        elif self._since(self._seen_at) > self.parameters.largest_age:
            self.report(WARN, f'the last picture is {self._since(self._seen_at):.1f} s old')
        elif self._legs_at is None or self._since(self._legs_at) > self.parameters.largest_age:
            topic = self.parameters.odometry_topic
            self.report(WARN, f"no odometry: waiting for it on '{topic}'")
        elif self._robot_problem is not None:
            self.report(WARN, str(self._robot_problem))
        elif self._goal_problem is not None:
            self.report(WARN, str(self._goal_problem))
        else:
            self.report(OK, 'the map, and the robot on it, are seen')

    def _since(self, time: float) -> float:
        """Return how long ago something was [s]."""
        return float(self.get_clock().now().nanoseconds) * 1e-9 - time

    def _camera_place(self) -> CameraModel:
        """Return where the camera is; its lens comes with camera_info."""
        p = self.parameters
        if p.camera_file:
            return load_camera(p.camera_file)
        return CameraModel.looking_down(p.camera_position, p.camera_yaw, 1.0)

    def _on_info(self, message: CameraInfo) -> None:
        try:
            # The last good one is kept: what was seen with it must not be lost for a bad one.
            if self._info is not None and is_same_lens(self._info, message):
                self._camera_problem = None
                return
            frame = checked_name(message.header.frame_id, 'camera_info')
            camera = camera_model_from_info(message, self._place.rotation, self._place.position)
            self._watch = self._make_watch(camera)
        except QuadError as error:
            self._camera_problem = error
            raise
        self._info = message
        self._camera_problem = None
        if self._static_transforms is not None and frame:
            place = camera_transform(camera, self.parameters.map_frame, frame, message.header.stamp)
            self._static_transforms.publish(TFMessage(transforms=[place]))
        self.update_status()

    def _make_watch(self, camera: CameraModel) -> SceneTracker:
        p = self.parameters
        robot, goal = self._robot_marker, self._goal_marker
        perceiver = Perceiver.of_robot(
            camera,
            self._robot,
            default_ranges(color_of(p.obstacle_color), robot, goal),
            robot,
            goal,
            resolution=p.resolution,
            bounds=bounds_of(p.map_bounds),
        )
        return SceneTracker(
            perceiver,
            TrackerOptions(p.confirmations, p.goal_distance, p.goal_angle, p.largest_age),
            FusionOptions(p.slip, p.turning_slip),
        )

    def _on_picture(self, message: Image) -> None:
        if self._watch is None:
            return
        try:
            time = seconds_from_time(message.header.stamp)
            checked_name(message.header.frame_id, 'image')
            rgb = rgb_from_image(message)
            self._picture_order.check(time)
            sighting = self._watch.add_picture(time, rgb)
        except QuadError as error:
            self._picture_problem = error
            raise
        self._picture_problem = None
        self._seen_at = time
        self._robot_problem = sighting.problem
        self._goal_problem = sighting.goal_problem
        self._publish(sighting, message)
        if self._pictures.get_subscription_count() > 0:
            picture = annotated(rgb, self._watch.perceiver, sighting.perception)
            self._pictures.publish(
                image_message(picture, message.header.frame_id, message.header.stamp)
            )
        self.update_status()

    def _publish(self, sighting: Sighting, message: Image) -> None:
        frame, stamp = self.parameters.map_frame, message.header.stamp
        if sighting.map is not None:
            self._maps.publish(grid_message(sighting.map, frame, stamp))
        if sighting.goal is not None:
            self._goal = PoseStamped(pose=pose_message(sighting.goal))
            self._goal.header.frame_id, self._goal.header.stamp = frame, stamp
        if self._goal is not None and self._goals.get_subscription_count() > 0:
            # Once, and not before somebody hears it.
            self._goals.publish(self._goal)
            self._goal = None
        robot = sighting.perception.robot
        if robot is not None:
            self._poses.publish(seen_pose_message(robot, frame, stamp))

    def _on_odometry(self, message: Odometry) -> None:
        p = self.parameters
        try:
            pose = legs_pose(message, (p.map_frame,), p.odometry_topic)
            time = seconds_from_time(message.header.stamp)
            self._odometry_order.check(time)
        except QuadError as error:
            self._odometry_problem = error
            raise
        self._odometry_problem = None
        self._legs_at = time
        if self._watch is None:
            return
        self._watch.add_odometry(self._legs_at, pose)
        if self._transforms is not None:
            transforms = robot_transforms(
                message, self._watch.correction, p.map_frame, p.footprint_frame
            )
            self._transforms.publish(TFMessage(transforms=transforms))
        if self._watch.is_lost:
            return
        self._odometry.publish(fused_odometry(message, self._watch.fusion, p.map_frame))

    def _make_transforms(self) -> tuple[Any, Any]:
        """Return what publishes ``tf_static`` and ``tf``; nothing where they are not wanted."""
        if not self.parameters.publish_tf:
            return None, None
        if TFMessage is None:
            self.get_logger().info('tf2_msgs is not installed: no transforms are published')
            return None, None
        static = self.create_publisher(TFMessage, 'tf_static', _LATCHED)
        return static, self.create_publisher(TFMessage, 'tf', 100)


def color_of(numbers: list[float]) -> Color:
    """Read red, green and blue; whatever is wrong with them is said by who takes them."""
    return tuple(round(number) for number in numbers)  # type: ignore[return-value]


def bounds_of(numbers: list[float]) -> tuple[float, float, float, float] | None:
    """Read the corners of the map; None if there are none."""
    return tuple(numbers) if numbers else None  # type: ignore[return-value]


def main(args: list[str] | None = None) -> int:
    """Run the ceiling camera node."""
    return run_node(CeilingCameraNode, args)
