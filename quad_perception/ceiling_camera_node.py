"""
The node that sees the room from the ceiling: map, goal and the robot's pose (S1).
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_perception.__main__ import main as start

    raise SystemExit(start())

from typing import Any

from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image

from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.image_conversions import camera_model_from_info, rgb_from_image
from quad_common.ros.pose_conversions import checked_name, seconds_from_time
from quad_common.ros.ros_node import STALE, QuadNode
from quad_common.ros.run_node import run_node
from quad_perception.camera_session import CameraSession
from quad_perception.camera_topics import CameraTopics
from quad_perception.parameters import CeilingCameraParameters
from quad_perception.ros_conversions import is_same_lens, legs_pose

_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Quality of service of pictures: of those that wait, the newest counts."""


class CeilingCameraNode(QuadNode[CeilingCameraParameters]):
    """Publishes the map, the goal, and where the robot is: the fused pose as odometry."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('ceiling_camera_node', CeilingCameraParameters, **kwargs)
        p = self.parameters
        self._session = CameraSession(p, load_robot(p.robot))
        self._topics = CameraTopics(self, p)
        self._info: CameraInfo | None = None
        sensor = qos_profile_sensor_data
        self.create_subscription(CameraInfo, 'ceiling_camera/camera_info', self._on_info, sensor)
        self.create_subscription(Image, 'ceiling_camera/image_raw', self._on_picture, _NEWEST)
        self.create_subscription(Odometry, p.odometry_topic, self._on_odometry, sensor)
        self.update_status()

    def update_status(self) -> None:
        """Report what is seen, or what is missing."""
        clock_problem = self.clock_check.problem()
        if clock_problem is not None:
            self.report(STALE, clock_problem, is_waiting=True)
        else:
            now = self.get_clock().now().nanoseconds * 1e-9
            self.report_status(self._session.status(now))

    def _on_info(self, message: CameraInfo) -> None:
        with self._session.receiving('camera_info'):
            # The last good one is kept: what was seen with it must not be lost for a bad one.
            if self._info is not None and is_same_lens(self._info, message):
                return
            checked_name(message.header.frame_id, 'camera_info')
            place = self._session.place
            camera = camera_model_from_info(message, place.rotation, place.position)
            self._session.take_camera(camera)
        self._info = message
        self._topics.publish_camera(camera, message.header)
        self.update_status()

    def _on_picture(self, message: Image) -> None:
        tracker = self._session.tracker
        if tracker is None:
            return
        with self._session.receiving('picture'):
            time = seconds_from_time(message.header.stamp)
            self.clock_check.take_stamp(message.header.stamp)
            checked_name(message.header.frame_id, 'image')
            rgb = rgb_from_image(message)
            sighting = self._session.take_picture(time, rgb)
        self._topics.publish_sighting(sighting, tracker, rgb, message.header)
        self.update_status()

    def _on_odometry(self, message: Odometry) -> None:
        p = self.parameters
        with self._session.receiving('odometry'):
            pose = legs_pose(message, (p.map_frame,), p.odometry_topic)
            time = seconds_from_time(message.header.stamp)
            tracker = self._session.take_odometry(time, pose)
        if tracker is not None:
            self._topics.publish_robot(message, tracker)


def main(args: list[str] | None = None) -> int:
    """Run the ceiling camera node."""
    return run_node(CeilingCameraNode, args)
