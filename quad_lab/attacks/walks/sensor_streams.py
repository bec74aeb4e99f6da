"""
A walk without topics whose sensors do not tell in time: seldom, late, always the same, or nothing.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from quad_common.errors import InvalidMessage
from quad_common.robot.robot import Robot
from quad_gait.supervisor import Supervisor
from quad_lab.closed_loop.balance_loop import BalanceLoop
from quad_lab.closed_loop.closed_loop import true_place
from quad_sim.engines.simulator import Observation

SENSORS = ('imu', 'joints', 'odometry')
"""What tells of the robot, in the order in which it is published."""


@dataclass(frozen=True)
class StreamFault:
    """What is wrong with the readings of a sensor."""

    period: float = 0.0
    """Time from one reading to the next, where that is longer than usual [s]."""
    delay: float = 0.0
    """Time that a reading travels [s]."""
    is_stuck: bool = False
    """Whether each says what the first one said, at the time of its own."""
    is_silent: bool = False
    """Whether there are none."""


SOUND = StreamFault()
"""A sensor with which nothing is wrong."""


class SensorStream:
    """Readings of one sensor on their way."""

    def __init__(self) -> None:
        self.fault = SOUND
        """What is wrong with it now."""
        self._on_their_way: deque[tuple[float, Observation]] = deque()
        self._last = -float('inf')
        self._first: Observation | None = None

    def begin(self, fault: StreamFault) -> None:
        """Let something be wrong from now on."""
        self.fault, self._first = fault, None

    def pass_on(self, seen: Observation) -> Iterator[Observation]:
        """Take what is measured now; return what has come by now, the oldest first."""
        fault = self.fault
        if not fault.is_silent and seen.time - self._last > fault.period - 1e-6:
            self._last = seen.time
            self._first = self._first or seen
            told = replace(self._first, time=seen.time) if fault.is_stuck else seen
            self._on_their_way.append((seen.time + fault.delay, told))
        while self._on_their_way and self._on_their_way[0][0] <= seen.time + 1e-6:
            yield self._on_their_way.popleft()[1]


class StreamedLoop(BalanceLoop):
    """
    A robot each of whose sensors tells by a stream of its own, decided upon at its odometry.

    Parameters
    ----------
    robot : Robot
        The robot.
    controller : Supervisor
        What moves it.
    **others
        As :class:`~quad_lab.closed_loop.balance_loop.BalanceLoop` takes them.
    """

    def __init__(self, robot: Robot, controller: Supervisor, **others: Any) -> None:
        super().__init__(robot, controller, **others)
        self.locate = true_place
        self._streams = {sensor: SensorStream() for sensor in SENSORS}

    def disturb(self, faults: Mapping[str, StreamFault]) -> None:
        """Let something be wrong with some of :data:`SENSORS`, and nothing with the others."""
        for sensor, stream in self._streams.items():
            stream.begin(faults.get(sensor, SOUND))

    def decide(self, seen: Observation) -> None:
        """Tell what has come of an observation, and of those before it; send what is decided."""
        imu, joints, odometry = (self._streams[sensor] for sensor in SENSORS)
        for told in imu.pass_on(seen):
            self._take_imu(told)
        for told in joints.pass_on(seen):
            # What cannot be is left out, as in the node.
            with contextlib.suppress(InvalidMessage):
                self._estimator.take_joints(self._readings(told))
        for told in odometry.pass_on(seen):
            with contextlib.suppress(InvalidMessage):
                self._decide_at(told)

    def _decide_at(self, told: Observation) -> None:
        now = self.time
        state = self._estimator.take_odometry(told.time, told.pose, told.orientation, now)
        trajectory = None if state is None else self.controller.update(state)
        if trajectory is not None:
            self._send(trajectory)
