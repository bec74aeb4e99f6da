"""Camera and leg odometry together know where the robot is, though one drifts and one is late."""

import math
from contextlib import suppress

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_perception.tracking.pose_fusion import (
    FusionOptions,
    PictureTooOld,
    PoseFusion,
    PoseRefused,
)

MAP_TO_ODOM = Pose2D(2.0, -1.0, 0.7)
CAMERA = np.diag([0.01, 0.01, 0.02]) ** 2


def walk(duration, rate=50.0, speed=0.1, turn_rate=0.1):
    """Yield times and true poses of a robot on a circle, in the odometry's frame."""
    for k in range(round(duration * rate) + 1):
        t = k / rate
        yaw = turn_rate * t
        radius = speed / turn_rate
        yield t, Pose2D(radius * math.sin(yaw), radius * (1.0 - math.cos(yaw)), wrap_angle(yaw))


def seen(pose, rng, noise=CAMERA):
    """What a camera says of a pose on the map."""
    dx, dy, dyaw = rng.multivariate_normal(np.zeros(3), noise)
    return Pose2D(pose.x + dx, pose.y + dy, wrap_angle(pose.yaw + dyaw))


def test_before_a_picture_nothing_is_known():
    fusion = PoseFusion()
    fusion.add_odometry(0.0, Pose2D(0.0, 0.0, 0.0))
    assert fusion.pose is None
    assert fusion.correction is None
    assert fusion.age(10.0) == math.inf


def test_perfect_measurements_give_the_transform():
    fusion = PoseFusion()
    for t, pose in walk(20.0):
        fusion.add_odometry(t, pose)
        if round(t * 50) % 25 == 0:
            fusion.add_picture(t, MAP_TO_ODOM @ pose, CAMERA)
    for field in ('x', 'y', 'yaw'):
        assert getattr(fusion.correction, field) == pytest.approx(getattr(MAP_TO_ODOM, field))
    assert fusion.pose.distance_to(MAP_TO_ODOM @ pose) < 1e-9


def test_a_late_picture_counts_for_its_own_time():
    fusion = PoseFusion()
    poses = list(walk(10.0, speed=0.3))
    pictures = {
        round(t * 50): (t, MAP_TO_ODOM @ pose) for t, pose in poses if round(t * 50) % 25 == 0
    }
    for t, pose in poses:
        fusion.add_odometry(t, pose)
        # Each comes 0.8 s after it was taken, in which the robot walks 24 cm.
        late = pictures.get(round(t * 50) - 40)
        if late is not None:
            fusion.add_picture(*late, CAMERA)
    assert fusion.pose.distance_to(MAP_TO_ODOM @ poses[-1][1]) < 1e-6


@pytest.mark.parametrize('seed', range(5))
def test_drift_and_noise_are_kept_small(seed):
    rng = np.random.default_rng(seed)
    fusion = PoseFusion()
    drift, before, errors = Pose2D(0.0, 0.0, 0.0), None, []
    for t, pose in walk(120.0):
        if before is not None:
            step = before.inverse() @ pose
            # Two percent too far, and a quarter of a degree a metre to the left.
            bend = math.radians(0.25) * math.hypot(step.x, step.y)
            drift = drift @ Pose2D(1.02 * step.x, 1.02 * step.y, wrap_angle(step.yaw + bend))
        before = pose
        fusion.add_odometry(t, drift)
        if round(t * 50) % 25 == 0:
            fusion.add_picture(t, seen(MAP_TO_ODOM @ pose, rng), CAMERA)
        if t > 5.0:
            errors.append(fusion.pose.distance_to(MAP_TO_ODOM @ pose))
    # Better than the camera alone, at any time between its pictures too.
    assert np.sqrt(np.mean(np.square(errors))) < 0.01
    assert max(errors) < 0.03


def test_the_covariance_says_how_large_errors_are():
    squared = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        fusion = PoseFusion(FusionOptions(slip=0.03, turning_slip=0.03))
        pose, odometry = Pose2D(0.0, 0.0, 0.0), Pose2D(0.0, 0.0, 0.0)
        for k in range(400):
            pose = pose @ Pose2D(0.01, 0.0, 0.002)
            noise = rng.normal(size=3) * [0.03 * 0.1, 0.03 * 0.1, 0.03 * math.sqrt(0.012)]
            odometry = odometry @ Pose2D(0.01 + noise[0], noise[1], 0.002 + noise[2])
            fusion.add_odometry(0.1 * k, odometry)
            if k % 10 == 0:
                # One in a thousand is so far off by chance.
                with suppress(PoseRefused):
                    fusion.add_picture(0.1 * k, seen(pose, rng), CAMERA)
        error = np.array(
            [fusion.pose.x - pose.x, fusion.pose.y - pose.y, wrap_angle(fusion.pose.yaw - pose.yaw)]
        )
        squared.append(error @ np.linalg.solve(fusion.covariance, error))
    # Three on average, were the model perfect.
    assert 1.5 < np.mean(squared) < 6.0


def test_between_pictures_the_covariance_grows_with_the_distance():
    fusion = PoseFusion()
    fusion.add_odometry(0.0, Pose2D(0.0, 0.0, 0.0))
    fusion.add_picture(0.0, MAP_TO_ODOM, CAMERA)
    fusion.add_odometry(1.0, Pose2D(0.0, 0.0, 0.0))
    assert np.allclose(fusion.covariance, CAMERA)
    fusion.add_odometry(2.0, Pose2D(1.0, 0.0, 0.0))
    assert np.all(np.diag(fusion.covariance) > np.diag(CAMERA))


