"""One robot of a fleet is recorded so that it plays by itself: all of its frames are joined."""

from __future__ import annotations

import pytest

pytest.importorskip('rosbags')
pytest.importorskip('rclpy')

from rosbags.rosbag2 import Reader

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_lab.recordings.recorder import NothingToRecord, Recorder
from quad_lab.recordings.shared_transforms import transforms_in
from quad_lab.topic_walk.fleet import FleetOptions, FleetRobot, start_fleet
from quad_lab.topic_walk.node_processes import isolated_domain

pytestmark = pytest.mark.ros

FEW = 20

MOST_LOOKS = 300
"""Each takes a tenth of a second."""

LEFT, RIGHT = Pose2D(1.2, 1.2, 0.0), Pose2D(1.2, 2.6, 0.0)


def recorder_of(folder, name, nodes):
    """Begin to record once the simulator is there."""
    for _ in range(FEW):
        try:
            return Recorder(folder, name)
        except NothingToRecord:
            nodes.check()
    raise AssertionError('no topics')


def test_all_frames_of_a_robot_of_a_fleet_lead_to_the_map(tmp_path):
    fleet = FleetOptions(
        sample_map(),
        {'robot1': FleetRobot('a1', LEFT, LEFT), 'robot2': FleetRobot('a1', RIGHT, RIGHT)},
        backend='kinematic',
    )
    with (
        isolated_domain(),
        start_fleet(fleet) as nodes,
        recorder_of(tmp_path / 'bag', 'robot2', nodes) as recorder,
    ):
        for _ in range(MOST_LOOKS):
            recorder.listen(0.1)
            nodes.check()
            if recorder.recording.counts.get('/robot2/odom', 0) >= FEW:
                break
    assert recorder.recording.counts['/robot2/odom'] >= FEW
    parents = {}
    with Reader(tmp_path / 'bag') as reader:
        for connection, _, data in reader.messages():
            if connection.msgtype == 'tf2_msgs/msg/TFMessage':
                for part in transforms_in(bytes(data)):
                    parents[part.child_frame_id] = part.header.frame_id
    assert {'robot2/odom', 'robot2/base_link'} <= set(parents)
    assert len(parents) > 12
    assert all(frame.startswith('robot2/') for frame in parents)
    assert {parent for parent in parents.values() if parent not in parents} == {'map'}
