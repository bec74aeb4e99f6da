"""
Nodes as processes, and somebody who listens to all of them: what every attack needs.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from types import TracebackType
from typing import Any

import rclpy
from rcl_interfaces.srv import GetParameters
from rclpy.node import NodeNameNonExistentError

from quad_common.errors import QuadError
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot.robot import Robot
from quad_common.ros.pose_conversions import pose_from_message
from quad_common.ros.run_node import make_executor
from quad_gait.behaviours.activity import Activity
from quad_lab.attacks.stage.goal_topic import GoalTopic
from quad_lab.attacks.stage.graph import inputs_of
from quad_lab.attacks.stage.listener import TopicListener
from quad_lab.attacks.stage.state import Reaction, processor_time, resident_memory, traceback_ends
from quad_lab.closed_loop.guided_end import GuidedEnd
from quad_lab.topic_walk.node_processes import NodeDied, NodeProcess, NodeProcesses

START_TIMEOUT = 90.0
"""For the nodes to be ready; after an installation the planner's searches are compiled [s]."""

STALL_TIMEOUT = 60.0
"""For simulated time to advance [s]."""

_TOLD_WITHIN = 5.0
"""Simulated time in which the gait's status follows a goal [s]."""

_PATIENCE = 30.0
"""Simulated time for a robot that goes no farther to get another plan [s]."""

_GIVE_UP = 20.0
"""Wait for an answer [s]."""

_LOST = 3.0
"""Time after which a request is repeated [s]: a service that has not found its client yet sends no
answer."""

_DISCOVERY_PERIOD = 1.0
"""Time between two looks for what nodes publish that was not discovered before [s]."""

_LOOK_PERIOD = 0.01
"""Longest time between two looks whether it has come [s]."""

NEAR = 0.05
"""Distance from a goal within which the robot is there [m]."""

_HEADING = 0.09
"""Difference from its heading within which the robot is there [rad]."""


@dataclass(eq=False, repr=False)
class NotSeen(QuadError):
    """Something that was waited for did not come."""

    what: str
    """What was waited for."""
    waited: str
    """Time that was waited, with its unit."""
    said: str
    """What the nodes say."""

    def sentence(self) -> str:
        """Say what did not come."""
        return f'not seen in {self.waited}: {self.what}; the nodes say: {self.said}'


