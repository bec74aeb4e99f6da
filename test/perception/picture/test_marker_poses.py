"""The robot's and the goal's pose follow from their discs, or one sentence says why not."""

import math
from functools import cache

import numpy as np
import pytest
from pictures import Obstacle, disc, disturbed, goal_plates, paint, robot_plates

from quad_common.errors import (
    MarkerHidden,
    MarkerNotSeen,
    ParameterError,
    PictureUnusable,
    SeveralMarkers,
)
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.vision.camera import CameraModel
from quad_common.vision.markers import GoalMarker, RobotMarker
from quad_perception.picture.marker_poses import DiscOnMarker, MarkerShape
from quad_perception.picture.perception import Perceiver
from quad_perception.picture.scene_model import SceneModel

ROBOT, GOAL = RobotMarker(), GoalMarker()
CAMERAS = [
    CameraModel.looking_down(
        (0.0, 0.0, 6.0), yaw, 2.0 * math.atan(4.2 / 6.0), distortion=(k1, 0.0, 0.0, 0.0, 0.0)
    )
    for yaw, k1 in ((0.0, 0.0), (2.0, -0.1))
]
CAMERA = CAMERAS[0]


@cache
def perceiver_of(which=0):
    """Make the perceiver of a camera; its table takes about a second."""
    return Perceiver(CAMERAS[which], resolution=0.1)


def room(robots=(), goals=(), camera=CAMERA, obstacles=(), **options):
    return paint(
        camera,
        obstacles,
        [plate for pose in robots for plate in robot_plates(pose, ROBOT, **options)],
        floor=(205, 205, 200),
        color=(205, 50, 35),
        below=[plate for pose in goals for plate in goal_plates(pose, GOAL)],
    )


def poses(count, seed=0):
    rng = np.random.default_rng(seed)
    drawn = rng.uniform((-2.7, -2.7, -math.pi), (2.7, 2.7, math.pi), (count, 3))
    return [Pose2D(*(float(number) for number in row)) for row in drawn]


def errors(found, pose):
    return (
        math.hypot(found.pose.x - pose.x, found.pose.y - pose.y),
        abs(wrap_angle(found.pose.yaw - pose.yaw)),
    )


@pytest.mark.parametrize('which', [0, 1])
def test_the_robot_is_found_anywhere_in_any_light(which):
    rng = np.random.default_rng(3)
    found = []
    for pose in poses(12):
        picture = room([pose], camera=CAMERAS[which])
        picture = disturbed(picture, rng, float(rng.uniform(0.7, 1.3)))
        seen = perceiver_of(which).perceive(picture)
        assert seen.robot_problem is None
        found.append(errors(seen.robot, pose))
    distance, turn = np.sqrt(np.mean(np.square(found), axis=0))
    assert distance < 0.01
    assert turn < math.radians(1.0)


@pytest.mark.parametrize('which', [0, 1])
def test_the_goal_is_found_with_its_heading(which):
    for pose in poses(6, seed=1):
        seen = perceiver_of(which).perceive(room(goals=[pose], camera=CAMERAS[which]))
        distance, turn = errors(seen.goal, pose)
        assert distance < 0.01
        assert turn < math.radians(1.5)


