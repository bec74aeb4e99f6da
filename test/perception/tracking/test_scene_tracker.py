"""Picture after picture: the map, the goal and the robot's pose, steadily."""

import gc
import math
import weakref

import numpy as np
import pytest
from pictures import Obstacle, ceiling_camera, goal_plates, paint, robot_plates

from quad_common.errors import MarkerNotSeen, ParameterError, PictureUnusable, SeveralMarkers
from quad_common.planar_pose import Pose2D
from quad_common.vision.markers import GoalMarker, RobotMarker
from quad_perception.picture.perception import Perceiver
from quad_perception.picture.scene_model import SceneModel, default_ranges
from quad_perception.tracking.scene_tracker import SceneTracker, TrackerOptions

CAMERA = ceiling_camera()
PERCEIVER = Perceiver(CAMERA, SceneModel(default_ranges((210, 40, 35))))
BOX = Obstacle(1.5, 1.5, 0.5, 0.6, 0.6)
ROBOT = Pose2D(-1.0, -1.0, 0.4)


def picture(robot=ROBOT, goal=None, obstacles=(BOX,)):
    plates = [] if robot is None else robot_plates(robot, RobotMarker())
    below = [] if goal is None else goal_plates(goal, GoalMarker())
    return paint(CAMERA, obstacles, plates, below=below)


def watch(**options):
    room = SceneTracker(PERCEIVER, TrackerOptions(**options))
    room.add_odometry(0.0, Pose2D(0.0, 0.0, 0.0))
    return room


def cell(grid, x, y):
    column, row = np.floor(grid.world_to_map(np.array([x, y]))).astype(int)
    return int(grid.cells[row, column])


def test_the_first_picture_gives_map_goal_and_pose():
    room = watch()
    assert room.is_lost
    goal = Pose2D(2.0, -2.0, 1.0)
    sighting = room.add_picture(0.0, picture(goal=goal))
    assert sighting.problem is None
    assert cell(sighting.map, 1.5, 1.5) == 100
    assert cell(sighting.map, 0.0, 1.0) == 0
    assert sighting.goal.distance_to(goal) < 0.03
    assert not room.is_lost
    assert room.fusion.pose.distance_to(ROBOT) < 0.03
    assert room.fusion.pose.yaw == pytest.approx(ROBOT.yaw, abs=0.05)


def test_the_robot_is_not_in_the_map_and_stands_on_free_floor():
    room = watch()
    grid = room.add_picture(0.0, picture()).map
    for angle in np.linspace(0.0, 2.0 * math.pi, 12):
        for radius in (0.0, 0.2, 0.4, 0.55):
            x = ROBOT.x + radius * math.cos(angle)
            y = ROBOT.y + radius * math.sin(angle)
            assert cell(grid, x, y) == 0


def test_the_same_room_again_changes_nothing():
    room = watch()
    goal = Pose2D(2.0, -2.0, 1.0)
    room.add_picture(0.0, picture(goal=goal))
    again = room.add_picture(0.0, picture(goal=goal))
    assert again.map is None
    assert again.goal is None


def test_an_obstacle_that_is_put_there_is_in_the_map_when_it_is_confirmed():
    room = watch(confirmations=2)
    room.add_picture(0.0, picture())
    new = (BOX, Obstacle(-2.0, 2.0, 0.4, 0.5, 0.5))
    assert room.add_picture(0.0, picture(obstacles=new)).map is None
    grid = room.add_picture(0.0, picture(obstacles=new)).map
    assert cell(grid, -2.0, 2.0) == 100


def test_a_goal_that_moves_is_new():
    room = watch(goal_distance=0.1)
    room.add_picture(0.0, picture(goal=Pose2D(2.0, -2.0, 1.0)))
    assert room.add_picture(0.0, picture(goal=Pose2D(2.05, -2.0, 1.0))).goal is None
    moved = Pose2D(2.5, -2.0, 1.0)
    assert room.add_picture(0.0, picture(goal=moved)).goal.distance_to(moved) < 0.03


def test_a_robot_that_is_not_seen_is_carried_on_by_its_legs_for_a_while():
    room = watch(largest_age=2.0)
    room.add_picture(0.0, picture())
    room.add_odometry(1.0, Pose2D(0.5, 0.0, 0.0))
    sighting = room.add_picture(1.0, picture(robot=None))
    assert isinstance(sighting.problem, MarkerNotSeen)
    assert not room.is_lost
    ahead = ROBOT @ Pose2D(0.5, 0.0, 0.0)
    assert room.fusion.pose.distance_to(ahead) < 0.04
    room.add_odometry(2.5, Pose2D(0.9, 0.0, 0.0))
    assert room.is_lost
    room.add_picture(2.5, picture(robot=ROBOT @ Pose2D(0.9, 0.0, 0.0)))
    assert not room.is_lost


def test_a_black_picture_is_refused_and_the_map_stays():
    room = watch()
    room.add_picture(0.0, picture())
    before = room.map
    with pytest.raises(PictureUnusable, match='black'):
        room.add_picture(0.1, np.zeros((640, 640, 3), dtype=np.uint8))
    assert room.map is before


