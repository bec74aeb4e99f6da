"""Transforms between frames are composed along their tree; what is no turn in the plane is not."""

import math
from itertools import pairwise

import pytest

from quad_common.errors import InvalidTransform
from quad_common.frames.frame_tree import MOST_FRAMES, FrameTransform, FrameTree
from quad_common.planar_pose import Pose2D

LEVEL = (0.0, 0.0, 0.0, 1.0)


def transform(parent, child, pose, is_static=False):
    half = pose.yaw / 2.0
    rotation = (0.0, 0.0, math.sin(half), math.cos(half))
    return FrameTransform(parent, child, (pose.x, pose.y, 0.3), rotation, is_static)


def tree(*transforms):
    made = FrameTree()
    for one in transforms:
        made.add(one)
    return made


def assert_same(pose, expected):
    assert pose.distance_to(expected) < 1e-12
    assert math.isclose(pose.yaw, expected.yaw, abs_tol=1e-12)


A, B, C = Pose2D(1.0, 2.0, 0.7), Pose2D(-3.0, 0.5, -2.0), Pose2D(0.1, 4.0, 1.0)


def test_a_chain_is_the_product_of_its_links():
    found = tree(transform('map', 'a', A), transform('a', 'b', B), transform('b', 'odom', C)).find(
        'map', 'odom'
    )
    assert_same(found.pose, A @ B @ C)


def test_frames_of_one_parent_are_related_through_it():
    found = tree(transform('earth', 'map', A), transform('earth', 'odom', B)).find('map', 'odom')
    assert_same(found.pose, A.inverse() @ B)


def test_a_transform_published_the_other_way_round_is_undone():
    found = tree(transform('odom', 'map', A)).find('map', 'odom')
    assert_same(found.pose, A.inverse())


def test_frames_without_a_chain_between_them_are_not_related():
    assert tree(transform('map', 'a', A)).find('map', 'odom') is None


@pytest.mark.parametrize('child', ['map', 'a', 'b'])
def test_a_transform_that_closes_a_cycle_is_refused_and_all_stays(child):
    frames = tree(transform('map', 'a', A), transform('a', 'b', B), transform('b', 'odom', C))
    for _ in range(3):
        with pytest.raises(InvalidTransform, match=f"'odom' lies below '{child}' already"):
            frames.add(transform('odom', child, A))
    assert_same(frames.find('map', 'odom').pose, A @ B @ C)
    assert frames.find('map', 'moon') is None
    with pytest.raises(InvalidTransform, match="'a' lies below 'a'"):
        frames.add(transform('a', 'a', A))


def contradict(frames, times, is_static=False):
    """Say again and again that the map is below odometry; return the times when it was taken."""
    taken = []
    for time in times:
        try:
            frames.add(transform('odom', 'map', B, is_static), time)
        except InvalidTransform:
            continue
        taken.append(time)
    return taken


def test_another_root_takes_over_from_what_does_not_come_any_more():
    frames = tree(transform('map', 'odom', A))
    # However long ago that was: one transform alone proves nothing.
    assert contradict(frames, [1000.0]) == []
    assert contradict(frames, [1004.0, 1006.0, 1007.0]) == [1006.0, 1007.0]
    assert_same(frames.find('map', 'odom').pose, B.inverse())


def test_another_root_takes_over_from_nothing_that_still_comes_or_holds_for_good():
    frames = FrameTree()
    for time in range(100):
        frames.add(transform('map', 'odom', A), float(time))
        assert contradict(frames, [time + 0.1, time + 0.9]) == []
    frames.add(transform('map', 'odom', A, is_static=True), 100.0)
    assert contradict(frames, range(100, 200), is_static=True) == []


def test_in_a_chain_what_has_not_come_for_longest_gives_way():
    frames = tree(transform('map', 'a', A), transform('a', 'odom', B))
    assert contradict(frames, [0.0]) == []
    frames.add(transform('a', 'odom', B), 1.0)
    assert contradict(frames, [6.0]) == [6.0]
    assert_same(frames.find('a', 'map').pose, B @ B)


