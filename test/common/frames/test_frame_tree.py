"""Transforms between frames are composed along their tree; what is no turn in the plane is not."""

import math

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


def test_a_circle_of_frames_ends():
    circle = tree(transform('map', 'odom', A), transform('odom', 'map', A.inverse()))
    assert circle.find('map', 'odom') is not None
    assert circle.find('map', 'moon') is None


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


def test_the_number_of_frames_is_bounded():
    frames = tree(*(transform('map', f'frame {index}', A) for index in range(MOST_FRAMES)))
    with pytest.raises(InvalidTransform, match=f'{MOST_FRAMES} frames are known'):
        frames.add(transform('map', 'one more', A))
    frames.add(transform('map', 'frame 7', B))
    assert_same(frames.find('map', 'frame 7').pose, B)
