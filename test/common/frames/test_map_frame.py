"""The robot's place on the map is odometry's, corrected as localisers say, without nonsense."""

import math

import numpy as np
import pytest

from quad_common.errors import InvalidTransform, WrongFrame
from quad_common.frames.frame_tree import MOST_FRAMES, FrameTransform
from quad_common.frames.map_frame import MapFrame
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D

ORIGIN = Pose2D(0.0, 0.0, 0.0)
HERE = Pose2D(3.0, -1.0, 0.5)
CORRECTION = Pose2D(0.4, 0.2, 0.3)


def transform(pose, parent='map', child='odom', is_static=False):
    half = pose.yaw / 2.0
    rotation = (0.0, 0.0, math.sin(half), math.cos(half))
    return FrameTransform(parent, child, (pose.x, pose.y, 0.0), rotation, is_static)


def apart(a, b):
    return a.distance_to(b) + abs(a.yaw - b.yaw)


def test_without_a_localiser_the_frames_coincide_to_the_last_bit():
    frame = MapFrame()
    assert frame.locate(0.0, 'odom', HERE) is HERE
    assert frame.correction is None
    assert frame.frames_on_map == ('map', 'odom')
    frame.add([transform(ORIGIN, is_static=True)])
    assert frame.locate(1.0, 'odom', HERE) is HERE
    assert frame.frames_on_map == ('map', 'odom')


def test_the_first_correction_is_taken_whole_and_said():
    frame = MapFrame()
    frame.add([transform(CORRECTION)])
    assert apart(frame.locate(0.0, 'odom', HERE), CORRECTION @ HERE) < 1e-12
    [remark] = frame.take_remarks()
    assert "'map' -> 'odom' is published" in remark
    assert frame.take_remarks() == []
    assert frame.frames_on_map == ('map',)


def test_odometry_moves_the_robot_between_corrections():
    frame = MapFrame()
    frame.add([transform(CORRECTION)])
    frame.locate(0.0, 'odom', ORIGIN)
    assert apart(frame.locate(0.5, 'odom', HERE), CORRECTION @ HERE) < 1e-12


def test_odometry_in_the_map_itself_is_not_corrected():
    frame = MapFrame()
    frame.add([transform(CORRECTION), transform(CORRECTION, 'map', 'camera')])
    assert frame.locate(0.0, 'map', HERE) is HERE
    assert frame.is_in_map


def test_a_correction_moves_the_pose_by_a_share_of_its_time_constant():
    frame = MapFrame(time_constant=2.0)
    for second in range(20):
        frame.add([transform(ORIGIN)])
        frame.locate(float(second), 'odom', HERE)
    frame.add([transform(Pose2D(0.1, 0.0, 0.0))])
    moved = frame.locate(20.0, 'odom', HERE).distance_to(HERE)
    assert moved == pytest.approx(0.1 * (1.0 - math.exp(-0.5)))


def test_a_correction_counts_once_however_much_odometry_follows_it():
    frame = MapFrame()
    for second in range(5):
        frame.add([transform(ORIGIN)])
        frame.locate(float(second), 'odom', HERE)
    frame.add([transform(Pose2D(0.1, 0.0, 0.0))])
    once = frame.locate(5.0, 'odom', HERE)
    for step in range(100):
        frame.add([transform(HERE, 'map', 'somewhere else')])
        assert frame.locate(5.02 + 0.02 * step, 'odom', HERE) == once


def test_noise_of_corrections_is_filtered_as_stated_however_far_odometry_has_come():
    rng = np.random.default_rng(1)
    odometry = Pose2D(400.0, -300.0, 2.0)
    frame, errors = MapFrame(time_constant=3.0), []
    for second in range(3000):
        noise = Pose2D(*rng.normal(0.0, (0.02, 0.02, 0.01)).tolist())
        frame.add([transform(odometry @ noise @ odometry.inverse())])
        errors.append(frame.locate(float(second), 'odom', odometry).distance_to(odometry))
    fraction = 1.0 - math.exp(-1.0 / 3.0)
    expected = 0.02 * math.sqrt(2.0) * math.sqrt(fraction / (2.0 - fraction))
    assert np.sqrt(np.mean(np.square(errors[20:]))) == pytest.approx(expected, rel=0.1)


def test_the_first_corrections_are_averaged():
    frame = MapFrame(time_constant=1000.0)
    for x in (0.0, 0.1, 0.2):
        frame.add([transform(Pose2D(x, 0.0, 0.0))])
        pose = frame.locate(x, 'odom', ORIGIN)
    assert pose.x == pytest.approx(0.1)


