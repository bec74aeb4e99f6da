"""
One walk of several robots over topics: one simulator, and planner and gait for each in a namespace.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_from_message, pose_message, seconds_from_time
from quad_lab.topic_walk.node_processes import NodeProcesses, isolated_domain
from quad_lab.topic_walk.standstill import STALL_TIMEOUT, Standstill, TimeStandsStill
from quad_lab.topic_walk.viewer_process import PagePlace, start_viewer
from quad_lab.topic_walk.walk import START_TIMEOUT, NodesNotReady
from quad_sim.engines.registry import AUTO

_NEAR = 0.15
"""Distance from the goal within which a robot that says so has arrived [m]."""

_STEP = 0.05
"""Distance between the noted places of a robot [m]."""

_LONGEST = 1800.0
"""Simulated time in which all have to arrive [s]."""


@dataclass(frozen=True)
class FleetRobot:
    """One of the robots."""

    kind: str
    """Name of a robot, or path of a robot data file."""
    start: Pose2D
    goal: Pose2D


@dataclass(frozen=True)
class FleetOptions:
    """What several robots walk."""

    map_file: Path
    robots: Mapping[str, FleetRobot]
    """By their names, which are the namespaces of their topics."""
    gait: str = 'trot'
    turning: str = 'in_place'
    method: str = 'shortest'
    backend: str = AUTO
    seed: int = 0
    real_time_factor: float = 1.0
    """0: as fast as possible."""
    page: PagePlace | None = None
    """Where the viewer's page is; None for no viewer."""


@dataclass
class RobotNotes:
    """What was received of one robot."""

    pose: Pose2D | None = None
    time: float = 0.0
    """Time of its odometry [s]."""
    track: list[Pose2D] = field(default_factory=list)
    """Where it has been."""
    says: dict[str, str] = field(default_factory=dict)
    """What its nodes say, by their names."""
    arrived: float | None = None
    """When it arrived [s]; None before."""
    waits: list[str] = field(default_factory=list)
    """What it waited for, in the order of time."""


@dataclass
class FleetNotes:
    """What was received of all robots."""

    robots: dict[str, RobotNotes]
    contacts: str = ''
    """Contacts of anything but feet with the ground, as sim_node says them."""
    duration: float = 0.0
    """Time from the goals to the end [s], simulated."""
    problem: str = ''
    """Reason why it was not waited for longer; empty for none."""

    @property
    def have_arrived(self) -> bool:
        """Whether all have."""
        return all(notes.arrived is not None for notes in self.robots.values())


def walk_fleet(
    options: FleetOptions,
    on_progress: Callable[[FleetNotes], None] = lambda notes: None,
    on_page: Callable[[str], None] = lambda address: None,
    on_end: Callable[[FleetNotes, Callable[[], None]], None] = lambda notes, go_on: None,
) -> FleetNotes:
    """
    Walk several robots once, each from its start to its goal.

    Parameters
    ----------
    options : FleetOptions
        What to walk.
    on_progress : callable
        Called several times a second.
    on_page : callable
        Called with the address of the viewer's page, once that is there.
    on_end : callable
        Called when all have arrived, with what lets the nodes go on for a moment.

    Returns
    -------
    FleetNotes
        What happened; also if not all arrived.

    Raises
    ------
    NodesNotReady
        If the nodes do not become ready.
    NodeDied
        If one ends on its own.
    """
    with contextlib.ExitStack() as stack:
        stack.enter_context(isolated_domain())
        groups = [stack.enter_context(start_fleet(options))]
        for name in options.robots:
            groups.append(stack.enter_context(NodeProcesses(name)))
            _start_robot(groups[-1], options, options.robots[name].kind)
        if options.page is not None:
            on_page(start_viewer(groups[0], options.page))
        observer = stack.enter_context(contextlib.closing(_Observer(options)))

        def go_on() -> None:
            observer.listen(0.1)
            for nodes in groups:
                nodes.check()
            on_progress(observer.notes)

        _walk(observer, go_on)
        on_end(observer.notes, go_on)
        return observer.notes


def start_fleet(options: FleetOptions) -> NodeProcesses:
    """Start the simulator of all robots; see ``sim_node``'s parameter ``robots``."""
    nodes = NodeProcesses()
    places = [
        f'{name}={robot.kind}@{robot.start.x},{robot.start.y},{robot.start.yaw}'
        for name, robot in options.robots.items()
    ]
    nodes.start(
        'sim_node',
        robots='; '.join(places),
        map_file=str(options.map_file.resolve()),
        real_time_factor=float(options.real_time_factor),
        backend=options.backend,
        seed=options.seed,
    )
    return nodes