def test_a_clock_that_is_set_back_lets_another_root_wait_no_longer():
    frames = tree(transform('map', 'odom', A))
    assert contradict(frames, [1000.0, 3.0]) == [3.0]


def test_links_have_a_place_but_no_pose_until_they_are_forgotten():
    frames = tree(transform('map', 'odom', A))
    rolled = FrameTransform('odom', 'base_link', (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    frames.add_link(rolled)
    assert frames.is_link('base_link')
    assert frames.holds_link('odom', 'base_link')
    assert not frames.is_link('odom')
    assert frames.is_above('map', 'base_link')
    assert frames.find('map', 'base_link') is None
    with pytest.raises(InvalidTransform, match='already'):
        frames.add(transform('base_link', 'odom', A), 0.0)
    assert not frames.holds_link('odom', 'base_link')
    # It comes again: the contradiction counts anew.
    frames.add_link(rolled, 1.0)
    with pytest.raises(InvalidTransform, match='already'):
        frames.add(transform('base_link', 'odom', A), 6.0)
    frames.forget_links()
    assert not frames.is_link('base_link')
    frames.add(transform('base_link', 'odom', A), 6.0)


def test_a_chain_holds_for_good_if_all_its_links_do():
    first = transform('map', 'a', A, is_static=True)
    assert tree(first, transform('a', 'odom', B, is_static=True)).find('map', 'odom').is_static
    assert not tree(first, transform('a', 'odom', B)).find('map', 'odom').is_static


@pytest.mark.parametrize(
    ('translation', 'rotation', 'words'),
    [
        ((math.nan, 0.0, 0.0), LEVEL, 'not finite'),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, math.inf), 'not finite'),
        ((2e6, 0.0, 0.0), LEVEL, '1e+06 m are the most'),
        ((0.0, 0.0, -1e308), LEVEL, '1e+06 m are the most'),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0), 'length 0;'),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 1e200, 1e200), 'it must be 1'),
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 'tilted by 180.0 degrees'),
        ((0.0, 0.0, 0.0), (0.0, math.sin(0.15), 0.0, math.cos(0.15)), 'tilted by 17.2 degrees'),
    ],
)
def test_what_is_no_pose_in_the_plane_is_refused_and_the_last_one_stays(
    translation, rotation, words
):
    frames = tree(transform('map', 'odom', A))
    with pytest.raises(InvalidTransform, match="'map' to 'odom'") as refused:
        frames.add(FrameTransform('map', 'odom', translation, rotation))
    assert words in str(refused.value)
    assert_same(frames.find('map', 'odom').pose, A)


def test_the_number_of_frames_is_bounded_and_there_is_always_room_for_one_that_is_needed():
    frames = tree(transform('map', 'dock', C, is_static=True), transform('map', 'odom', A))
    frames.needed = ('map', 'odom')
    for index in range(3 * MOST_FRAMES):
        frames.add(transform('world', f'frame {index}', A))
    known = [index for index in range(3 * MOST_FRAMES) if frames.find('world', f'frame {index}')]
    # Those that came last, beside the dock, which is not published again, and odometry.
    assert known == list(range(2 * MOST_FRAMES + 2, 3 * MOST_FRAMES))
    assert_same(frames.find('map', 'odom').pose, A)
    assert_same(frames.find('map', 'dock').pose, C)


def test_of_static_frames_too_those_that_are_needed_stay():
    frames = tree(transform('map', 'a', A, is_static=True), transform('a', 'odom', B))
    frames.needed = ('map', 'odom')
    for index in range(2 * MOST_FRAMES):
        frames.add(transform('world', f'frame {index}', A, is_static=True))
    assert_same(frames.find('map', 'odom').pose, A @ B)
    assert frames.find('world', f'frame {MOST_FRAMES}') is None


def test_a_frame_is_refused_where_all_that_are_known_are_needed():
    names = [f'frame {index}' for index in range(MOST_FRAMES + 1)]
    frames = tree(*(transform(*pair, A) for pair in pairwise(names)))
    frames.needed = (names[-1],)
    with pytest.raises(InvalidTransform, match=f'{MOST_FRAMES} frames are known'):
        frames.add(transform('map', 'one more', A))
