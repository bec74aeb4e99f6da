"""
The node that turns a plan into joint trajectories, one gait cycle at a time.
"""

from __future__ import annotations

import time
from typing import Any

from geometry_msgs.msg import PolygonStamped
from nav_msgs.msg import Odometry, Path
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from quad_common.errors import WrongFrame
from quad_common.robot import load_robot
from quad_common.ros_conversions import (
    plan_from_message,
    pose_from_message,
    seconds_from_time,
    tilt_from_odometry,
)
from quad_common.ros_node import ERROR, OK, STALE, WARN, QuadNode, run_node
from quad_gait.gait import load_gait
from quad_gait.parameters import GaitParameters
from quad_gait.ros_conversions import (
    foothold_markers,
    joints_from_message,
    polygon_message,
    trajectory_message,
)
from quad_gait.walk_controller import Activity, ControllerOptions, Measurement, WalkController

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_LEVELS = {
    Activity.WAITING: WARN,
    Activity.STOPPED: ERROR,
    Activity.BLOCKED: ERROR,
    Activity.FALLEN: ERROR,
}


class GaitNode(QuadNode[GaitParameters]):
    """
    Walks along the plan; its time is that of the odometry's stamps.

    So it keeps step with whatever moves the robot, in simulated time at any speed or in
    real time, and stands still when odometry does.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('gait_node', GaitParameters, **kwargs)
        p = self.parameters
        self._robot = load_robot(p.robot)
        self._controller = WalkController(
            self._robot,
            load_gait(p.gait),
            load_gait(p.turning_gait),
            ControllerOptions(
                settle_time=p.settle_time,
                lead_time=p.lead_time,
                sample_period=p.sample_period,
                least_margin=p.least_margin,
                position_tolerance=p.position_tolerance,
                heading_tolerance=p.heading_tolerance,
                path_tolerance=p.path_tolerance,
            ),
        )
        self._joints: tuple[Any, Any] = (None, None)
        self._heard_odometry_at: float | None = None
        self._distance_left = 0.0
        self._frame = 'odom'

        self._trajectories = self.create_publisher(JointTrajectory, 'joint_trajectory', 10)
        self._margins = self.create_publisher(Float64, 'stability_margin', 10)
        self._polygons = self.create_publisher(PolygonStamped, 'support_polygon', 10)
        self._footholds = self.create_publisher(MarkerArray, 'footholds', 10)
        sensor = qos_profile_sensor_data
        plan_qos = _LATCHED if p.transient_local_plan else QoSProfile(depth=1)
        self.create_subscription(Path, 'plan', self.guarded(self._on_plan), plan_qos)
        self.create_subscription(
            JointState, 'joint_states', self.guarded(self._on_joint_states), sensor
        )
        self.create_subscription(Odometry, p.odom_topic, self.guarded(self._on_odometry), sensor)
        self.create_service(Trigger, 'stop', self._on_stop)
        self.update_status()

    def update_status(self) -> None:
        """Say what the robot does, or why it does not move."""
        clock_problem = self.clock_problem()
        heard = self._heard_odometry_at
        if clock_problem is not None:
            self.report(STALE, clock_problem)
        elif heard is None or time.monotonic() - heard > self.parameters.odom_timeout:
            self.report(WARN, f"no odometry: waiting for it on '{self.parameters.odom_topic}'")
        else:
            activity = self._controller.activity
            cycle = self._controller.cycle
            self.report(
                _LEVELS.get(activity, OK),
                f'{activity.value}: {self._controller.reason}',
                activity=activity.value,
                distance_left=f'{self._distance_left:.3f}',
                least_margin='' if cycle is None else f'{cycle.least_margin:.4f}',
            )

    def _on_plan(self, message: Path) -> None:
        plan = plan_from_message(message)
        map_frame = self.parameters.map_frame
        if plan is not None and message.header.frame_id not in (map_frame, self._frame):
            raise WrongFrame('plan', message.header.frame_id, map_frame)
        self._controller.set_plan(plan)

    def _on_joint_states(self, message: JointState) -> None:
        self._joints = joints_from_message(message, self._robot)

    def _on_odometry(self, message: Odometry) -> None:
        self._heard_odometry_at = time.monotonic()
        self._frame = message.header.frame_id
        stamp = message.header.stamp
        now = seconds_from_time(stamp)
        pose = pose_from_message(message.pose.pose, 'odometry')
        controller = self._controller
        said = controller.reason
        trajectory = controller.update(
            Measurement(now, pose, tilt_from_odometry(message), *self._joints)
        )
        if trajectory is not None:
            self._trajectories.publish(trajectory_message(trajectory))
            footholds = controller.footholds()
            if len(footholds):
                self._footholds.publish(foothold_markers(footholds, self._frame, stamp))
        self._margins.publish(Float64(data=controller.margin_at(now)))
        if self._polygons.get_subscription_count() > 0:
            polygon = controller.support_polygon_at(now, pose)
            self._polygons.publish(polygon_message(polygon, self._frame, stamp))
        if controller.reason != said:
            self._distance_left = controller.distance_left(pose)
            self.update_status()

    def _on_stop(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._controller.stop()
        response.success = True
        response.message = 'the robot stops at the end of its gait cycle, on four feet'
        return response


def main(args: list[str] | None = None) -> int:
    """Run the gait node."""
    return run_node(GaitNode, args)


if __name__ == '__main__':
    raise SystemExit(main())
