"""Transforms that are filled into a message are those that a reader of messages finds in it."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('rosbags')

from rosbags.typesys import Stores, get_typestore

from quad_lab.recordings.transform_pattern import TransformPattern

TYPES = get_typestore(Stores.ROS2_JAZZY)


@pytest.mark.parametrize('seed', range(8))
def test_a_filled_message_holds_what_was_filled_in(seed):
    rng = np.random.default_rng(seed)
    # Names of all lengths: numbers stand at multiples of their size behind them.
    frames = [('p' * rng.integers(1, 9), 'ö' * rng.integers(1, 9)) for _ in range(seed + 1)]
    pattern = TransformPattern(frames)
    for stamp in ((3, 4), (2**31 - 1, 999_999_999)):
        positions, turns = rng.normal(size=(len(frames), 3)), rng.normal(size=(len(frames), 4))
        data = pattern.fill(stamp, positions.tolist(), turns.tolist())
        read = TYPES.deserialize_cdr(data, 'tf2_msgs/msg/TFMessage').transforms
        assert [(t.header.frame_id, t.child_frame_id) for t in read] == frames
        assert {(t.header.stamp.sec, t.header.stamp.nanosec) for t in read} == {stamp}
        found = [(p.x, p.y, p.z) for p in (t.transform.translation for t in read)]
        assert found == [tuple(row) for row in positions]
        found = [(q.x, q.y, q.z, q.w) for q in (t.transform.rotation for t in read)]
        assert found == [tuple(row) for row in turns]


def test_there_are_as_many_places_as_frames():
    with pytest.raises(ValueError, match='shorter'):
        TransformPattern([('a', 'b'), ('b', 'c')]).fill((0, 0), [(0, 0, 0)], [(0, 0, 0, 1)])
