"""Nodes are listened to however their topics are discovered."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from quad_common.robot_files.robot_file import load_robot
from quad_lab.attacks.stage.listener import TopicListener

TYPE = 'nav_msgs/msg/OccupancyGrid'

OFFER = SimpleNamespace(
    topic_type=TYPE,
    qos_profile=SimpleNamespace(
        reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
    ),
)


class Graph:
    """A node that has discovered some of another one."""

    def __init__(self):
        self.topics, self.offers, self.subscribed = [], [], []

    def get_publisher_names_and_types_by_node(self, node, namespace):
        return [(topic, [TYPE]) for topic in self.topics]

    def get_publishers_info_by_topic(self, topic):
        return self.offers

    def create_subscription(self, kind, topic, callback, qos, raw):
        self.subscribed.append((topic, qos.durability))


def test_a_topic_whose_publisher_is_discovered_later_is_listened_to_then_and_once():
    graph = Graph()
    listener = TopicListener(graph, load_robot('titan_viii'))
    graph.topics = ['/map']
    listener.listen_to(['sim_node'])
    assert graph.subscribed == []
    graph.offers = [OFFER]
    listener.listen_to(['sim_node'])
    listener.listen_to(['sim_node'])
    assert graph.subscribed == [('/map', DurabilityPolicy.TRANSIENT_LOCAL)]


def test_a_topic_that_is_discovered_later_is_listened_to_then():
    graph = Graph()
    listener = TopicListener(graph, load_robot('titan_viii'))
    graph.topics, graph.offers = ['/map'], [OFFER]
    listener.listen_to(['sim_node'])
    graph.topics = ['/map', '/map_updates']
    listener.listen_to(['sim_node'])
    assert [topic for topic, _ in graph.subscribed] == ['/map', '/map_updates']
