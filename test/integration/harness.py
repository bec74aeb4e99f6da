"""
Real nodes as processes, and a node of the test's own that talks to them.

Nothing here sleeps: tests wait on conditions. How long they may take is counted in
simulated time, so that a slow machine changes nothing; the wall clock only notices that
nothing happens at all.
"""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import pytest

pytest.importorskip('rclpy')

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from quad_common.errors import QuadError
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.ros.pose_conversions import (
    plan_from_message,
    pose_from_message,
    pose_message,
    seconds_from_time,
)
from quad_common.ros.run_node import make_executor
from quad_gait.behaviours.activity import Activity
from quad_lab.topic_walk.node_processes import NodeDied, NodeProcess, NodeProcesses
from quad_sim.engines.registry import ENGINES

OK, WARN, ERROR, STALE = (
    DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR, DiagnosticStatus.STALE
)  # fmt: skip

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SENSOR = qos_profile_sensor_data

EVERY_SAMPLE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
"""For what comes at 100 Hz of simulated time: ten seconds of it may pass in a test's pause."""

PHYSICS = 'mujoco' if ENGINES['mujoco'].is_installed else 'bullet'
"""Engine of walks that are not about one: they take a third of the time in MuJoCo."""

START = Pose2D(1.2, 1.2, 0.0)
"""Where the robot stands at first, unless a test says otherwise."""

SIMULATED_TIMEOUT = 300.0
"""For whatever a test waits for [s]."""

WALL_TIMEOUT = 60.0
"""For simulated time to advance, or, where none runs, for what a test waits for [s]."""

_LOST = 5.0
"""Time on the wall clock after which a request is repeated [s]."""

_HELPED_WITHIN = 5.0
"""Simulated time in which a robot that somebody must help first is seen to be helped [s]."""

DEFAULTS: dict[str, dict[str, object]] = {
    # Bounded, so that a walk does not end before a test has done what it does in its middle, and
    # a node that has to wait for the processor misses no more than it may: at ten times real time
    # half a metre takes a second.
    'sim_node': {'backend': 'kinematic', 'real_time_factor': 10.0},
    # At that pace a message is on its way for a good part of a simulated second.
    'gait_node': {'lead_time': 2.0},
}
"""Parameters of the nodes, unless a test says otherwise."""

SLOWLY = 5.0
"""Times real time: for tests that do several things while the robot walks half a metre."""


@dataclass(frozen=True)
class Status:
    """What a node said on ``diagnostics``."""

    level: bytes
    message: str
    values: dict[str, str]

    def is_like(self, words: str, level: bytes | None = None, code: int | None = None) -> bool:
        """Return whether the words are in it, and level and error code are these."""
        return (
            words in self.message
            and level in (None, self.level)
            and (code is None or self.values.get('error_code') == str(code))
        )

    @property
    def activity(self) -> str:
        """What a gait node says it does."""
        return self.values.get('activity', '')

    def __str__(self) -> str:
        name = {OK: 'OK', WARN: 'WARN', ERROR: 'ERROR', STALE: 'STALE'}[self.level]
        return f'{name}: {self.message} {self.values}'


