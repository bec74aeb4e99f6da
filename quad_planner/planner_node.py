"""
The node that turns an occupancy grid and a goal into a plan of turning points.
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_planner.__main__ import main as start

    raise SystemExit(start())

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetPlan
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from quad_common.errors import ParameterError, PlannerError, QuadError, WrongFrame
from quad_common.occupancy_grid import OccupancyGrid as Grid
from quad_common.pace import Pace, load_pace
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline
from quad_common.robot import load_robot
from quad_common.ros_conversions import (
    checked_name,
    height_map_from_message,
    pose_from_message,
    seconds_from_time,
)
from quad_common.ros_node import OK, STALE, WARN, QuadNode
from quad_common.run_node import run_node
from quad_planner.cell_costs import ClearanceCost, CostLayer, UnknownCost
from quad_planner.inflation import combined_obstacles
from quad_planner.latest_request import LatestRequest
from quad_planner.parameters import PlannerParameters
from quad_planner.planner import make_planner
from quad_planner.ros_conversions import grid_from_message, path_message, plan_markers
from quad_planner.traversability import Ground, GroundLimits

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_CHECK_PERIOD = 0.2
"""How often it is checked whether the robot has left its path [s]."""

_LONG = 3.0
"""Compiled code that is there is ready sooner [s]."""


class PlannerNode(QuadNode[PlannerParameters]):
    """Plans when a goal comes, when a map changes, and when the robot leaves its path."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('planner_node', PlannerParameters, **kwargs)
        p = self.parameters
        robot = load_robot(p.robot)
        self._pace = _pace(p)
        # Searches run beside the executor: a newer goal or map must be heard meanwhile.
        self._requests: LatestRequest[Any] = LatestRequest(self.call_soon)
        self._planner = make_planner(
            p.method,
            pace=self._pace,
            mesh_size=robot.mesh_size,
            any_angle=p.any_angle,
            fewest_turns=p.fewest_turns,
            potential=p.potential,
            influence=p.influence,
            path_deviation=p.path_deviation,
            clearance_radius=robot.footprint_radius + p.safety_distance,
            start_tolerance=p.safety_distance,
            occupied_threshold=p.occupied_threshold,
            unknown_is_free=p.unknown_is_free,
            time_limit=p.planning_timeout,
            clock=time.monotonic,
            costs=_costs(p),
            is_superseded=self._requests.is_superseded,
        )
        self._limits = GroundLimits.of(robot, p.step_height, p.largest_slope)
        self._grid: Grid | None = None
        self._ground: Ground | None = None
        self._waiting_heights: PointCloud2 | None = None
        self._frames: list[str] = []
        self._map_frame = 'map'
        self._outlines: tuple[Any, ...] = ()
        self._pose: Pose2D | None = None
        self._checked_at = 0.0
        self._waiting_goal: PoseStamped | None = None
        self._goal: Pose2D | None = None
        self._pending_goal: Pose2D | None = None
        self._plan: Plan | None = None
        self._planned_from: Pose2D | None = None
        self._is_plan_void = False
        self._problem: QuadError | None = None

        self._plan_publisher = self.create_publisher(Path, 'plan', _LATCHED)
        self._marker_publisher = self.create_publisher(MarkerArray, 'plan_markers', _LATCHED)
        self.create_subscription(OccupancyGrid, 'map', self.guarded(self._on_map), _LATCHED)
        self.create_subscription(
            PointCloud2, 'height_map', self.guarded(self._on_height_map), _LATCHED
        )
        self.create_subscription(PoseStamped, 'goal_pose', self.guarded(self._on_goal), 10)
        self.create_subscription(
            Odometry, p.odom_topic, self.guarded(self._on_odometry), qos_profile_sensor_data
        )
        self.create_service(GetPlan, 'get_plan', self._on_get_plan)
        # Once the executor has the node: what is answered before would reach nobody.
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._beginning = self.create_timer(0.0, self._on_beginning, clock=clock)
        self.update_status()

    def update_status(self) -> None:
        """Say what the planner does, or what it waits for."""
        clock_problem = self.clock_problem()
        if clock_problem is not None:
            self.report(STALE, clock_problem)
        elif self._planner.prepared is None and not isinstance(self._problem, QuadError):
            self.report(WARN, "no map: waiting for one on 'map'")
        elif self._requests.is_busy and self._pending_goal is None:
            self.report(OK, 'getting the searches ready: once after an installation they compile')
        elif self._pending_goal is not None:
            goal = self._pending_goal
            self.report(OK, f'searching a way to ({goal.x:.2f}, {goal.y:.2f}) m')
        elif self._problem is not None:
            self.report_error(self._problem)
        elif self._pose is None:
            self.report(WARN, f"no odometry: waiting for it on '{self.parameters.odom_topic}'")
        elif self._plan is None:
            self.report(OK, "ready: waiting for a goal on 'goal_pose'")
        else:
            self.report(OK, self._described(self._plan), error_code=0)

    def _on_beginning(self) -> None:
        self._beginning.cancel()
        # A goal that came even before is not given up for it.
        if not self._requests.is_busy:
            self._requests.submit(self._warm_up, self._on_warm)

    def _warm_up(self) -> float:
        began = time.monotonic()
        self._planner.warm_up()
        return time.monotonic() - began

    def _on_warm(self, result: Callable[[], float]) -> None:
        took = result()
        if took > _LONG:
            self.get_logger().info(f'the searches were compiled in {took:.0f} s; they are kept')
        self.update_status()

    def _described(self, plan: Plan) -> str:
        text = f'plan of {len(plan.poses)} turning points, {plan.length:.2f} m'
        if self._planned_from is None or self._pace is None:
            return text
        time_ = self._pace.walking_time(self._planned_from, plan)
        return f'{text}, {time_:.0f} s to walk ({self.parameters.gait})'

    def _on_map(self, message: OccupancyGrid) -> None:
        grid = grid_from_message(message, self.parameters.largest_map)
        frame = message.header.frame_id or 'map'
        is_moved = self._ground is not None and frame != self._map_frame
        self._take_maps(grid, frame, None if is_moved else self._ground)
        if is_moved:
            self.get_logger().warning(
                f"the map is in frame '{frame}' now: the height map is left out until one is"
            )
        heights, self._waiting_heights = self._waiting_heights, None
        if heights is not None:
            self._on_height_map(heights)

    def _on_height_map(self, message: PointCloud2) -> None:
        if self._grid is None:
            # Only the map tells which frame it has to be in.
            self._waiting_heights = message
            return
        heights = height_map_from_message(message, (self._map_frame,))
        if self._ground is None or not self._ground.is_like(heights):
            self._take_maps(self._grid, self._map_frame, Ground(heights, self._limits))

    def _take_maps(self, grid: Grid, frame: str, ground: Ground | None) -> None:
        """Plan on a map and a height map from now on; an error leaves those before in force."""
        before, combined = self._planner.prepared, grid
        if ground is not None:
            p = self.parameters
            steps_over_low = p.low_obstacles == 'step_over'
            combined = ground.added_to(grid, p.occupied_threshold, steps_over_low)
        self._planner.set_map(combined)
        self._grid, self._ground = grid, ground
        prepared: Any = self._planner.prepared
        if prepared is before and frame == self._map_frame:
            # The same map again: what was planned on it stands.
            return
        self._map_frame = frame
        self._outlines = combined_obstacles(prepared.grid, prepared.forbidden).outlines
        self._problem = None
        self._publish_markers()
        goal = self._pending_goal or self._goal
        if self._waiting_goal is None and goal is not None and self._pose is not None:
            self._search(goal, is_plan_void=True)
        self._try_waiting_goal()
        self.update_status()

    def _on_goal(self, message: PoseStamped) -> None:
        try:
            pose_from_message(message.pose, 'goal')
        except PlannerError as error:
            self._problem = error
            raise
        self._waiting_goal = message
        self._try_waiting_goal()
        self.update_status()

    def _on_odometry(self, message: Odometry) -> None:
        first = self._pose is None
        now = seconds_from_time(message.header.stamp)
        frame = checked_name(message.header.frame_id, 'odometry')
        self._pose = pose_from_message(message.pose.pose, 'odometry')
        if first:
            self._frames = [frame]
            self._try_waiting_goal()
            self.update_status()
        if self._plan is None or self._goal is None or self._pending_goal is not None:
            return
        if abs(now - self._checked_at) < _CHECK_PERIOD:
            return
        self._checked_at = now
        distance = distance_to_polyline((self._pose.x, self._pose.y), self._plan.corners)
        if distance > self.parameters.replan_distance:
            self.get_logger().info(f'the robot is {distance:.2f} m from its path: planning anew')
            self._search(self._goal)

    def _try_waiting_goal(self) -> None:
        """Plan to the goal that came last, as soon as map and pose are known."""
        message = self._waiting_goal
        if message is None or self._planner.prepared is None or self._pose is None:
            return
        self._waiting_goal = None
        try:
            goal = self._pose_on_map(message, 'goal')
        except PlannerError as error:
            self._problem = error
            return
        self._search(goal)

    def _pose_on_map(self, message: PoseStamped, what: str) -> Pose2D:
        """Read a pose that is given in the map's frame, or in one that coincides with it."""
        if message.header.frame_id not in (self._map_frame, *self._frames):
            raise WrongFrame(what, message.header.frame_id, self._map_frame)
        return pose_from_message(message.pose, what)

    def _search(self, goal: Pose2D, is_plan_void: bool = False) -> None:
        """
        Begin to search a plan; searches before it are given up.

        If it fails the last goal and plan stay, unless the plan led through a map that is
        no longer true: then it is taken back.
        """
        assert self._pose is not None
        start = self._pose
        self._pending_goal = goal
        self._is_plan_void = self._is_plan_void or is_plan_void
        self._requests.submit(
            lambda: self._planner.plan(start, goal), partial(self._on_result, start, goal)
        )

    def _on_result(self, start: Pose2D, goal: Pose2D, result: Callable[[], Plan]) -> None:
        self._pending_goal = None
        try:
            plan = result()
        except PlannerError as error:
            self._problem = error
            if self._is_plan_void:
                self._publish(None)
        else:
            self._goal, self._planned_from = goal, start
            self._problem = None
            if plan.remark:
                self.get_logger().info(plan.remark)
            self._publish(plan)
        self._is_plan_void = False
        self.update_status()

    def destroy_node(self) -> None:
        """Give up what is being searched, and end."""
        self._requests.close()
        super().destroy_node()

    def _publish(self, plan: Plan | None) -> None:
        self._plan = plan
        stamp = self.get_clock().now().to_msg()
        self._plan_publisher.publish(path_message(plan, self._map_frame, stamp))
        self._publish_markers()

    def _publish_markers(self) -> None:
        stamp = self.get_clock().now().to_msg()
        self._marker_publisher.publish(
            plan_markers(self._plan, self._outlines, self._map_frame, stamp)
        )

    def _on_get_plan(
        self, request: GetPlan.Request, response: GetPlan.Response
    ) -> GetPlan.Response:
        """Answer with a plan, or with an empty path and the reason on diagnostics."""
        stamp = self.get_clock().now().to_msg()
        plan = None
        try:
            for stamped in (request.start, request.goal):
                # Unlike a topic, a request is meant for this planner: its map goes without saying.
                stamped.header.frame_id = stamped.header.frame_id or self._map_frame
            start = self._pose_on_map(request.start, 'start')
            goal = self._pose_on_map(request.goal, 'goal')
            plan = self._planner.plan(start, goal)
        except QuadError as error:
            self.report_error(error)
        response.plan = path_message(plan, self._map_frame, stamp)
        return response


def _costs(parameters: PlannerParameters) -> tuple[CostLayer, ...]:
    layers: list[CostLayer] = []
    if parameters.unknown_cost > 1.0:
        layers.append(UnknownCost(parameters.unknown_cost))
    if parameters.clearance_cost > 1.0:
        layers.append(ClearanceCost(parameters.clearance_cost, parameters.clearance_cost_distance))
    return tuple(layers)


def _pace(parameters: PlannerParameters) -> Pace | None:
    """Load the gait's pace, which only `quickest` cannot do without."""
    try:
        return load_pace(parameters.robot, parameters.gait)
    except ParameterError:
        if parameters.method == 'quickest':
            raise
        return None


def main(args: list[str] | None = None) -> int:
    """Run the planner node."""
    return run_node(PlannerNode, args)
