"""
Records a robot that runs, until it is told to stop.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rclpy

from quad_common.errors import QuadError
from quad_common.network.transport import leave_shared_memory
from quad_lab.recordings.recorded_topics import (
    BATCHED,
    BATCHES,
    CLOCK,
    ODOMETRY,
    RECORDED,
    SHARED_FIXED_TRANSFORMS,
    SHARED_TRANSFORMS,
    TRANSFORMS,
    RecordedTopic,
)
from quad_lab.recordings.robot_recording import RobotRecording
from quad_lab.recordings.robot_transforms import Others
from quad_lab.recordings.topic_listener import TopicListener

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
                others=self._others(namespace, names[ODOMETRY] in found),
            )
            """What is recorded."""
        except BaseException:
            self._close()
            raise
        if namespace:
            shared = (SHARED_TRANSFORMS, SHARED_FIXED_TRANSFORMS)
            names |= {topic: topic.name for topic in shared}
        batches = BATCHES.in_namespace(namespace)
        batched = {t: name for t, name in names.items() if self._is_in(batches, t, name)}
        others = [(t, name) for t, name in names.items() if t not in batched]
        self._listener = TopicListener(self._node, others, self.recording.take)
        if batched:
            self._listener.take_batches(batches, batched.items())

    def __enter__(self) -> Recorder:
        self.recording.__enter__()
        return self

    def __exit__(self, *ending: Any) -> None:
        try:
            # What came in since the last look.
            self._listener.take(is_last=True)
            self.recording.__exit__(*ending)
        finally:
            self._close()

    def listen(self, duration: float) -> None:
        """Record what comes in for some time on the machine's clock [s]."""
        self._listener.listen(duration)

    def _discover(self, names: set[str]) -> set[str]:
        """Return those of the topics that somebody publishes, after some time."""
        time.sleep(_DISCOVERY)
        return {name for name in names if self._node.count_publishers(name)}

    def _others(self, namespace: str, has_odometry: bool) -> Others:
        """Return what others publish of the robot."""
        nodes = self._node.get_node_names_and_namespaces()
        topics = {TRANSFORMS.in_namespace(namespace), SHARED_TRANSFORMS.name}
        publishers = [
            info.node_name
            for topic in topics
            for info in self._node.get_publishers_info_by_topic(topic)
        ]
        return Others(
            has_body=any(name != _PUBLISHER_OF_LINKS for name in publishers),
            has_links=(_PUBLISHER_OF_LINKS, f'/{namespace}') in nodes,
            has_odometry=has_odometry,
        )

    def _is_in(self, batches: str, topic: RecordedTopic, name: str) -> bool:
        """Return whether all that is published on a topic is in batches on another one, too."""
        publishers = self._node.get_publishers_info_by_topic
        nodes, by_batch = (
            [(info.node_namespace, info.node_name) for info in publishers(published)]
            for published in (name, batches)
        )
        return topic in BATCHED and len(by_batch) == 1 and nodes == by_batch

    def _close(self) -> None:
        self._node.destroy_node()
        self._context.try_shutdown()
