"""Transforms go over the global topics of tf2, in whatever namespace a node is."""

from __future__ import annotations

from unittest.mock import MagicMock

import pytest

pytest.importorskip('rclpy')

from quad_common.frames.map_frame import MapFrame
from quad_common.ros import map_frame_listener, transform_publisher


def test_a_node_hears_the_global_transforms(monkeypatch):
    monkeypatch.setattr(map_frame_listener, 'TFMessage', MagicMock())
    node = MagicMock()
    map_frame_listener.MapFrameListener(node, MapFrame(), 5.0)
    topics = [call.args[1] for call in node.create_subscription.call_args_list]
    assert topics == ['/tf', '/tf_static', 'map_to_odom']


def test_a_node_publishes_the_global_transforms(monkeypatch):
    monkeypatch.setattr(transform_publisher, 'TFMessage', MagicMock())
    node = MagicMock()
    assert transform_publisher.TransformPublisher(node, is_wanted=True).is_active
    topics = {call.args[1] for call in node.create_publisher.call_args_list}
    assert topics == {'/tf', '/tf_static'}