class Bench:
    """
    Starts nodes, ends them, talks to them, and waits for what they do.

    Parameters
    ----------
    namespace : str
        Of all topics and services.
    """

    def __init__(self, namespace: str = '') -> None:
        self.processes: dict[str, NodeProcess] = {}
        """Every node that was started; the last one of a name."""
        self.statuses: dict[str, Status] = {}
        """What each running node said last."""
        self.plans: list[Plan | None] = []
        """Every plan heard."""
        self.odometry: Odometry | None = None
        self.joint_states: JointState | None = None
        self.time = 0.0
        """Simulated time, as last heard [s]."""
        self.elapsed = 0.0
        """Simulated time that was seen to pass, over all simulators [s]."""
        self._nodes = NodeProcesses(namespace)
        self.received = 0
        """Number of messages heard."""
        self._alive: set[str] = set()
        self._pids: list[int] = []
        self._listeners: list[Callable[[str, Status], None]] = []
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}
        self._dead_readers: set[bytes] = set()
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self.node = rclpy.create_node('bench', namespace=namespace, context=self._context)
        self._executor = make_executor(self._context)
        self._executor.add_node(self.node)
        self._subscribe(DiagnosticArray, 'diagnostics', self._on_diagnostics, 100)
        self._subscribe(Odometry, 'odom', self._on_odometry, EVERY_SAMPLE)
        self._subscribe(JointState, 'joint_states', self._on_joint_states, EVERY_SAMPLE)
        self._subscribe(Path, 'plan', self._on_plan, LATCHED)

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *error: object) -> None:
        # Shown by pytest if the test failed.
        print(self.report())
        try:
            self._end_nodes()
        finally:
            self._nodes.__exit__(None, None, None)
            self._executor.shutdown()
            self.node.destroy_node()
            self._context.try_shutdown()

    # ---- nodes ----

    def start(self, name: str, **parameters: object) -> None:
        """Start a node, or start it again."""
        parameters = {**DEFAULTS.get(name, {}), **parameters}
        if parameters.get('backend') == 'bullet' and find_spec('pybullet') is None:
            pytest.skip('pybullet is not installed')
        self.processes[name] = self._nodes.start(name, **parameters)
        self._pids.append(self.processes[name].pid)
        self._alive.add(name)

    def start_robot(
        self, gait_parameters: Mapping[str, object] | None = None, **sim_parameters: object
    ) -> None:
        """Start simulator, planner and gait, and wait until a goal would be walked to."""
        self.start('sim_node', **sim_parameters)
        self.start('planner_node')
        self.start('gait_node', **(gait_parameters or {}))
        self.wait_for_status('planner_node', 'ready', level=OK)
        self.wait_for_status('gait_node', 'standing', level=OK)
        self.wait_for_robot()

    def kill(self, name: str) -> None:
        """End a node at once, as a crash would."""
        for topic in self._publishers:
            readers = self.node.get_subscriptions_info_by_topic(topic)
            self._dead_readers |= {_gid(r) for r in readers if r.node_name == name}
        self._alive.discard(name)
        self.processes[name].kill()
        self.statuses.pop(name, None)
        # A client would take the dead node for a living one just as long.
        for client in self._clients.values():
            self.node.destroy_client(client)
        self._clients.clear()

    def interrupt(self, name: str, gap: float) -> int:
        """Press Ctrl-C twice; return the node's exit code."""
        self._alive.discard(name)
        pid = self.processes[name].pid
        os.kill(pid, signal.SIGINT)
        time.sleep(gap)
        # It is not waited for yet, so the id is still its own even if it has ended.
        os.kill(pid, signal.SIGINT)
        return self.processes[name].stop(WALL_TIMEOUT)

    def wait_for_end(self, name: str) -> NodeDied:
        """Wait until a node ends on its own; return how."""
        with pytest.raises(NodeDied) as died:
            self.wait_until(f'{name} ends', lambda: False)
        self._alive.discard(name)
        return died.value

    # ---- waiting ----

    def wait_until(
        self,
        what: str,
        condition: Callable[[], bool],
        simulated_timeout: float = SIMULATED_TIMEOUT,
        wall_timeout: float = WALL_TIMEOUT,
    ) -> None:
        """
        Listen until a condition holds, or fail the test.

        Parameters
        ----------
        what : str
            The condition in words.
        condition : callable
            Returns whether it holds.
        simulated_timeout : float
            In which it must come to hold [s].
        wall_timeout : float
            In which simulated time must advance; where there is none, the condition must
            come to hold in it [s].
        """
        began = advanced = self.elapsed
        alive_at = time.monotonic()
        while not condition():
            self._listen()
            if self.elapsed > advanced:
                advanced, alive_at = self.elapsed, time.monotonic()
            if advanced - began > simulated_timeout:
                pytest.fail(f'in {simulated_timeout:.0f} s of simulated time not seen: {what}')
            if time.monotonic() - alive_at > wall_timeout:
                pytest.fail(f'nothing happens since {wall_timeout:.0f} s; not seen: {what}')

    def _listen(self) -> None:
        """Take what comes, and notice a node that has ended."""
        self._executor.spin_once(timeout_sec=0.1)
        for name in self._alive:
            self.processes[name].check()

    def wait_for_status(self, node: str, words: str, **wanted: Any) -> Status:
        """Listen until a node says something; see `Status.is_like`."""
        what = f"{node} says '{words}' {wanted or ''}"
        self.wait_until(what, lambda: self.says(node, words, **wanted))
        return self.statuses[node]

    @contextlib.contextmanager
    def listening(self, node: str) -> Iterator[list[Status]]:
        """Give all that a node says in this block, first what it said last before."""
        heard = [self.statuses[node]] if node in self.statuses else []

        def listener(name: str, status: Status) -> None:
            if name == node:
                heard.append(status)

        self._listeners.append(listener)
        try:
            yield heard
        finally:
            self._listeners.remove(listener)

    @contextlib.contextmanager
    def expects(self, node: str, words: str, **wanted: Any) -> Iterator[None]:
        """Expect that what is done in this block makes a node say something, if only once."""
        with self.listening(node) as heard:
            del heard[:]
            yield
            self.wait_until(
                f"{node} says '{words}' {wanted or ''}",
                lambda: any(status.is_like(words, **wanted) for status in heard),
            )

    # ---- listening ----

    def says(self, node: str, words: str, **wanted: Any) -> bool:
        """Return whether the last that a node said is like this."""
        return node in self.statuses and self.statuses[node].is_like(words, **wanted)

    def hear(self, kind: Any, topic: str, qos: Any = 10) -> list[Any]:
        """Listen to a topic; messages are appended to the list."""
        messages: list[Any] = []
        self._subscribe(kind, topic, messages.append, qos)
        return messages

    def services_of(self, node: str) -> dict[str, list[str]]:
        """
        Give the types of the services of a node by their names, once it has been discovered.

        A status may be heard before the graph names who published it.
        """
        services: dict[str, list[str]] = {}

        def are_discovered() -> bool:
            if node not in self.node.get_node_names():
                return False
            found = self.node.get_service_names_and_types_by_node(node, '/')
            services.update(found)
            return f'/{node}/set_parameters' in services

        self.wait_until(f'the services of {node} are discovered', are_discovered)
        return services

    @property
    def pose(self) -> Pose2D:
        """Where the robot is; it is waited for until it is known."""
        self.wait_for_robot()
        assert self.odometry is not None
        return pose_from_message(self.odometry.pose.pose)

    @property
    def plan(self) -> Plan | None:
        """The plan in force."""
        return self.plans[-1] if self.plans else None

    @property
    def activity(self) -> str:
        """What the gait node says it does."""
        status = self.statuses.get('gait_node')
        return '' if status is None else status.activity

    def is_near(self, goal: Pose2D, distance: float = 0.05, angle: float = 0.09) -> bool:
        """Return whether the robot is at a pose, within 5 cm and 5 degrees."""
        pose = self.pose
        return pose.distance_to(goal) <= distance and abs(wrap_angle(pose.yaw - goal.yaw)) <= angle

    def wait_for_arrival(self, goal: Pose2D, **timeouts: float) -> None:
        """Listen until the robot says that it is at the goal, and is there."""
        able_at = self.elapsed

        def has_arrived() -> bool:
            nonlocal able_at
            if not self.activity or not Activity(self.activity).is_disabled:
                able_at = self.elapsed
            elif self.elapsed > able_at + _HELPED_WITHIN:
                pytest.fail(f'no plan moves the robot: {self.statuses["gait_node"]}')
            return self.activity == 'arrived' and self.is_near(goal)

        self.wait_until(f'arrival at {goal}', has_arrived, **timeouts)

    def wait_for_robot(self) -> None:
        """Listen until odometry and joint states were heard: other nodes may hear them sooner."""
        self.wait_until('odometry', lambda: self.odometry is not None)
        self.wait_until('joint states', lambda: self.joint_states is not None)

    def wait_for_walking(self, distance: float = 0.15) -> None:
        """Listen until the robot is in the middle of its walk."""
        start = self.pose
        # Statuses and odometry are heard in no common order: what was said counts, not what was
        # said last when the robot is seen to have come so far.
        with self.listening('gait_node') as heard:
            self.wait_until(
                f'the robot walks, and has come {distance} m far',
                lambda: (
                    any(status.activity == 'walking' for status in heard)
                    and self.pose.distance_to(start) > distance
                ),
            )

    # ---- talking ----

    def publisher(self, kind: Any, topic: str, qos: Any = 10) -> Any:
        """Return the publisher of a topic once a living node listens."""
        if topic not in self._publishers:
            self._publishers[topic] = self.node.create_publisher(kind, topic, qos)
        publisher = self._publishers[topic]

        def is_heard() -> bool:
            # A node that was killed counts as a listener until its lease runs out.
            readers = {_gid(r) for r in self.node.get_subscriptions_info_by_topic(topic)}
            return publisher.get_subscription_count() > 0 and bool(readers - self._dead_readers)

        self.wait_until(f"'{topic}' is heard", is_heard)
        return publisher

    @contextlib.contextmanager
    def publishing(self, topic: str, message: Any, qos: Any = 10) -> Iterator[None]:
        """Publish a message again and again in this block; a callable makes each."""
        make = message if callable(message) else lambda: message
        publisher = self.publisher(type(make()), topic, qos)
        timer = self.node.create_timer(0.1, lambda: publisher.publish(make()))
        yield
        self.node.destroy_timer(timer)

    def give_goal(self, goal: Pose2D | PoseStamped, frame: str = 'map') -> None:
        """Publish a goal."""
        if isinstance(goal, Pose2D):
            goal = PoseStamped(pose=pose_message(goal))
        goal.header.frame_id = frame
        self.publisher(PoseStamped, 'goal_pose').publish(goal)

    def publish_map(self, message: OccupancyGrid) -> None:
        """Publish a map, for late subscribers too."""
        self.publisher(OccupancyGrid, 'map', LATCHED).publish(message)

    def call(self, service: str, kind: Any = Trigger, request: Any = None) -> Any:
        """Call a service, which may be called twice, and return its answer."""
        request = kind.Request() if request is None else request
        client = self.client(service, kind)
        answers = [client.call_async(request)]
        asked = time.monotonic()

        def is_answered() -> bool:
            nonlocal asked
            # A server that has not found the client's reader yet answers, and nobody gets it.
            if time.monotonic() > asked + _LOST:
                answers.append(client.call_async(request))
                asked = time.monotonic()
            return any(answer.done() for answer in answers)

        self.wait_until(f"service '{service}' answers", is_answered)
        return next(answer for answer in answers if answer.done()).result()

    def client(self, service: str, kind: Any = Trigger) -> Any:
        """Return a service's client once that is there; before a walk, if time is short in it."""
        if service not in self._clients:
            self._clients[service] = self.node.create_client(kind, service)
        client = self._clients[service]
        self.wait_until(f"service '{service}' is there", client.service_is_ready)
        return client

    # ---- callbacks ----

    def _subscribe(self, kind: Any, topic: str, take: Callable[[Any], None], qos: Any) -> None:
        def on_message(message: Any) -> None:
            self.received += 1
            take(message)

        self.node.create_subscription(kind, topic, on_message, qos)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            name = status.name.rsplit('/', 1)[-1]
            values = {pair.key: pair.value for pair in status.values}
            said = Status(status.level, status.message, values)
            self.statuses[name] = said
            for listener in self._listeners:
                listener(name, said)

    def _on_odometry(self, message: Odometry) -> None:
        now = seconds_from_time(message.header.stamp)
        if now == 0.0:
            # It comes from the test itself.
            return
        if self.odometry is not None:
            # What went by before the first sample was not seen.
            self.elapsed += max(0.0, now - self.time)
        self.time = now
        self.odometry = message

    def _on_joint_states(self, message: JointState) -> None:
        self.joint_states = message

    def _on_plan(self, message: Path) -> None:
        # A malformed one may come from the test itself.
        with contextlib.suppress(QuadError):
            self.plans.append(plan_from_message(message))

    # ---- the end ----

    def report(self) -> str:
        """Say all that helps to see why a test failed."""
        lines = [f'simulated time {self.time:.2f} s, in all {self.elapsed:.2f} s']
        if self.odometry is not None:
            lines.append(f'robot at {self.pose}')
        lines.append(f'{len(self.plans)} plans, the last: {self.plan}')
        for name, process in self.processes.items():
            lines.append(f'---- {name}: {self.statuses.get(name, "not heard of")}')
            lines.append(process.log_tail(15))
        return '\n'.join(lines)

    def _end_nodes(self) -> None:
        """Interrupt all nodes at once; each must end well and leave nothing behind."""
        for name in self._alive:
            self.processes[name].interrupt()
        for name in self._alive:
            code = self.processes[name].stop(WALL_TIMEOUT)
            assert code == 0, f'{name} ended with {code}:\n{self.processes[name].log_tail(40)}'
        for name, process in self.processes.items():
            log = process.log_tail(10_000)
            assert 'Traceback' not in log, f'a traceback in the log of {name}:\n{log}'
        for pid in self._pids:
            # Each node leads a process group of its own: nothing may be left of it.
            with pytest.raises(ProcessLookupError):
                os.killpg(pid, 0)


def _gid(endpoint: Any) -> bytes:
    return bytes(endpoint.endpoint_gid)
