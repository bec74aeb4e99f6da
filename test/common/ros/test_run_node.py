"""What a node runs with."""

import gc
import weakref

import pytest

pytest.importorskip('rclpy')

from quad_common.errors import ArgumentNotText
from quad_common.ros.run_node import check_text, keep_for_good


class Node:
    """Something that refers to itself."""

    def __init__(self):
        self.itself = self


def test_what_is_there_at_the_start_is_not_looked_through_and_later_garbage_is_collected():
    kept = Node()
    try:
        keep_for_good()
        assert gc.get_freeze_count() > 1000
        assert not any(known is kept for known in gc.get_objects())
        later = Node()
        gone = weakref.ref(later)
        del later
        gc.collect()
        assert gone() is None
    finally:
        gc.unfreeze()


def test_an_argument_that_is_not_text_is_refused_in_a_sentence():
    check_text(['--ros-args', '-p', 'gait:=ä☃'])
    with pytest.raises(ArgumentNotText, match=r"the argument 'gait:=a\\udcff' is not valid UTF-8"):
        check_text(['--ros-args', '-p', b'gait:=a\xff'.decode(errors='surrogateescape')])
