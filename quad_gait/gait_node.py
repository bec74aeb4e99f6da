"""
The node that turns a plan, or steering, into joint trajectories, one gait cycle at a time.
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_gait.__main__ import main as start

    raise SystemExit(start())

import time
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import Imu, JointState, PointCloud2

from quad_common.frames.map_frame import MapFrame
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.height_map_conversions import height_map_from_message
from quad_common.ros.map_frame_listener import MapFrameListener
from quad_common.ros.pose_conversions import (
    checked_name,
    orientation_from_odometry,
    pose_from_message,
    seconds_from_time,
)
from quad_common.ros.ros_node import QuadNode
from quad_common.ros.run_node import run_node
from quad_gait.gait_services import GaitServices
from quad_gait.gait_status import GaitStatus
from quad_gait.gait_topics import GaitTopics
from quad_gait.ground.map_detail import as_feet_need
from quad_gait.parameters import GaitParameters
from quad_gait.plan_topics import PlanTopics
from quad_gait.planner_watch import PlannerWatch
from quad_gait.ros_conversions import (
    imu_from_message,
    imu_motion_from_message,
    joints_from_message,
    twist_from_message,
)
from quad_gait.state.measured_time import MeasuredTime
from quad_gait.state.state_estimator import StateEstimator
from quad_gait.supervisor import Supervisor

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_DOUBT = 'it is not known where in the map the robot is'
"""Reason for a plan to wait while corrections of odometry leap again and again."""


class GaitNode(QuadNode[GaitParameters]):
    """
    Walks along the plan, or as steered; its time is that of the odometry's stamps.

    So it keeps step with whatever moves the robot, in simulated time at any speed or in
    real time, and stands still when odometry does.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('gait_node', GaitParameters, **kwargs)
        p = self.parameters
        self._robot = load_robot(p.robot)
        self._supervisor = supervisor = Supervisor.from_parameters(p, self._robot)
        supervisor.prepare()
        self._estimator = StateEstimator(self._robot, p.estimator_options, supervisor.support_at)
        self._planner = PlannerWatch(p.planner_timeout, time.monotonic)
        self._diagnosis = GaitStatus(supervisor, self._estimator, p, time.monotonic)
        self._odom_frame = 'odom'
        frame = MapFrame(p.map_frame, p.correction_time_constant)
        self._map = MapFrameListener(self, frame, p.correction_timeout)
        self._topics = GaitTopics(self, supervisor, p)
        twist = TwistStamped if p.stamped_cmd_vel else Twist
        self.create_subscription(twist, 'cmd_vel', self._on_cmd_vel, 10)
        sensor = qos_profile_sensor_data
        self.create_subscription(JointState, 'joint_states', self._on_joint_states, sensor)
        self.create_subscription(Imu, 'imu', self._on_imu, sensor)
        self.create_subscription(Odometry, p.odom_topic, self._on_odometry, sensor)
        if p.uses_height_map:
            self.create_subscription(PointCloud2, 'height_map', self._on_height_map, _LATCHED)
        self._time = MeasuredTime()
        GaitServices(self, supervisor, self._topics, self._now)
        plans = PlanTopics(self, supervisor, self._topics, frame, self._planner)
        self._actions = plans.actions
        self.manage(self._rest)
        self.update_status()

    def take_parameters(self, parameters: GaitParameters) -> None:
        """Change gaits, and how plans are followed, at the end of the cycle."""
        gaits = parameters.gaits(self._robot)
        self._supervisor.set_gaits(*gaits, parameters.follower_options)

    def update_status(self) -> None:
        """Report what the robot does, or why it does not move."""
        notes = self._map.problem(), *self._topics.problems(), self.rest_note()
        self.report_status(self._diagnosis.status(self.clock_check.problem(), *notes))

    def _now(self) -> tuple[float | None, NDArray[np.float64] | None]:
        """Return time [s] and joints, (12,) [rad], as they are now; None for what is not known."""
        newest, joints = self._estimator.newest
        now = self._time.now(self._clock_time(), time.monotonic())
        return newest if now is None else now, joints

    def _clock_time(self) -> float:
        return float(self.get_clock().now().nanoseconds) / 1e9

    def _rest(self) -> None:
        """Stand, as a node that is managed does when it is active no longer."""
        self._supervisor.stop()
        self._topics.publish_followed()

    def _on_cmd_vel(self, message: Twist | TwistStamped) -> None:
        self.check_active()
        self._supervisor.set_twist(twist_from_message(message))
        self._topics.publish_followed()

    def _on_height_map(self, message: PointCloud2) -> None:
        frames = self._map.frame.frames_on_map
        heights = height_map_from_message(message, frames)
        self._supervisor.set_height_map(as_feet_need(heights, self._robot))

    def _on_imu(self, message: Imu) -> None:
        stamp = seconds_from_time(message.header.stamp)
        motion = imu_motion_from_message(message)
        self._estimator.take_imu(stamp or None, *imu_from_message(message), motion)

    def _on_joint_states(self, message: JointState) -> None:
        if self._estimator.take_joints(joints_from_message(message, self._robot)):
            is_own = self.parameters.leg_odometry_start == 'origin'
            frame = 'odom' if is_own else self._odom_frame
            odometry = self._estimator.leg_odometry
            self._topics.publish_leg_odometry(odometry, frame, message.header.stamp)
        newest, _ = self._estimator.newest
        if newest is not None:
            self._time.note_joints(newest, time.monotonic())

    def _on_odometry(self, message: Odometry) -> None:
        stamp, frame = message.header.stamp, self._map.frame
        odom_frame = checked_name(message.header.frame_id, 'odometry')
        pose = pose_from_message(message.pose.pose, 'odometry')
        orientation = orientation_from_odometry(message)
        self.clock_check.take_stamp(stamp)
        now = self._clock_time()
        # Without a /clock yet simulated time is 0.
        state = self._estimator.take_odometry(
            seconds_from_time(stamp), pose, orientation, now or None
        )
        self._diagnosis.take_odometry(state is not None)
        if state is None:
            return
        self._time.note_odometry(state.time, now, time.monotonic())
        self._odom_frame = odom_frame
        state = state.placed(*self._map.locate(message))
        doubt = _DOUBT if frame.doubt else ''
        self._supervisor.hold_plan(self._planner.problem or doubt)
        trajectory = self._supervisor.update(state)
        # What is computed from the pose on the map is in its frame.
        name = self._odom_frame if frame.correction is None else frame.name
        self._topics.publish_decision(trajectory, state, name, stamp)
        self._actions.update(state, message)
        if self._diagnosis.has_changed(state.pose):
            self.update_status()


def main(args: list[str] | None = None) -> int:
    """Run the gait node."""
    return run_node(GaitNode, args)