def _start_robot(nodes: NodeProcesses, options: FleetOptions, kind: str) -> None:
    nodes.start(
        'planner_node',
        robot=kind,
        method=options.method,
        any_angle=True,
        gait=options.gait,
        use_sim_time=True,
    )
    nodes.start(
        'gait_node', robot=kind, gait=options.gait, turning=options.turning, use_sim_time=True
    )


def _walk(observer: _Observer, go_on: Callable[[], None]) -> None:
    """Wait for the nodes, give the goals, and wait until all robots have arrived."""
    deadline = time.monotonic() + START_TIMEOUT
    while not observer.is_ready:
        go_on()
        if time.monotonic() > deadline:
            raise NodesNotReady(START_TIMEOUT, observer.said)
    began = observer.time
    observer.give_goals()
    standstill, notes = Standstill(began), observer.notes
    while not (notes.have_arrived or notes.problem) and observer.time < began + _LONGEST:
        go_on()
        if standstill.duration(observer.time) > STALL_TIMEOUT:
            notes.problem = str(TimeStandsStill(STALL_TIMEOUT))
    observer.notes.duration = observer.time - began


class _Observer:
    """A node of the command line: it publishes goals and listens."""

    def __init__(self, options: FleetOptions) -> None:
        self._options = options
        self.notes = FleetNotes({name: RobotNotes() for name in options.robots})
        self._context = Context()
        rclpy.init(context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._nodes: list[Node] = []
        self._goals: dict[str, Any] = {}
        self._are_given = False
        simulator = self._make_node('')
        simulator.create_subscription(DiagnosticArray, 'diagnostics', self._on_simulator, 10)
        for name, notes in self.notes.robots.items():
            robot = options.robots[name]
            notes.track.append(robot.start)
            node = self._make_node(name)
            self._goals[name] = node.create_publisher(PoseStamped, 'goal_pose', 10)
            hear = partial(self._on_odometry, notes)
            node.create_subscription(Odometry, 'odom', hear, qos_profile_sensor_data)
            hear = partial(self._on_status, notes, robot.goal)
            node.create_subscription(DiagnosticArray, 'diagnostics', hear, 10)

    def _make_node(self, namespace: str) -> Node:
        """Make a node in a robot's namespace."""
        node = Node('fleet_observer', namespace=namespace, context=self._context)
        self._executor.add_node(node)
        self._nodes.append(node)
        return node

    @property
    def is_ready(self) -> bool:
        """Whether every planner has its map and pose, and every robot stands."""
        return all(
            notes.says.get('planner_node', '').startswith('ready')
            and notes.says.get('gait_node', '').startswith('standing')
            for notes in self.notes.robots.values()
        )

    @property
    def said(self) -> str:
        """What the nodes say of themselves."""
        return '; '.join(
            f'{name}/{node}: {sentence}'
            for name, notes in self.notes.robots.items()
            for node, sentence in notes.says.items()
        )

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return max(notes.time for notes in self.notes.robots.values())

    def give_goals(self) -> None:
        """Give each robot its goal."""
        self._are_given = True
        for name, publisher in self._goals.items():
            message = PoseStamped(pose=pose_message(self._options.robots[name].goal))
            message.header.frame_id = 'map'
            publisher.publish(message)

    def listen(self, duration: float) -> None:
        """Take messages for a time of the wall clock [s]."""
        deadline = time.monotonic() + duration
        while (left := deadline - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        for node in self._nodes:
            node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    def _on_odometry(self, notes: RobotNotes, message: Odometry) -> None:
        notes.time = seconds_from_time(message.header.stamp)
        notes.pose = pose = pose_from_message(message.pose.pose)
        if pose.distance_to(notes.track[-1]) > _STEP:
            notes.track.append(pose)

    def _on_status(self, notes: RobotNotes, goal: Pose2D, message: DiagnosticArray) -> None:
        for status in message.status:
            node = status.name.rpartition('/')[2]
            notes.says[node] = said = status.message
            is_wait = node == 'planner_node' and said.startswith(('waiting for', 'giving way'))
            if is_wait and said not in notes.waits[-1:]:
                notes.waits.append(said)
            is_there = notes.pose is not None and notes.pose.distance_to(goal) < _NEAR
            if self._are_given and said.startswith('arrived') and is_there and not notes.arrived:
                notes.arrived = notes.time

    def _on_simulator(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = {value.key: value.value for value in status.values}
            if status.name.endswith('sim_node'):
                self.notes.contacts = values.get('contacts', self.notes.contacts)