@pytest.mark.parametrize('leap', [Pose2D(0.3, 0.0, 0.0), Pose2D(0.0, 0.0, 0.4)])
def test_a_relocalisation_is_taken_whole_and_said(leap):
    frame = MapFrame(time_constant=60.0)
    for second in range(10):
        frame.add([transform(ORIGIN)])
        frame.locate(float(second), 'odom', ORIGIN)
    frame.take_remarks()
    frame.add([transform(leap)])
    assert apart(frame.locate(10.0, 'odom', ORIGIN), leap) < 1e-12
    [remark] = frame.take_remarks()
    assert remark.startswith('localisation moved the robot by 0.')


def test_a_localiser_that_leaps_all_the_time_is_not_told_of_all_the_time():
    frame = MapFrame()
    for step in range(100):
        frame.add([transform(Pose2D(float(step % 2), 0.0, 0.0))])
        frame.locate(0.02 * step, 'odom', ORIGIN)
    assert len(frame.take_remarks()) <= 3


def test_corrections_grow_old_while_odometry_goes_on():
    frame = MapFrame()
    frame.locate(0.0, 'odom', ORIGIN)
    assert frame.age == 0.0
    frame.add([transform(CORRECTION)])
    frame.locate(1.0, 'odom', ORIGIN)
    pose = frame.locate(7.0, 'odom', ORIGIN)
    assert frame.age == pytest.approx(6.0)
    assert apart(pose, CORRECTION) < 1e-12
    frame.add([transform(CORRECTION)])
    frame.locate(7.1, 'odom', ORIGIN)
    assert frame.age == 0.0


def test_a_correction_for_good_does_not_grow_old():
    frame = MapFrame()
    frame.add([transform(CORRECTION, is_static=True)])
    frame.locate(0.0, 'odom', ORIGIN)
    frame.locate(1000.0, 'odom', ORIGIN)
    assert frame.age == 0.0


def test_a_clock_that_is_set_back_does_not_make_corrections_old_or_odd():
    frame = MapFrame()
    frame.add([transform(CORRECTION)])
    frame.locate(1000.0, 'odom', ORIGIN)
    frame.add([transform(CORRECTION)])
    assert apart(frame.locate(0.0, 'odom', ORIGIN), CORRECTION) < 1e-12
    assert frame.age == 0.0


