"""
Publishes goals to planners that may have been killed.
"""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseStamped

from quad_common.planar_pose import Pose2D
from quad_lab.attacks.stage.examples import goal_message


class GoalTopic:
    """
    The topic of the goals, as seen by who gives them.

    Parameters
    ----------
    node : rclpy.node.Node
        Whose publisher it is.
    """

    def __init__(self, node: Any) -> None:
        self._node = node
        self._publisher = node.create_publisher(PoseStamped, 'goal_pose', 10)
        self._dead: set[bytes] = set()

    def note_death(self, name: str) -> None:
        """Count no longer on a node: one that was killed is listed until its lease runs out."""
        self._dead |= {
            bytes(reader.endpoint_gid)
            for reader in self._node.get_subscriptions_info_by_topic('goal_pose')
            if reader.node_name == name
        }

    def has_subscribers(self) -> bool:
        """Return whether a living node subscribes to goals."""
        readers = self._node.get_subscriptions_info_by_topic('goal_pose')
        living = {bytes(reader.endpoint_gid) for reader in readers} - self._dead
        return bool(living) and self._publisher.get_subscription_count() > 0

    def publish(self, goal: Pose2D) -> None:
        """Publish a goal on the map."""
        self._publisher.publish(goal_message(goal))