def test_the_covariance_covers_a_body_that_bobs():
    shape = MarkerShape.of_robot(ROBOT, base_height=0.24, height_deviation=0.02)
    perceiver = Perceiver(CAMERA, SceneModel(robot=shape), resolution=0.1)
    pose = Pose2D(2.5, 0.0, 0.3)
    squares = []
    for height in np.linspace(0.2, 0.28, 9):
        found = perceiver.perceive(room([pose], base_height=float(height))).robot
        squares.append((found.pose.x - pose.x) ** 2)
        covariance = found.covariance
    assert np.allclose(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > 0.0
    # Towards the camera and away from it a height shows most.
    assert covariance[0, 0] > 1.5 * covariance[1, 1]
    assert 0.3 * covariance[0, 0] < np.mean(squares) < 3.0 * covariance[0, 0]


def test_a_robot_or_a_goal_that_is_not_there_is_said():
    seen = perceiver_of().perceive(room())
    assert seen.robot is None
    assert seen.goal is None
    assert isinstance(seen.robot_problem, MarkerNotSeen)
    assert isinstance(seen.goal_problem, MarkerNotSeen)
    assert str(seen.goal_problem) == (
        'the goal is not seen: there is no disc of the colors goal, goal_heading in the picture'
    )


def test_two_goals_are_one_too_many():
    places = [Pose2D(1.0, 1.0, 0.0), Pose2D(-1.0, 0.5, 1.0)]
    seen = perceiver_of().perceive(room(goals=places))
    assert seen.goal is None
    assert isinstance(seen.goal_problem, SeveralMarkers)
    assert sorted(seen.goal_problem.places) == [
        pytest.approx((-1.0, 0.5), abs=0.02),
        pytest.approx((1.0, 1.0), abs=0.02),
    ]
    assert 'seen 2 times' in str(seen.goal_problem)


def test_a_half_hidden_goal_is_no_goal():
    goal = Pose2D(1.0, 1.0, 0.0)
    plates = [*goal_plates(goal, GOAL), (disc(1.1, 1.1, 0.17), 0.01, (90, 90, 90))]
    seen = perceiver_of().perceive(paint(CAMERA, [], plates))
    assert isinstance(seen.goal_problem, MarkerHidden)
    assert 0.1 < seen.goal_problem.seen < 0.8
    assert "the goal's disc 'goal'" in str(seen.goal_problem)


def test_a_goal_behind_an_obstacle_is_hidden():
    goal = Pose2D(2.35, 0.0, math.pi / 2.0)
    before = Obstacle(1.9, 0.0, 1.0, 0.5, 0.5)
    seen = perceiver_of().perceive(room(goals=[goal], obstacles=[before]))
    assert isinstance(seen.goal_problem, MarkerHidden | MarkerNotSeen)


def test_a_marker_of_which_one_disc_is_seen_is_hidden():
    one = goal_plates(Pose2D(1.0, 1.0, 0.0), GOAL)[:1]
    seen = perceiver_of().perceive(paint(CAMERA, [], one))
    assert isinstance(seen.goal_problem, MarkerHidden)
    assert "'goal_heading' only 0 %" in str(seen.goal_problem)


def test_a_marker_at_the_border_is_hidden_by_it():
    seen = perceiver_of().perceive(room(goals=[Pose2D(4.15, 0.0, math.pi / 2.0)]))
    assert isinstance(seen.goal_problem, MarkerHidden)
    assert 'border' in str(seen.goal_problem)


def test_discs_that_are_too_far_apart_are_no_marker():
    plates = [
        (disc(0.0, 1.0, GOAL.radius), 0.0, GOAL.color),
        (disc(1.0, 1.0, GOAL.heading_radius), 0.0, GOAL.heading_color),
    ]
    seen = perceiver_of().perceive(paint(CAMERA, [], plates))
    assert isinstance(seen.goal_problem, MarkerHidden)
    assert '0.30 m from each other' in str(seen.goal_problem)


def test_specks_of_a_markers_color_change_nothing():
    pose = Pose2D(1.0, -1.0, 0.5)
    picture = room(goals=[pose])
    rng = np.random.default_rng(0)
    for row, column in rng.integers(10, 600, (40, 2)):
        picture[row : row + 2, column : column + 2] = GOAL.color
    assert errors(perceiver_of().perceive(picture).goal, pose)[0] < 0.02


@pytest.mark.parametrize(('value', 'said'), [(0, 'black'), (12, 'black'), (255, 'overexposed')])
def test_pictures_that_show_nothing_are_said(value, said):
    with pytest.raises(PictureUnusable, match=said):
        perceiver_of().perceive(np.full((640, 640, 3), value, np.uint8))


def test_a_picture_of_another_size_is_refused():
    with pytest.raises(ParameterError, match='320 x 240 pixels'):
        perceiver_of().perceive(np.full((240, 320, 3), 128, np.uint8))


@pytest.mark.parametrize(
    'options',
    [
        {'rear': DiscOnMarker('a', 1.0, 0.1)},
        {'front': DiscOnMarker('b', 0.5, 0.0)},
        {'height': -0.1},
        {'height_deviation': math.nan},
    ],
)
def test_markers_that_are_none_are_refused(options):
    given = {
        'what': 'goal',
        'rear': DiscOnMarker('a', 0.0, 0.1),
        'front': DiscOnMarker('b', 0.3, 0.1),
        'height': 0.0,
    }
    with pytest.raises(ParameterError):
        MarkerShape(**{**given, **options})