def test_links_of_the_robot_need_not_be_in_the_plane():
    frame = MapFrame()
    rolled = FrameTransform('base_link', 'calf', (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    frame.add([rolled])
    frame.locate(0.0, 'odom', ORIGIN)
    frame.add([transform(HERE, 'odom', 'base_link'), rolled])


def test_nonsense_between_map_and_odometry_is_refused_and_the_last_correction_stays():
    frame = MapFrame()
    frame.add([transform(CORRECTION, 'map', 'a'), transform(ORIGIN, 'a', 'odom')])
    frame.locate(0.0, 'odom', ORIGIN)
    for child in ('a', 'odom', 'map'):
        with pytest.raises(InvalidTransform):
            frame.add([FrameTransform('b', child, (math.nan, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))])
    assert apart(frame.locate(0.1, 'odom', ORIGIN), CORRECTION) < 1e-12


@pytest.mark.parametrize(
    ('parent', 'child'),
    [
        ('odom', 'map'),
        ('odom', 'world'),
        ('base_link', 'odom'),
        ('base_link', 'world'),
        ('lidar', 'odom'),
        ('lidar', 'map'),
    ],
)
def test_a_transform_the_wrong_way_round_is_refused_and_the_right_ones_go_on(parent, child):
    frame = MapFrame(time_constant=0.0)
    frame.locate(0.0, 'odom', HERE)
    links = [transform(HERE, 'odom', 'base_link'), transform(HERE, 'base_link', 'lidar', True)]
    for second in range(20):
        x = 0.01 * second
        frame.add([transform(Pose2D(x, 0.0, 0.0), 'map', 'world'), *links])
        frame.add([transform(CORRECTION, 'world', 'odom')])
        pose = frame.locate(float(second), 'odom', HERE)
        assert apart(pose, Pose2D(x, 0.0, 0.0) @ CORRECTION @ HERE) < 1e-12
        if second % 8 == 5:
            with pytest.raises(InvalidTransform, match=f"'{parent}' lies below '{child}' already"):
                frame.add([transform(HERE, parent, child)])
            assert apart(frame.locate(second + 0.1, 'odom', HERE), pose) < 1e-12
    assert len(frame.take_remarks()) == 1


def test_a_localiser_takes_over_from_one_transform_the_wrong_way_round_before_it():
    frame = MapFrame(time_constant=0.0)
    frame.locate(0.0, 'odom', HERE)
    frame.add([transform(HERE, 'odom', 'map')])
    for second in range(10):
        if second <= 6:
            with pytest.raises(InvalidTransform, match="'map' lies below 'odom' already"):
                frame.add([transform(CORRECTION)])
        else:
            frame.add([transform(CORRECTION)])
        pose = frame.locate(float(second), 'odom', HERE)
    assert apart(pose, CORRECTION @ HERE) < 1e-12


def test_a_frame_that_was_taken_for_a_link_may_lie_between_map_and_odometry():
    frame = MapFrame()
    frame.locate(0.0, 'odom', HERE)
    frame.add([transform(HERE, 'odom', 'world')])
    frame.add([transform(CORRECTION, 'map', 'world'), transform(HERE, 'world', 'odom')])
    assert apart(frame.locate(1.0, 'odom', HERE), CORRECTION @ HERE @ HERE) < 1e-12


@pytest.mark.parametrize('is_static', [True, False])
def test_however_many_frames_others_publish_there_is_room_for_the_corrections(is_static):
    frame = MapFrame(time_constant=0.0)
    frame.locate(0.0, 'odom', HERE)
    others = [transform(HERE, 'earth', f'frame {k}', is_static) for k in range(2 * MOST_FRAMES)]
    frame.add(others)
    frame.add([transform(CORRECTION)])
    frame.add([transform(HERE, 'odom', f'link {k}', is_static) for k in range(2 * MOST_FRAMES)])
    frame.add(others)
    assert apart(frame.locate(1.0, 'odom', HERE), CORRECTION @ HERE) < 1e-12


def test_poses_and_plans_come_onto_the_map_from_any_frame_that_is_related_to_it():
    frame = MapFrame()
    frame.add([transform(CORRECTION), transform(HERE, 'map', 'dock')])
    frame.locate(0.0, 'odom', ORIGIN)
    plan = Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0)
    assert frame.plan_on_map('map', plan) is plan
    assert apart(frame.plan_on_map('odom', plan).poses[-1], CORRECTION @ plan.poses[-1]) < 1e-12
    assert apart(frame.plan_on_map('dock', plan).poses[-1], HERE @ plan.poses[-1]) < 1e-12
    with pytest.raises(WrongFrame, match="frame 'moon'"):
        frame.plan_on_map('moon', plan)


def test_another_frame_of_odometry_or_map_begins_anew():
    frame = MapFrame()
    frame.add([transform(CORRECTION)])
    frame.locate(0.0, 'odom', ORIGIN)
    assert frame.locate(0.1, 'odom/legs', HERE) is HERE
    assert apart(frame.locate(0.2, 'odom', ORIGIN), CORRECTION) < 1e-12
    frame.rename('floor')
    assert frame.locate(0.3, 'odom', HERE) is HERE


def leaping(frame, leaps, apart=0.5, since=0.0):
    """Leap once every so many seconds of odometry; return the time of the last leap."""
    for step in range(leaps + 1):
        frame.add([transform(Pose2D(float(step % 2), 0.0, 0.0))])
        frame.locate(since + apart * step, 'odom', ORIGIN)
    return since + apart * leaps


def test_a_robot_that_was_carried_is_believed_at_once():
    frame = MapFrame()
    leaping(frame, 3)
    assert frame.doubt == ''


def test_leaps_that_do_not_end_are_doubted_until_they_do():
    frame = MapFrame()
    last = leaping(frame, 4)
    assert frame.doubt == "'map' -> 'odom' leaps again and again: do two publishers disagree?"
    frame.locate(last + 4.9, 'odom', ORIGIN)
    assert frame.doubt == ''
    leaping(frame, 40, since=last + 5.0)
    assert frame.doubt


def test_leaps_that_are_far_between_are_not_doubted():
    frame = MapFrame()
    leaping(frame, 20, apart=2.0)
    assert frame.doubt == ''


def test_leaps_before_the_clock_was_set_back_do_not_count():
    frame = MapFrame()
    leaping(frame, 4, since=100.0)
    assert frame.doubt
    frame.locate(3.0, 'odom', ORIGIN)
    assert frame.doubt == ''
