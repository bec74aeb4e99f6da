"""
Records a robot that runs, until it is told to stop.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rclpy

from quad_common.errors import QuadError
from quad_common.ros.run_node import make_executor
from quad_common.ros.transport import leave_shared_memory
from quad_lab.recordings.recorded_topics import CLOCK, RECORDED, RecordedTopic
from quad_lab.recordings.robot_recording import RobotRecording
from quad_lab.recordings.subscription import subscription_quality

_DISCOVERY = 1.5
"""Time in which what runs is found [s]."""

_PUBLISHER_OF_LINKS = 'robot_state_publisher'


@dataclass(eq=False, repr=False)
class NothingToRecord(QuadError):
    """None of a robot's topics is published."""

    namespace: str
    """Namespace that was looked in; empty for none."""

    def sentence(self) -> str:
        """Say where nobody publishes."""
        where = f'below /{self.namespace}' if self.namespace else 'without a namespace'
        return (
            f'there is nothing to record: nobody publishes odom, joint_states or map {where}; '
            'start the nodes first, in the same ROS_DOMAIN_ID, or give --namespace'
        )


class Recorder:
    """
    A node that listens to a robot; use it in a ``with`` block.

    Parameters
    ----------
    folder : Path
        Where the recording goes.
    namespace : str
        Namespace of the robot; empty for none.
    everything : bool
        Whether topics are asked for that are published for subscribers only.

    Raises
    ------
    NothingToRecord
        If none of the topics is published.
    """

    def __init__(self, folder: Path, namespace: str = '', everything: bool = False) -> None:
        leave_shared_memory(os.environ)
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node(
            'quadwalk_recorder', context=self._context, start_parameter_services=False
        )
        self._executor = make_executor(self._context)
        self._executor.add_node(self._node)
        topics = [topic for topic in RECORDED if everything or not topic.is_on_demand]
        names = {topic: topic.in_namespace(namespace) for topic in topics}
        try:
            found = self._discover(set(names.values()))
            if found <= {CLOCK.name}:
                raise NothingToRecord(namespace)
            self.recording = RobotRecording(
                folder,
                namespace,
                is_simulated=names[CLOCK] in found,
                has_links=_PUBLISHER_OF_LINKS in self._node.get_node_names(),
            )
            """What is recorded."""
        except BaseException:
            self._close()
            raise
        self._names = names

    def __enter__(self) -> Recorder:
        self.recording.__enter__()
        for topic, name in self._names.items():
            kind = topic.message_type()
            if kind is not None:
                self._node.create_subscription(
                    kind, name, self._taking(topic), subscription_quality(topic), raw=True
                )
        return self

    def __exit__(self, *ending: Any) -> None:
        try:
            self.recording.__exit__(*ending)
        finally:
            self._close()

    def listen(self, duration: float) -> None:
        """Record what comes in for some time on the machine's clock [s]."""
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def _taking(self, topic: RecordedTopic) -> Callable[[bytes], None]:
        return lambda data: self.recording.take(topic, data)

    def _discover(self, names: set[str]) -> set[str]:
        """Return those of the topics that somebody publishes, after some time."""
        self.listen(_DISCOVERY)
        return {name for name in names if self._node.count_publishers(name)}

    def _close(self) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()
