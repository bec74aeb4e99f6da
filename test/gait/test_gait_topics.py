"""
What the gait publishes, and how often.
"""

import math
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pytest

pytest.importorskip('geometry_msgs')

from builtin_interfaces.msg import Time

from quad_common.planar_pose import Pose2D
from quad_gait.gait_topics import GaitTopics, LeastSince
from quad_gait.parameters import GaitParameters

CORNERS = np.array([[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1]])


class Node:
    """A node whose publishers keep what they are given."""

    def __init__(self, readers=1):
        self.published = {}
        self._readers = readers

    def create_publisher(self, kind, topic, qos):
        kept = self.published.setdefault(topic, [])
        return SimpleNamespace(publish=kept.append, get_subscription_count=lambda: self._readers)


def published_polygons(contacts, readers=1):
    """Publish at 50 Hz which feet stand; return the polygons."""
    supervisor = mock.Mock()
    supervisor.support.margin_at.return_value = 0.05
    supervisor.support.polygon_at.return_value = CORNERS
    node = Node(readers)
    topics = GaitTopics(node, supervisor, GaitParameters())
    for k, standing in enumerate(contacts):
        supervisor.in_contact_at.return_value = np.array(standing)
        state = mock.Mock(time=0.02 * k, pose=Pose2D(0.0, 0.0, 0.0))
        state.stability_margin.return_value = 0.04
        topics.publish_decision(None, state, 'odom', Time())
    return node.published


ALL, THREE = (True, True, True, True), (True, False, True, True)


@pytest.mark.parametrize('ground', ['flat', 'uneven'])
def test_margins_come_ten_times_a_second_and_none_that_is_less_is_left_out(ground):
    supervisor = mock.Mock(impassable=None, wanted_plan=None)
    supervisor.felt_ground.count = 0
    supervisor.support.margin_at.side_effect = lambda t: 0.01 if abs(t - 1.06) < 0.001 else 0.05
    supervisor.in_contact_at.return_value = np.array(ALL)
    node = Node()
    topics = GaitTopics(node, supervisor, GaitParameters(ground=ground))
    supervisor.support.polygon_at.return_value = CORNERS
    for k in range(100):
        state = mock.Mock(time=0.02 * k, pose=Pose2D(0.0, 0.0, 0.0))
        state.support_polygon.return_value = CORNERS
        state.stability_margin.return_value = 0.01 if k == 53 else 0.04
        topics.publish_decision(None, state, 'map', Time())
    for topic in ('stability_margin', 'stability_margin/measured'):
        margins = [message.data for message in node.published[topic]]
        assert len(margins) == pytest.approx(20, abs=1)
        assert margins.count(0.01) == 1


def test_a_margin_that_is_not_known_is_not_published():
    least = LeastSince(0.1)
    assert least.take(0.0, math.nan) is None
    assert least.take(0.02, 0.03) == 0.03
    assert least.take(0.04, -math.inf) is None
    assert least.take(0.06, 0.05) is None
    assert least.take(0.12, 0.04) == 0.04
    # The clock was set back.
    assert least.take(0.01, 0.06) == 0.06


def test_the_polygon_of_the_same_feet_comes_ten_times_a_second():
    polygons = published_polygons([ALL] * 50)['support_polygon']
    assert len(polygons) == pytest.approx(10, abs=1)
    assert len(polygons[0].polygon.points) == len(CORNERS)


def test_the_polygon_of_other_feet_comes_at_once():
    assert len(published_polygons([ALL, THREE, ALL, THREE])['support_polygon']) == 4


def test_without_a_reader_there_is_none():
    assert published_polygons([ALL] * 20, readers=0)['support_polygon'] == []


def test_a_place_without_footing_is_published_once_and_on_uneven_ground_only():
    for ground, count in (('uneven', 1), ('flat', 0)):
        supervisor = mock.Mock(impassable=Pose2D(1.0, 2.0, 0.5), wanted_plan=None)
        supervisor.felt_ground.count = 0
        supervisor.support.margin_at.return_value = 0.05
        supervisor.in_contact_at.return_value = np.array(ALL)
        node = Node(readers=0)
        topics = GaitTopics(node, supervisor, GaitParameters(ground=ground))
        for k in range(5):
            state = mock.Mock(time=0.02 * k, pose=Pose2D(0.0, 0.0, 0.0))
            state.stability_margin.return_value = 0.04
            topics.publish_decision(None, state, 'map', Time())
        published = node.published.get('plan/impassable', [])
        assert len(published) == count
        for message in published:
            assert (message.pose.position.x, message.pose.position.y) == (1.0, 2.0)
            assert message.header.frame_id == 'map'


def test_felt_ground_is_published_when_one_more_foot_has_met_it_and_on_uneven_ground_only():
    for ground, count in (('uneven', 3), ('flat', 0)):
        felt = mock.Mock(count=0, points=np.empty((0, 3)))
        supervisor = mock.Mock(impassable=None, wanted_plan=None, felt_ground=felt)
        supervisor.support.margin_at.return_value = 0.05
        supervisor.in_contact_at.return_value = np.array(ALL)
        node = Node(readers=0)
        topics = GaitTopics(node, supervisor, GaitParameters(ground=ground))
        for k in range(12):
            felt.count = k // 3
            felt.points = np.arange(3.0 * felt.count).reshape(-1, 3)
            state = mock.Mock(time=0.02 * k, pose=Pose2D(0.0, 0.0, 0.0))
            state.stability_margin.return_value = 0.04
            topics.publish_decision(None, state, 'map', Time())
        published = node.published.get('height_map/felt', [])
        assert len(published) == count
        for number, message in enumerate(published, 1):
            assert (message.height, message.width) == (1, number)
            cloud = np.frombuffer(bytes(message.data), '<f4').reshape(-1, 3)
            assert np.array_equal(cloud, np.arange(3.0 * number).reshape(-1, 3))
            assert message.header.frame_id == 'map'
