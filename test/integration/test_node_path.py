"""From the callback to the published trajectory each file of the node is entered at most twice."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from file_entries import counted
from geometry_msgs.msg import Twist
from node_in_process import ROBOT

pytestmark = pytest.mark.ros

AHEAD = Twist()
AHEAD.linear.x = 0.03


@pytest.mark.parametrize(
    ('gait', 'ground'), [('crawl', 'flat'), ('trot', 'flat'), ('crawl', 'uneven')]
)
def test_a_measurement_becomes_a_trajectory_by_at_most_two_entries(make_node, gait, ground):
    robot = make_node(gait=gait, ground=ground, robot=ROBOT.name)
    seen, found, published = set(), {}, []
    counting, topics = counted(robot.callbacks['odom'], seen, found), robot.node._topics
    robot.callbacks['odom'] = counting
    robot.callbacks['joint_states'] = counted(robot.callbacks['joint_states'], seen, found)
    publish = topics.publish_trajectory

    def publish_and_end(trajectory):
        publish(trajectory)
        # What is published beside it is asked for afterwards.
        counting.end()
        published.append(trajectory)

    topics.publish_trajectory = publish_and_end
    robot.run(5.0, AHEAD)
    assert not found
    assert any(trajectory is not None for trajectory in published)
    assert {'quad_gait/gait_node.py', 'quad_gait/behaviours/guidance.py'} <= seen
