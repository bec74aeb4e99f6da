"""
The node that turns a plan, or steering, into joint trajectories, one gait cycle at a time.
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_gait.__main__ import main as start

    raise SystemExit(start())

import math
import time
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PolygonStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry, Path
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import Imu, JointState, PointCloud2
from std_msgs.msg import Bool, Float64, Header
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from quad_common.errors import QuadError
from quad_common.frames.map_frame import MapFrame
from quad_common.plan import Plan
from quad_common.robot.robot_file import load_robot
from quad_common.ros.height_map_conversions import height_map_from_message
from quad_common.ros.map_frame_listener import MapFrameListener
from quad_common.ros.pose_conversions import (
    most_plan_bytes,
    orientation_from_odometry,
    plan_from_message,
    pose_from_message,
    seconds_from_time,
)
from quad_common.ros.ros_node import ERROR, OK, STALE, WARN, QuadNode
from quad_common.ros.run_node import run_node
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import Gait, load_gait, turning_gait_for
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.slip_compensation import compensation_for
from quad_gait.parameters import GaitParameters
from quad_gait.ros_conversions import (
    foothold_markers,
    imu_from_message,
    joints_from_message,
    leg_odometry_message,
    polygon_message,
    trajectory_message,
    twist_from_message,
)
from quad_gait.state.leg_odometry import LegOdometry
from quad_gait.state.measurement import Measurement
from quad_gait.state.sensor_inputs import InputOptions, SensorInputs
from quad_gait.supervisor import Supervisor
from quad_gait.uneven.uneven_options import UnevenOptions
from quad_gait.uneven.uneven_stride import check_suits_uneven_ground

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_LEVELS = {
    Activity.WAITING: WARN,
    Activity.STOPPED: ERROR,
    Activity.BLOCKED: ERROR,
    Activity.FALLEN: ERROR,
    Activity.LAME: ERROR,
    Activity.NOT_EXECUTED: ERROR,
    Activity.EMERGENCY_STOP: ERROR,
}


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
        self._controller = Supervisor(
            self._robot,
            *self._gaits(p),
            SupervisorOptions(
                settle_time=p.settle_time,
                lead_time=p.lead_time,
                sample_period=p.sample_period,
                least_margin=p.least_margin,
                twist_timeout=p.cmd_vel_timeout,
                tracking_gain=p.tracking_gain if p.foot_tracking == 'backstepping' else None,
                follower=_follower_options(p),
                uneven=_uneven_options(p) if p.ground == 'uneven' else None,
            ),
            compensation_for(p.robot, p.calibration),
        )
        self._controller.prepare()
        self._is_uneven = p.ground == 'uneven'
        self._odometry = LegOdometry(self._robot)
        self._is_placed = p.odom_topic == 'odom/legs' or p.leg_odometry_start == 'origin'
        self._inputs = SensorInputs(
            self._robot,
            InputOptions(
                p.joint_timeout,
                p.imu_timeout,
                odometry_has_attitude=p.odom_topic != 'odom/legs',
                needs_attitude=self._is_uneven,
            ),
        )
        self._odometry_received_at: float | None = None
        self._is_time_still = False
        self._planner_alive_at: float | None = None
        self._published_footholds: Any = None
        self._distance_left = 0.0
        self._frame = 'odom'
        self._map = MapFrameListener(
            self, MapFrame(p.map_frame, p.correction_time_constant), p.correction_timeout
        )
        self._plan_heard = Path()
        self._followed: Plan | None = None
        self._wire_topics()
        self.update_status()

    def _wire_topics(self) -> None:
        p = self.parameters
        self._trajectories = self.create_publisher(JointTrajectory, 'joint_trajectory', 10)
        self._margins = self.create_publisher(Float64, 'stability_margin', 10)
        self._measured_margins = self.create_publisher(Float64, 'stability_margin/measured', 10)
        self._polygons = self.create_publisher(PolygonStamped, 'support_polygon', 10)
        self._footholds = self.create_publisher(MarkerArray, 'footholds', 10)
        sensor = qos_profile_sensor_data
        self._leg_odometry = self.create_publisher(Odometry, 'odom/legs', sensor)
        self._followed_plans = self.create_publisher(Path, 'plan/followed', _LATCHED)
        plan_qos = _LATCHED if p.transient_local_plan else QoSProfile(depth=1)
        most_bytes = most_plan_bytes(p.longest_plan)
        self.create_subscription(Path, 'plan', self._on_plan, plan_qos, most_bytes=most_bytes)
        twist = TwistStamped if p.stamped_cmd_vel else Twist
        self.create_subscription(twist, 'cmd_vel', self._on_cmd_vel, 10)
        self.create_subscription(JointState, 'joint_states', self._on_joint_states, sensor)
        self.create_subscription(Imu, 'imu', self._on_imu, sensor)
        self.create_subscription(Odometry, p.odom_topic, self._on_odometry, sensor)
        if self._is_uneven:
            self.create_subscription(PointCloud2, 'height_map', self._on_height_map, _LATCHED)
        self.create_subscription(Header, 'plan/heartbeat', self._on_heartbeat, 10)
        self._emergency_stop = self.create_publisher(Bool, 'emergency_stop/active', _LATCHED)
        self.create_service(SetBool, 'emergency_stop', self._on_emergency_stop)
        self.create_service(Trigger, 'stand', partial(self._on_request, self._controller.stand))
        self.create_service(Trigger, 'sit', partial(self._on_request, self._controller.sit))
        self.create_service(Trigger, 'stop', partial(self._on_request, self._controller.stop))

    def _gaits(self, p: GaitParameters) -> tuple[Gait, Gait]:
        """Load the gaits for walking and for turning."""
        gait = load_gait(p.gait, self._robot)
        if p.ground == 'uneven':
            check_suits_uneven_ground(gait)
        return gait, turning_gait_for(gait, self._robot, p.turning_gait)

    def take_parameters(self, parameters: GaitParameters) -> None:
        """Change gaits at the end of the cycle."""
        self._controller.set_gaits(*self._gaits(parameters), _follower_options(parameters))

    def update_status(self) -> None:
        """Say what the robot does, or why it does not move."""
        clock_problem = self.clock_problem()
        received = self._odometry_received_at
        if clock_problem is not None:
            self.report(STALE, clock_problem)
        elif received is None or time.monotonic() - received > self.parameters.odom_timeout:
            if self._is_time_still:
                self.report(WARN, 'stale odometry: it comes, and its time stands still')
                return
            self.report(WARN, f"no odometry: waiting for it on '{self.parameters.odom_topic}'")
        else:
            controller = self._controller
            activity, cycle = controller.activity, controller.cycle
            level = _LEVELS.get(activity, OK)
            said = f'{controller.reason}; {controller.limit}'
            silent_imu = self._inputs.imu_problem
            missing = silent_imu if silent_imu not in said else ''
            notes = [note for note in (controller.limit, missing, self._map.problem()) if note]
            self.report(
                max(level, WARN) if notes else level,
                '; '.join([f'{activity.value}: {controller.reason}', *notes]),
                activity=activity.value,
                gait=controller.gait.name,
                distance_left=f'{self._distance_left:.3f}',
                least_margin='' if cycle is None else f'{cycle.least_margin:.4f}',
                limit=controller.limit,
            )

    def _on_plan(self, message: Path) -> None:
        plan = plan_from_message(message, self.parameters.longest_plan)
        if plan is not None:
            plan = self._map.frame.plan_on_map(message.header.frame_id, plan)
        if self._planner_problem():
            # Whoever made this plan has no heartbeat: nobody is missed while it is followed.
            self._planner_alive_at = None
        self._controller.set_plan(plan)
        if plan is not None and self._controller.wanted_plan is plan:
            self._plan_heard = message
        self._say_what_is_followed()

    def _say_what_is_followed(self) -> None:
        """Publish the plan that is followed when it is another one; an empty path for none."""
        followed = self._controller.wanted_plan
        if followed is not self._followed:
            self._followed = followed
            heard = self._plan_heard
            self._followed_plans.publish(heard if followed else Path(header=heard.header))

    def _on_heartbeat(self, _: Header) -> None:
        self._planner_alive_at = time.monotonic()

    def _on_cmd_vel(self, message: Twist | TwistStamped) -> None:
        twist = message.twist if isinstance(message, TwistStamped) else message
        self._controller.set_twist(twist_from_message(twist))
        self._say_what_is_followed()

    def _on_height_map(self, message: PointCloud2) -> None:
        frames = self._map.frame.frames_on_map
        self._controller.set_height_map(height_map_from_message(message, frames))

    def _on_imu(self, message: Imu) -> None:
        orientation, yaw_rate = imu_from_message(message)
        stamp = seconds_from_time(message.header.stamp)
        self._inputs.take_imu(stamp or None, orientation, yaw_rate)

    def _on_joint_states(self, message: JointState) -> None:
        readings = joints_from_message(message, self._robot)
        stamp = message.header.stamp
        if self._inputs.take_joints(readings) and self._is_placed:
            odometry = self._odometry
            now = seconds_from_time(stamp)
            # Level feet stand, on flat ground; elsewhere those that do not swing.
            standing = self._controller.in_contact_at(now) if self._is_uneven else None
            odometry.update(now, readings.positions, standing, *self._inputs.imu_at(now))
            if self._leg_odometry.get_subscription_count() > 0:
                is_own = self.parameters.leg_odometry_start == 'origin'
                frame = 'odom' if is_own else self._frame
                self._leg_odometry.publish(leg_odometry_message(odometry, frame, stamp))

    def _on_odometry(self, message: Odometry) -> None:
        stamp = message.header.stamp
        pose = pose_from_message(message.pose.pose, 'odometry')
        orientation = orientation_from_odometry(message)
        was_silent = bool(self._inputs.imu_problem)
        now = self._inputs.take_odometry(seconds_from_time(stamp), pose, orientation)
        self._is_time_still = now is None
        if now is None:
            return
        self._odometry_received_at = time.monotonic()
        self._frame = message.header.frame_id
        pose, odometry = self._map.locate(message)
        now = replace(now, pose=pose, odometry=odometry)
        # What is worked out from the pose on the map is in its frame.
        frame = self._frame if self._map.frame.correction is None else self._map.frame.name
        if not self._is_placed:
            # From here on the legs tell; where the robot was put they cannot know.
            self._odometry.reset(odometry)
            self._is_placed = True
        controller = self._controller
        controller.hold_plan(self._planner_problem())
        said = (controller.reason, controller.limit)
        trajectory = controller.update(now)
        if trajectory is not None:
            self._trajectories.publish(trajectory_message(trajectory))
            footholds = controller.footholds()
            # On uneven ground a stride is many trajectories.
            if len(footholds) and not np.array_equal(footholds, self._published_footholds):
                self._published_footholds = footholds
                self._footholds.publish(foothold_markers(footholds, frame, stamp))
        self._publish_stability(now, frame, stamp)
        self._say_what_is_followed()
        is_silent = bool(self._inputs.imu_problem)
        if (controller.reason, controller.limit, is_silent) != (*said, was_silent):
            self._distance_left = controller.distance_left(pose)
            self.update_status()

    def _planner_problem(self) -> str:
        """Say that the planner is gone; empty if it lives, or is not watched."""
        timeout, alive_at = self.parameters.planner_timeout, self._planner_alive_at
        if not timeout or alive_at is None or time.monotonic() - alive_at <= timeout:
            return ''
        return f'no heartbeat of the planner for {timeout:g} s: the plan waits for it'

    def _publish_stability(self, now: Measurement, frame: str, stamp: Any) -> None:
        controller = self._controller
        is_measured = self._is_uneven or self._measured_margins.get_subscription_count() > 0
        measured = controller.measured_margin(now) if is_measured else math.nan
        # Uneven ground is not planned for a cycle ahead: there the real feet count.
        margin = measured if self._is_uneven else controller.margin_at(now.time)
        if math.isfinite(margin):
            self._margins.publish(Float64(data=margin))
        if math.isfinite(measured):
            self._measured_margins.publish(Float64(data=measured))
        if self._polygons.get_subscription_count() > 0:
            if self._is_uneven:
                polygon = controller.measured_support_polygon(now)
            else:
                polygon = controller.support_polygon_at(now.time, now.pose)
            self._polygons.publish(polygon_message(polygon, frame, stamp))

    def _on_request(
        self, request: Any, _: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        """Hand stand, sit or stop to the controller."""
        try:
            response.message, response.success = request(), True
        except QuadError as error:
            response.message, response.success = str(error), False
        self._say_what_is_followed()
        return response

    def _on_emergency_stop(
        self, request: SetBool.Request, response: SetBool.Response
    ) -> SetBool.Response:
        """Freeze the robot at once, or release it."""
        response.success = True
        if request.data:
            hold = self._controller.freeze()
            if hold is not None:
                self._trajectories.publish(trajectory_message(hold))
            response.message = 'all joints hold until the emergency stop is released'
        else:
            response.message = self._controller.release()
        self._emergency_stop.publish(Bool(data=request.data))
        self._say_what_is_followed()
        self.update_status()
        return response


def _follower_options(p: GaitParameters) -> FollowerOptions:
    return FollowerOptions(
        turning=p.turning,
        position_tolerance=p.position_tolerance,
        heading_tolerance=p.heading_tolerance,
        path_tolerance=p.path_tolerance,
        corner_deviation=p.corner_deviation,
        corner_radius=p.corner_radius,
        largest_speed=p.largest_speed or math.inf,
    )


def _uneven_options(p: GaitParameters) -> UnevenOptions:
    return UnevenOptions(sample_period=p.sample_period, reaction_time=p.reaction_time)


def main(args: list[str] | None = None) -> int:
    """Run the gait node."""
    return run_node(GaitNode, args)