def test_an_outlier_is_refused_and_a_robot_that_was_carried_is_found_again():
    fusion = PoseFusion(FusionOptions(patience=3))
    here, there = Pose2D(0.0, 0.0, 0.0), Pose2D(3.0, 1.0, 1.0)
    for k in range(20):
        fusion.add_odometry(0.1 * k, here)
        fusion.add_picture(0.1 * k, here, CAMERA)
    with pytest.raises(PoseRefused, match=r'3\.16 m and 57 degrees'):
        fusion.add_picture(1.9, there, CAMERA)
    assert fusion.pose.distance_to(here) < 1e-9
    for _ in range(2):
        with pytest.raises(PoseRefused):
            fusion.add_picture(1.9, there, CAMERA)
    fusion.add_picture(1.9, there, CAMERA)
    assert fusion.pose.distance_to(there) < 1e-9


def refused(fusion, time, pose):
    """Return whether a picture is refused."""
    try:
        fusion.add_picture(time, pose, CAMERA)
    except PoseRefused:
        return True
    return False


def test_poses_that_contradict_one_another_are_never_believed():
    rng, fusion, here = np.random.default_rng(3), PoseFusion(), Pose2D(2.0, 3.0, 0.5)
    for k in range(200):
        fusion.add_odometry(0.1 * k, Pose2D(0.0, 0.0, 0.0))
        seen = here if k < 5 else Pose2D(*rng.uniform(-4.0, 4.0, 2), here.yaw)
        assert refused(fusion, 0.1 * k, seen) == (k >= 5)
    assert fusion.pose.distance_to(here) < 1e-9


def test_another_robot_that_stands_is_not_believed_while_this_one_walks():
    fusion, other = PoseFusion(), Pose2D(4.0, 1.0, 2.0)
    for k in range(100):
        place = Pose2D(0.02 * k, 0.0, 0.0)
        fusion.add_odometry(0.1 * k, place)
        assert refused(fusion, 0.1 * k, place if k < 5 else other) == (k >= 5)
    assert fusion.pose.distance_to(place) < 1e-9


@pytest.mark.parametrize('speed', [0.0, 0.2])
def test_a_robot_that_was_carried_is_found_though_it_walks_on_and_pictures_differ(speed):
    rng, fusion = np.random.default_rng(4), PoseFusion()
    carried = Pose2D(-2.0, 1.0, 2.5)
    for k in range(12):
        odometry = Pose2D(0.1 * speed * k, 0.0, 0.0)
        fusion.add_odometry(0.1 * k, odometry)
        seen = odometry if k < 5 else carried @ odometry
        x, y, yaw = rng.multivariate_normal([seen.x, seen.y, seen.yaw], CAMERA)
        assert refused(fusion, 0.1 * k, Pose2D(x, y, yaw)) == (5 <= k < 10)
    assert fusion.pose.distance_to(carried @ odometry) < 0.05


@pytest.mark.parametrize('period', [0.1, 1.0, 3.0, 5.0])
def test_a_robot_is_found_again_though_its_odometry_errs_and_pictures_are_rare(period):
    # Odometry tells a tenth too much; for 10 m there is no picture.
    fusion, refusals, last = PoseFusion(), 0, -math.inf
    for k in range(4000):
        time, walked = 0.05 * k, 0.01 * k
        fusion.add_odometry(time, Pose2D(1.1 * walked, 0.0, 0.0))
        is_seen = time < 1.0 or (walked > 10.0 and time - last >= period - 1e-9)
        if is_seen:
            last = time
            refusals += refused(fusion, time, Pose2D(walked, 0.0, 0.0))
    assert refusals <= 8
    assert abs(fusion.pose.x - walked) < 0.15


@pytest.mark.parametrize('stamp', [0.5, 20.0])
def test_a_picture_from_another_time_is_refused(stamp):
    fusion = PoseFusion()
    for t, pose in walk(10.0):
        fusion.add_odometry(t, pose)
    with pytest.raises(PictureTooOld, match=r'from 5\.00 s to 10\.00 s'):
        fusion.add_picture(stamp, MAP_TO_ODOM, CAMERA)


def test_a_clock_that_is_set_back_begins_anew():
    fusion = PoseFusion()
    fusion.add_odometry(5.0, Pose2D(0.0, 0.0, 0.0))
    fusion.add_picture(5.0, MAP_TO_ODOM, CAMERA)
    fusion.add_odometry(0.0, Pose2D(0.0, 0.0, 0.0))
    assert fusion.pose is None


def test_the_age_is_that_of_the_last_picture_that_was_believed():
    fusion = PoseFusion()
    fusion.add_odometry(1.0, Pose2D(0.0, 0.0, 0.0))
    fusion.add_picture(1.0, MAP_TO_ODOM, CAMERA)
    with pytest.raises(PoseRefused):
        fusion.add_picture(1.2, Pose2D(9.0, 9.0, 0.0), CAMERA)
    assert fusion.age(3.5) == pytest.approx(2.5)


@pytest.mark.parametrize('name', ['slip', 'turning_slip', 'memory', 'patience'])
def test_options_must_be_positive(name):
    with pytest.raises(ParameterError, match=name):
        FusionOptions(**{name: 0})
