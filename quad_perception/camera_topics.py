"""
What ``ceiling_camera_node`` publishes.
"""

from __future__ import annotations

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from quad_common.ros.image_conversions import image_message
from quad_common.ros.pose_conversions import camera_transform, grid_message, pose_message
from quad_common.ros.transform_publisher import TransformPublisher
from quad_common.vision.camera import CameraModel
from quad_perception.parameters import CeilingCameraParameters
from quad_perception.picture.annotated import annotated
from quad_perception.picture.color_segmentation import Picture
from quad_perception.ros_conversions import fused_odometry, robot_transforms, seen_pose_message
from quad_perception.tracking.scene_tracker import SceneTracker, Sighting

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class CameraTopics:
    """
    The publishers of a ceiling camera.

    Parameters
    ----------
    node : Node
        The node.
    parameters : CeilingCameraParameters
        Its parameters.
    """

    def __init__(self, node: Node, parameters: CeilingCameraParameters) -> None:
        self._parameters = parameters
        self._goal: PoseStamped | None = None
        sensor = qos_profile_sensor_data
        self._maps = node.create_publisher(OccupancyGrid, 'map', _LATCHED)
        self._goals = node.create_publisher(PoseStamped, 'goal_pose', 10)
        self._poses = node.create_publisher(
            PoseWithCovarianceStamped, 'ceiling_camera/robot_pose', 10
        )
        self._odometry = node.create_publisher(Odometry, 'odom/camera', sensor)
        self._pictures = node.create_publisher(Image, 'ceiling_camera/image_annotated', sensor)
        self._transforms = TransformPublisher(node, parameters.publish_tf)

    def publish_camera(self, camera: CameraModel, header: Header) -> None:
        """Publish where the camera is, if its frame has a name."""
        if header.frame_id:
            frame = self._parameters.map_frame
            place = camera_transform(camera, frame, header.frame_id, header.stamp)
            self._transforms.publish_static(place)

    def publish_sighting(
        self, sighting: Sighting, tracker: SceneTracker, rgb: Picture, header: Header
    ) -> None:
        """Publish what a picture has changed, and the picture with what is seen in it."""
        frame, stamp = self._parameters.map_frame, header.stamp
        if sighting.map is not None:
            self._maps.publish(grid_message(sighting.map, frame, stamp))
        if sighting.goal is not None:
            self._goal = PoseStamped(pose=pose_message(sighting.goal))
            self._goal.header.frame_id, self._goal.header.stamp = frame, stamp
        if self._goal is not None and self._goals.get_subscription_count() > 0:
            # Once, and not before there is a subscriber.
            self._goals.publish(self._goal)
            self._goal = None
        robot = sighting.perception.robot
        if robot is not None:
            self._poses.publish(seen_pose_message(robot, frame, stamp))
        if self._pictures.get_subscription_count() > 0:
            picture = annotated(rgb, tracker.perceiver, sighting.perception)
            self._pictures.publish(image_message(picture, header.frame_id, stamp))

    def publish_robot(self, legs: Odometry, tracker: SceneTracker) -> None:
        """Publish where the robot is: the legs' odometry, corrected by pictures."""
        p = self._parameters
        if self._transforms.is_active:
            transforms = robot_transforms(legs, tracker.correction, p.map_frame, p.footprint_frame)
            self._transforms.publish(*transforms)
        if not tracker.is_lost:
            self._odometry.publish(fused_odometry(legs, tracker.fusion, p.map_frame))