class Stage:
    """
    Starts nodes, ends them, listens to them, and gives goals.

    Parameters
    ----------
    robot : Robot
        Whose limits are checked.
    """

    def __init__(self, robot: Robot) -> None:
        self._processes = NodeProcesses()
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self.node = rclpy.create_node('faults', context=self._context)
        self._executor = make_executor(self._context)
        self._executor.add_node(self.node)
        self.listener = TopicListener(self.node, robot)
        self.nodes: dict[str, NodeProcess] = {}
        """Every node that was started; the last one of a name."""
        self._parameters: dict[str, dict[str, object]] = {}
        self._goals = GoalTopic(self.node)
        self._clients: dict[str, Any] = {}

    def __enter__(self) -> Stage:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._processes.__exit__(kind, error, trace)
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()

    # ---- nodes ----

    def start(self, name: str, **parameters: object) -> None:
        """Start a node; it is listened to once it is found."""
        self._parameters[name] = parameters
        self.nodes[name] = self._processes.start(name, **parameters)

    def start_again(self, name: str) -> None:
        """Start a node that has ended, with the parameters it had."""
        self.listener.statuses.pop(name, None)
        self._goals.note_death(name)
        for service in [each for each in self._clients if each.startswith(f'{name}/')]:
            self.node.destroy_client(self._clients.pop(service))
        self.start(name, **self._parameters[name])

    def wait_until_found(self) -> None:
        """Wait until every node is discovered, and listened to."""
        for name in self.nodes:
            self._wait_for_start(f'{name} is found', partial(self._is_found, name))

    def wait_until_ready(self) -> None:
        """Wait until a goal would be walked to."""
        self.wait_until_found()
        self._wait_for_start('planner and gait are ready', self.is_ready)

    def is_ready(self) -> bool:
        """Return whether planner and gait say that they could begin."""
        planner = self.said('planner_node')
        return (
            planner.startswith(('ready', 'plan'))
            and self.activity in ('standing', 'arrived')
            and self._goals.has_subscribers()
        )

    def dead_nodes(self) -> dict[str, NodeDied]:
        """Return those that have ended, each with how."""
        dead = {}
        for name, process in self.nodes.items():
            try:
                process.check()
            except NodeDied as error:
                dead[name] = error
        return dead

    def tracebacks(self) -> list[str]:
        """Return a line for each traceback in the nodes' logs: how it ends."""
        return [
            f'{name}: {end}'
            for name, process in self.nodes.items()
            for end in traceback_ends(process.log_tail(1_000_000))
        ]

    def memory(self) -> dict[str, float]:
        """Return how much memory of the machine each living node holds [MB]."""
        held = {name: resident_memory(process.pid) for name, process in self.nodes.items()}
        return {name: memory for name, memory in held.items() if memory is not None}

    # ---- waiting ----

    def spin(self, duration: float) -> None:
        """Handle what comes in for some time [s]."""
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def spin_until(self, condition: Callable[[], bool], longest: float) -> bool:
        """Handle what comes in until a condition holds, or some time is over [s]."""
        end = time.monotonic() + longest
        while not (is_so := condition()) and time.monotonic() < end:
            self._executor.spin_once(timeout_sec=_LOOK_PERIOD)
        return is_so

    def wait_until(
        self,
        what: str,
        condition: Callable[[], bool],
        simulated_timeout: float = 300.0,
        stall_timeout: float = STALL_TIMEOUT,
    ) -> None:
        """
        Listen until a condition holds.

        Parameters
        ----------
        what : str
            The condition in words.
        condition : callable
            Returns whether it holds.
        simulated_timeout : float
            In which it must come to hold [s].
        stall_timeout : float
            On the wall clock, in which simulated time must advance [s].

        Raises
        ------
        NotSeen
            If it does not.
        NodeDied
            If a node ends meanwhile.
        """
        seen = self.listener.time
        advanced, passed = time.monotonic(), 0.0
        looked = -math.inf
        while not condition():
            # What a node publishes is not discovered all at once.
            if time.monotonic() > looked + _DISCOVERY_PERIOD:
                self._listen_to_all()
                looked = time.monotonic()
            self._executor.spin_once(timeout_sec=0.05)
            for process in self.nodes.values():
                process.check()
            now = self.listener.time
            if now != seen:
                passed += max(0.0, now - seen)
                seen, advanced = now, time.monotonic()
            if passed > simulated_timeout:
                raise NotSeen(what, f'{passed:.0f} s of simulated time', self.all_said())
            if time.monotonic() - advanced > stall_timeout:
                raise NotSeen(what, f'{stall_timeout:.0f} s without advance', self.all_said())

    def ping(self, name: str) -> Reaction:
        """Measure how long a node takes to answer to a request for a parameter."""
        service, request = f'{name}/get_parameters', GetParameters.Request(names=['robot'])
        if service not in self._clients:
            # Discovery is not the node's own time.
            self.call(service, GetParameters, request)
        return self.reaction(name, self._clients[service].call_async(request))

    def reaction(self, name: str, answer: Any) -> Reaction:
        """Listen until a node has answered to a request; measure how long that takes."""
        process = self.nodes[name]
        began, computed = time.monotonic(), processor_time(process.pid)
        while not answer.done() and time.monotonic() - began < _GIVE_UP:
            self._executor.spin_once(timeout_sec=0.01)
            if name in self.dead_nodes():
                break
        elapsed = time.monotonic() - began
        return Reaction(elapsed, processor_time(process.pid) - computed, answer.done())

    def call(self, name: str, kind: Any, request: Any = None) -> Any:
        """Call a service and return its answer; None if there is none."""
        request = kind.Request() if request is None else request
        # Kept: to find a service takes longer than its answer.
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, name)
        client, end = self._clients[name], time.monotonic() + _GIVE_UP
        self.spin_until(client.service_is_ready, _GIVE_UP)
        while time.monotonic() < end:
            answer = client.call_async(request)
            if self.spin_until(answer.done, _LOST):
                return answer.result()
        return None

    # ---- the robot ----

    @property
    def activity(self) -> str:
        """What the gait node says it does."""
        return self.listener.statuses.get('gait_node', (b'', '', {}))[2].get('activity', '')

    def is_moving(self) -> bool:
        """Return whether the gait node says that the robot walks or turns."""
        return self.activity in {
            Activity.WALKING.value,
            Activity.TURNING.value,
            Activity.BALANCING.value,
        }

    @property
    def has_fallen(self) -> bool:
        """Whether the simulator says so."""
        return self.listener.statuses.get('sim_node', (b'', '', {}))[2].get('has_fallen') == 'True'

    @property
    def contacts(self) -> str:
        """What the simulator says of contacts that should not be."""
        return self.listener.statuses.get('sim_node', (b'', '', {}))[2].get('contacts', '')

    @property
    def pose(self) -> Pose2D | None:
        """Where the robot is; None before odometry was received, and if that is nonsense."""
        message = self.listener.last.get('/odom')
        with contextlib.suppress(QuadError):
            return None if message is None else pose_from_message(message.pose.pose)
        return None

    def said(self, name: str) -> str:
        """Return what a node said last."""
        return self.listener.statuses.get(name, (b'', '', {}))[1]

    def all_said(self) -> str:
        """Return what all nodes said last."""
        return '; '.join(f'{name}: {self.said(name)[:200] or "nothing"}' for name in self.nodes)

    def give_goal(self, goal: Pose2D) -> None:
        """Publish a goal, once a living planner subscribes to it."""
        end = time.monotonic() + _GIVE_UP
        while not self._goals.has_subscribers() and time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.05)
        self._goals.publish(goal)

    def is_at(self, goal: Pose2D) -> bool:
        """Return whether the gait says that it has arrived, and the robot is at the goal."""
        pose = self.pose
        return (
            self.activity == 'arrived'
            and pose is not None
            and pose.distance_to(goal) <= NEAR
            and abs(wrap_angle(pose.yaw - goal.yaw)) <= _HEADING
        )

    def walk_to(self, goal: Pose2D, simulated_timeout: float = 400.0) -> None:
        """Give a goal and wait until the robot is there; NotSeen soon if no plan moves it."""
        self.give_goal(goal)
        began, end = self.listener.time, GuidedEnd(_PATIENCE)

        def is_over() -> bool:
            # What was said before the goal was received does not count.
            is_told = self.listener.time > began + _TOLD_WITHIN
            is_told = is_told and self.activity not in ('', Activity.ARRIVED.value)
            activity = Activity(self.activity) if is_told else None
            return self.is_at(goal) or end.is_over(self.listener.time, activity)

        what = f'arrival at {goal}'
        self.wait_until(what, is_over, simulated_timeout)
        if not self.is_at(goal):
            raise NotSeen(what, f'{self.listener.time - began:.0f} s', self.all_said())

    def _wait_for_start(self, what: str, condition: Callable[[], bool]) -> None:
        """Wait on the wall clock: simulated time may run, or not yet, while nodes start."""
        end = time.monotonic() + START_TIMEOUT
        while not condition():
            self._executor.spin_once(timeout_sec=0.05)
            for process in self.nodes.values():
                process.check()
            if time.monotonic() > end:
                raise NotSeen(what, f'{START_TIMEOUT:.0f} s', self.all_said())

    def _is_found(self, name: str) -> bool:
        try:
            if not inputs_of(self.node, name):
                return False
            self.listener.listen_to([name])
        except NodeNameNonExistentError:
            return False
        return name in self.listener.statuses

    def _listen_to_all(self) -> None:
        for name in self.nodes:
            with contextlib.suppress(NodeNameNonExistentError):
                self.listener.listen_to([name])
