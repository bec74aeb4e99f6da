"""What the gait says of ground without footing reaches the planning session."""

from unittest import mock

import pytest

pytest.importorskip('geometry_msgs')

from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Header

from quad_common.errors import QuadError
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_message
from quad_planner.planner_topics import GaitTopics


def subscribed():
    """Return the session, and what a message on the topic calls."""
    callbacks = {}

    def subscribe(kind, topic, callback, qos, **options):
        callbacks[topic] = callback

    session = mock.Mock()
    GaitTopics(mock.Mock(create_subscription=subscribe), session)
    return session, callbacks['plan/impassable']


def test_pose_and_frame_are_handed_on():
    session, receive = subscribed()
    pose = Pose2D(1.0, 2.0, 0.5)
    receive(PoseStamped(header=Header(frame_id='odom'), pose=pose_message(pose)))
    frame, place = session.take_impassable.call_args.args
    assert frame == 'odom'
    assert place.distance_to(pose) < 1e-9
    assert place.yaw == pytest.approx(pose.yaw)


def test_what_is_no_pose_is_refused():
    session, receive = subscribed()
    message = PoseStamped(pose=pose_message(Pose2D(1.0, 2.0, 0.5)))
    message.pose.orientation.w = float('nan')
    with pytest.raises(QuadError, match='pose without footing'):
        receive(message)
    assert not session.take_impassable.called
