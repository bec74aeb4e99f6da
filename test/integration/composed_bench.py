"""
A bench whose nodes are made in this process, in step with the simulator.

For what is asserted about walks, not about processes: a robot that is ready takes half a second of
processor time in place of four, nothing comes late however busy the machine is, and no time passes
between what a test sees and what it does. Steering and corrections come in simulated time.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from typing import Any

from harness import Bench
from rclpy.parameter import Parameter

from quad_common.ros.guarded_node import GuardedNode
from quad_gait.gait_node import GaitNode
from quad_lab.topic_walk.draining import drain
from quad_lab.topic_walk.node_processes import in_simulated_time
from quad_perception.ceiling_camera_node import CeilingCameraNode
from quad_planner.planner_node import PlannerNode
from quad_planner.session.immediate_request import ImmediateRequest
from quad_sim.sim_node import SimNode

_NODES: dict[str, type[GuardedNode]] = {
    'planner_node': PlannerNode,
    'gait_node': GaitNode,
    'sim_node': SimNode,
    'ceiling_camera_node': CeilingCameraNode,
}

_PAUSE = 0.05
"""Longest wait for what comes while nothing is simulated [s], on the wall clock."""

_LONG = 60.0
"""Longer than a busy machine pauses [s]."""

_PERIOD = 0.5
"""Simulated time between two messages that are published again and again [s]."""

_WALL_PERIOD = 0.1
"""The same on the wall clock, where nothing is simulated [s]."""


class ComposedBench(Bench):
    """A bench that makes nodes rather than starting them; ``kill`` destroys one."""

    def __init__(self) -> None:
        super().__init__()
        self._made: dict[str, Any] = {}
        self._unexpected: list[str] = []
        self._repeated: list[Any] = []
        self._repeated_at = 0.0
        self._is_held = False

    def start(self, name: str, **parameters: object) -> None:
        """
        Make a node; a simulator that goes on only while the test waits, as fast as it can.

        What cannot be made here, such as the viewer with its threads, is started.
        """
        if name not in _NODES:
            super().start(name, **parameters)
            return
        if name == 'sim_node':
            parameters = {'backend': 'kinematic', **parameters, 'real_time_factor': 0.0}
            if parameters['backend'] == 'kinematic':
                # Nothing slips or touches in between.
                parameters.setdefault('sensor_rate', 25.0)
        if name == 'gait_node':
            # By the wall clock: a machine that pauses has no odometry meanwhile, and misses none.
            parameters = {'odom_timeout': _LONG, **parameters}
        given = in_simulated_time(name, parameters)
        overrides = [Parameter(key, value=value) for key, value in given.items()]
        # Plans are there when the callback that asks for them ends, not when a thread is through.
        others = {'requests': ImmediateRequest()} if name == 'planner_node' else {}
        node = _NODES[name](context=self._context, parameter_overrides=overrides, **others)
        report = node.report_unexpected

        def report_unexpected(sentence: str, kind: str, stack: str | None) -> None:
            self._unexpected.append(f'{name}: {sentence}\n{stack}')
            report(sentence, kind, stack)

        node.report_unexpected = report_unexpected
        self._made[name] = node
        self._executor.add_node(node)

    def kill(self, name: str) -> None:
        """End a node; the others see that it has gone."""
        if name not in self._made:
            super().kill(name)
            return
        self._executor.remove_node(self._made[name])
        for timer in self._made[name].timers:
            # One that is due after what follows would be called of a node that is no more.
            timer.cancel()
        # What it has received already is still brought to it.
        self._drain()
        self._made.pop(name).destroy_node()
        self.statuses.pop(name, None)

    @contextlib.contextmanager
    def publishing(self, topic: str, message: Any, qos: Any = 10) -> Iterator[None]:
        """Publish a message again and again in this block; a callable makes each."""
        make = message if callable(message) else lambda: message
        publisher = self.publisher(type(make()), topic, qos)
        each = (publisher, make)
        self._repeated.append(each)
        yield
        self._repeated.remove(each)

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """
        Simulate nothing in this block; the wall clock goes on, and with it each second's status.

        Between two of those a quick machine simulates more than a minute.
        """
        self._is_held = True
        yield
        self._is_held = False

    def _listen(self) -> None:
        """Simulate up to the next measurement, and until everything is received and answered."""
        simulator = None if self._is_held else self._made.get('sim_node')
        clock, period = (
            (time.monotonic(), _WALL_PERIOD) if simulator is None else (self.elapsed, _PERIOD)
        )
        if not 0.0 <= clock - self._repeated_at < period:
            self._repeated_at = clock
            for publisher, make in self._repeated:
                publisher.publish(make())
        for name in self._alive:
            self.processes[name].check()
        wait = _PAUSE if simulator is None else min(simulator.drive(), _PAUSE)
        if wait > 0.0:
            self._executor.spin_once(timeout_sec=wait)
        self._drain()

    def _drain(self) -> None:
        drain(self._executor, self._calls)

    def _calls(self) -> int:
        return self.received + sum(node.callbacks for node in self._made.values())

    def _end_nodes(self) -> None:
        """Destroy all nodes; none may have raised anything that was not foreseen."""
        for name in list(self._made):
            self.kill(name)
        super()._end_nodes()
        assert self._unexpected == []