def test_a_frozen_picture_is_noticed_when_the_robot_has_walked():
    room = watch()
    still = picture()
    for k in range(5):
        room.add_odometry(0.1 * k, Pose2D(0.0, 0.0, 0.0))
        room.add_picture(0.1 * k, still.copy())
    room.add_odometry(1.0, Pose2D(0.3, 0.0, 0.0))
    with pytest.raises(PictureUnusable, match=r'frozen: .* walked 0\.30 m'):
        room.add_picture(1.0, still.copy())
    room.add_picture(1.0, picture(robot=ROBOT @ Pose2D(0.3, 0.0, 0.0)))
    assert room.fusion.pose.distance_to(ROBOT @ Pose2D(0.3, 0.0, 0.0)) < 0.04


def test_a_frozen_picture_is_noticed_when_the_robot_has_turned():
    room = watch()
    room.add_picture(0.0, picture())
    room.add_odometry(1.0, Pose2D(0.0, 0.0, 0.1))
    with pytest.raises(PictureUnusable, match=r'frozen: .* turned by 6 degrees'):
        room.add_picture(1.0, picture())


def test_a_frozen_picture_leads_nobody_astray():
    # It goes on to show the robot where it was, and is believed until it is noticed.
    room = watch()
    still = picture()
    room.add_picture(0.0, still)
    for k in range(1, 100):
        room.add_odometry(0.1 * k, Pose2D(0.004 * k, 0.0, 0.0))
        try:
            room.add_picture(0.1 * k, still)
        except PictureUnusable:
            break
    else:
        pytest.fail('it was not noticed')
    assert room.fusion.pose.distance_to(ROBOT @ Pose2D(0.004 * k, 0.0, 0.0)) < 0.05


@pytest.mark.parametrize(
    ('spoilt', 'error', 'words'),
    [
        (np.zeros((640, 640, 3), np.uint8), PictureUnusable, 'black'),
        (np.full((640, 640, 3), 255, np.uint8), PictureUnusable, 'overexposed'),
        (np.zeros((480, 640, 3), np.uint8), ParameterError, '640'),
        (np.zeros((640, 640), np.uint8), ParameterError, 'shape'),
    ],
)
def test_bad_pictures_leave_map_goal_and_pose_as_they_are(spoilt, error, words):
    room = watch()
    goal = Pose2D(2.0, -2.0, 1.0)
    room.add_picture(0.0, picture(goal=goal))
    grid, pose = room.map, room.fusion.pose
    for k in range(3):
        with pytest.raises(error, match=words):
            room.add_picture(0.1 * k, spoilt)
    assert room.map is grid
    assert room.fusion.pose == pose
    room.add_odometry(0.4, Pose2D(0.5, 0.0, 0.0))
    with pytest.raises(error, match=words):
        room.add_picture(0.4, spoilt)
    room.add_odometry(0.4, Pose2D(0.0, 0.0, 0.0))
    assert room.add_picture(0.4, picture(goal=goal)).goal is None


def test_of_two_goal_markers_none_is_meant_and_the_last_goal_stays():
    room = watch()
    room.add_picture(0.0, picture(goal=Pose2D(2.0, -2.0, 1.0)))
    both = [*goal_plates(Pose2D(2.0, -2.0, 1.0), GoalMarker())]
    both += goal_plates(Pose2D(-2.0, 2.0, 0.0), GoalMarker())
    two = paint(CAMERA, (BOX,), robot_plates(ROBOT, RobotMarker()), below=both)
    sighting = room.add_picture(0.1, two)
    assert sighting.goal is None
    assert isinstance(sighting.goal_problem, SeveralMarkers)
    again = room.add_picture(0.2, picture(goal=Pose2D(2.0, -2.0, 1.0)))
    assert again.goal is None
    assert again.goal_problem is None


def test_of_two_robots_none_is_believed():
    room = watch()
    room.add_picture(0.0, picture())
    plates = robot_plates(ROBOT, RobotMarker()) + robot_plates(
        Pose2D(2.0, -1.0, 0.0), RobotMarker()
    )
    sighting = room.add_picture(0.1, paint(CAMERA, (BOX,), plates))
    assert isinstance(sighting.problem, SeveralMarkers)
    assert room.fusion.pose.distance_to(ROBOT) < 0.03


def test_markers_have_their_usual_colors():
    names = {color.name for color in default_ranges(robot=RobotMarker(), goal=GoalMarker())}
    assert {'robot_front', 'robot_rear', 'goal', 'goal_heading'} <= names


def test_a_picture_without_a_goal_is_let_go_once_it_was_seen():
    room = watch()
    rgb = picture()
    room.add_picture(0.0, rgb)
    # The room keeps a copy of the last picture, and nothing else may keep this one.
    gone = weakref.ref(rgb)
    gc.disable()
    try:
        sighting = room.add_picture(1.0, rgb)
        assert isinstance(sighting.perception.goal_problem, MarkerNotSeen)
        del rgb
        assert gone() is None
    finally:
        gc.enable()
