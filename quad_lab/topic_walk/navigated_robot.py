"""
A simulated robot with its nodes, given goals by actions, and the record of where it was.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from rclpy.qos import QoSProfile, ReliabilityPolicy

from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.ros.pose_conversions import pose_from_message, seconds_from_time
from quad_common.ros.run_node import make_executor
from quad_lab.topic_walk.navigation_client import NavigationClient
from quad_lab.topic_walk.node_processes import NodeProcesses, isolated_domain
from quad_lab.topic_walk.walk import START_TIMEOUT, NodesNotReady

_EVERY_POSE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)

_MOVED, _TURNED = 0.004, 0.01
"""A body that is farther than this from where it comes to rest still moves [m, rad]."""


class NavigatedRobot:
    """
    Simulator, planner and gait as processes, and a node that gives goals.

    Parameters
    ----------
    nodes : NodeProcesses
        The processes.
    """

    def __init__(self, nodes: NodeProcesses) -> None:
        self._nodes = nodes
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node('quadwalk_cli', context=self._context)
        self._executor = make_executor(self._context)
        self._executor.add_node(self._node)
        self.client = NavigationClient(self._node, self.spin)
        """Client of the actions."""
        self.track: list[tuple[float, Pose2D]] = []
        """Where the robot was, and when [s]."""
        self.activity = ''
        """What the gait says that it does."""
        self.has_fallen = False
        """Whether the simulator said that the robot has fallen."""
        self.taken_back_at = 0.0
        """When the planner took a plan back last, in simulated time [s]."""
        subscribe = self._node.create_subscription
        subscribe(Odometry, 'odom', self._on_odometry, _EVERY_POSE)
        subscribe(PathMessage, 'plan', self._on_plan, 10)
        subscribe(DiagnosticArray, 'diagnostics', self._on_diagnostics, 100)

    def close(self) -> None:
        """Give back what it has; the processes are ended by who started them."""
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    @property
    def time(self) -> float:
        """Simulated time that was seen last [s]."""
        return self.track[-1][0] if self.track else 0.0

    @property
    def pose(self) -> Pose2D:
        """Where the robot is."""
        return self.track[-1][1]

    def spin(self) -> None:
        """Run callbacks for a moment; NodeDied if a node has ended."""
        self._executor.spin_once(timeout_sec=0.1)
        self._nodes.check()

    def wait_until_ready(self) -> None:
        """Wait until the robot stands and its actions are served; NodesNotReady if not so."""
        try:
            self.client.wait_until(
                lambda: self.activity == 'standing' and bool(self.track), START_TIMEOUT
            )
        except TimeoutError as error:
            raise NodesNotReady(START_TIMEOUT, self.activity) from error

    def listen(self, duration: float, patience: float = 60.0) -> None:
        """Listen for some simulated time [s]; TimeoutError if it takes too long."""
        end = self.time + duration
        self.client.wait_until(lambda: self.time >= end, patience)

    def rested_at(self, since: float) -> float:
        """Return when the robot came to rest where it is now, not before a time [s]."""
        end = self.pose
        for stamp, pose in reversed(self.track):
            turned = abs(wrap_angle(pose.yaw - end.yaw))
            if stamp <= since or pose.distance_to(end) > _MOVED or turned > _TURNED:
                return stamp
        return since

    def _on_odometry(self, message: Odometry) -> None:
        stamp = seconds_from_time(message.header.stamp)
        self.track.append((stamp, pose_from_message(message.pose.pose)))

    def _on_plan(self, message: PathMessage) -> None:
        if not message.poses:
            self.taken_back_at = seconds_from_time(message.header.stamp)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            self.activity = values.get('activity', self.activity)
            self.has_fallen = self.has_fallen or values.get('has_fallen') == 'True'


@contextlib.contextmanager
def navigated_robot(
    robot: str, map_file: Path, start: Pose2D, real_time_factor: float = 0.0
) -> Iterator[NavigatedRobot]:
    """
    Start a robot on a map, and end it with the block.

    Parameters
    ----------
    robot : str
        Name of the robot.
    map_file : Path
        The map.
    start : Pose2D
        Where it stands.
    real_time_factor : float
        Pace of the simulation; 0 for as fast as it goes.

    Yields
    ------
    NavigatedRobot
        The robot, ready for goals.
    """
    with isolated_domain(), NodeProcesses() as nodes:
        nodes.start(
            'sim_node',
            robot=robot,
            map_file=str(map_file.resolve()),
            start_pose=[float(v) for v in (start.x, start.y, start.yaw)],
            real_time_factor=float(real_time_factor),
        )
        nodes.start('planner_node', robot=robot)
        nodes.start('gait_node', robot=robot)
        one = NavigatedRobot(nodes)
        try:
            one.wait_until_ready()
            yield one
        finally:
            one.close()
