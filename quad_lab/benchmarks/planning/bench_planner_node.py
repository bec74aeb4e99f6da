"""
Part of ``quadwalk bench planner``: a large map through planner_node, from message to message.
"""

from __future__ import annotations

import array
import time
from collections.abc import Callable
from pathlib import Path as FilePath

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from numpy.typing import NDArray
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data

from quad_common.maps.occupancy_grid import OccupancyGrid as Grid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import pose_message
from quad_common.ros.run_node import make_executor
from quad_lab.tools.criterion import Criterion, at_most
from quad_lab.topic_walk.node_processes import NodeProcess, NodeProcesses, isolated_domain
from quad_planner.methods.shortest_planner import ShortestPlanner
from quad_planner.parameters import PlannerParameters

Mask = NDArray[np.bool_]

_RESOLUTION = 0.05
"""[m]"""

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_PATIENCE = 60.0
"""For the node to start, and to answer [s]."""

_TIMES = 4


def node_bars(occupied: Mask) -> list[Criterion]:
    """
    Time a map's processing by the node: message in, inflation, plan, message out.

    Parameters
    ----------
    occupied : ndarray of bool, shape (n, n)
        The map.

    Returns
    -------
    list of Criterion
        The longest time of all maps, the first included, and the node's peak memory.
    """
    cells = _largest_area(occupied)
    start, goal = (
        Pose2D((x + 0.5) * _RESOLUTION, (y + 0.5) * _RESOLUTION, 0.0)
        for y, x in (cells[0], cells[-1])
    )
    with isolated_domain(), NodeProcesses() as nodes:
        node = nodes.start('planner_node', method='shortest', use_sim_time=False, odom_timeout=1e6)
        client = _Client(start)
        try:
            times = client.times(occupied, goal, nodes.check)
        finally:
            client.close()
        memory = _peak_memory(node)
    size = len(occupied)
    return [
        at_most(f'map of {size} through the node, at most', max(times), 's', 1.0),
        at_most(f'map of {size} through the node, peak memory', memory, 'MiB', 1024.0),
    ]


def _largest_area(occupied: Mask) -> NDArray[np.int64]:
    """List the cells between which the robot may walk, rows and columns, shape (n, 2)."""
    parameters = PlannerParameters()
    clearance = load_robot(parameters.robot).standing_radius + parameters.safety_distance
    cells = np.where(occupied, 100, 0).astype(np.int8)
    grid = Grid(cells, _RESOLUTION, Pose2D(0.0, 0.0, 0.0))
    areas = ShortestPlanner(clearance_radius=clearance).inflated_map(grid).areas
    return np.argwhere(areas == 1 + int(np.argmax(np.bincount(areas.ravel())[1:])))


def _peak_memory(node: NodeProcess) -> float:
    """Read the largest memory that a process has had [MiB]."""
    for line in FilePath(f'/proc/{node.pid}/status').read_text().splitlines():
        if line.startswith('VmHWM:'):
            return float(line.split()[1]) / 1024.0
    return float('nan')


class _Client:
    """Publishes maps, and receives plans."""

    def __init__(self, start: Pose2D) -> None:
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node('quadwalk_bench', context=self._context)
        self._executor = make_executor(self._context)
        self._executor.add_node(self._node)
        self._maps = self._node.create_publisher(OccupancyGrid, 'map', _LATCHED)
        self._goals = self._node.create_publisher(PoseStamped, 'goal_pose', 10)
        self._odometry = self._node.create_publisher(Odometry, 'odom', qos_profile_sensor_data)
        self._node.create_subscription(Path, 'plan', self._on_plan, _LATCHED)
        self._received = 0
        self._start = start

    def close(self) -> None:
        self._node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    def times(self, occupied: Mask, goal: Pose2D, check: Callable[[], None]) -> list[float]:
        """Return how long each of several maps takes, to the plan on it [s]."""
        self._wait(lambda: self._maps.get_subscription_count() > 0, check)
        # While the compiled code is loaded, a node that starts beside others receives little.
        self._spin(3.0)
        message = Odometry()
        message.header.frame_id = 'odom'
        message.pose.pose = pose_message(self._start)
        self._odometry.publish(message)
        self._spin(0.5)
        wanted = PoseStamped(pose=pose_message(goal))
        wanted.header.frame_id = 'map'
        self._goals.publish(wanted)
        self._spin(0.5)
        times = []
        for y, x in np.argwhere(occupied)[:_TIMES]:
            # Each differs from the one before, or it would be known.
            changed = occupied.copy()
            changed[y, x] = False
            grid = _message(changed)
            received = self._received
            began = time.perf_counter()
            self._maps.publish(grid)
            self._wait(lambda: self._received > received, check)  # noqa: B023
            times.append(time.perf_counter() - began)
        return times

    def _on_plan(self, message: Path) -> None:
        if message.poses:
            self._received += 1

    def _wait(self, condition: Callable[[], bool], check: Callable[[], None]) -> None:
        deadline = time.monotonic() + _PATIENCE
        while not condition():
            self._executor.spin_once(timeout_sec=0.01)
            check()
            if time.monotonic() > deadline:
                raise TimeoutError('planner_node did not answer')

    def _spin(self, duration: float) -> None:
        deadline = time.monotonic() + duration
        while time.monotonic() < deadline:
            self._executor.spin_once(timeout_sec=0.05)


def _message(occupied: Mask) -> OccupancyGrid:
    message = OccupancyGrid()
    message.header.frame_id = 'map'
    message.info.resolution = _RESOLUTION
    message.info.height, message.info.width = occupied.shape
    message.info.origin.orientation.w = 1.0
    cells = np.where(occupied, 100, 0).astype(np.int8)
    message.data = array.array('b', cells.tobytes())
    return message
