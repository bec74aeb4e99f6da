"""The camera under the ceiling sees the world as it is, and as it changes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped
from harness import ERROR, LATCHED, SENSOR, WARN, Bench
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import CameraInfo, Image
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import QuadError
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.image_conversions import (
    camera_model_from_info,
    rgb_from_image,
)
from quad_common.ros.pose_conversions import (
    pose_message,
    seconds_from_time,
)
from quad_common.vision.camera import CameraModel
from quad_common.vision.markers import GoalMarker, RobotMarker
from quad_sim.world.appearance import Appearance
from quad_sim.world.random_room import random_room

pytestmark = pytest.mark.ros

ROBOT = load_robot('titan_viii')
RED = Appearance().obstacle_color
# Pictures take long to draw: they are to come at the pace in which a test looks at them.
BULLET = {
    'backend': 'bullet',
    'real_time_factor': 5.0,
    'camera': True,
    'map_file': 'none',
    'start_pose': [2.0, 2.0, 0.5],
}


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what the camera sees."""
    return composed_bench


class Pictures:
    """What the camera published, by stamp."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.images = bench.hear(Image, 'ceiling_camera/image_raw', SENSOR)
        self.infos = bench.hear(CameraInfo, 'ceiling_camera/camera_info', SENSOR)

    def model(self) -> CameraModel:
        """Return the camera as its info describes it, at its place."""
        self._bench.wait_until('a camera info', lambda: bool(self.infos))
        there = CameraModel.looking_down((4.0, 4.0, 6.0), 0.0, 1.4)
        return camera_model_from_info(self.infos[-1], there.rotation, there.position)

    def wait_until(self, what: str, holds: Callable[[np.ndarray], bool]) -> None:
        """Listen until there is a picture of which something holds, from now on."""
        del self.images[:]
        seen = []

        def condition() -> bool:
            if len(self.images) > len(seen):
                seen.append(holds(rgb_from_image(self.images[-1])))
            return bool(seen) and seen[-1]

        self._bench.wait_until(what, condition)


@pytest.fixture
def pictures(bench: Bench):
    return Pictures(bench)


def has(image, model, place, color):
    """Tell whether a color is seen at a place of the world."""
    column, row = model.project([place])[0].astype(int)
    patch = image[row - 1 : row + 2, column - 1 : column + 2].astype(int)
    return bool((np.abs(patch - color).max(axis=2) < 30).all())


def marker(kind, x, y, size, action=Marker.ADD, name=0, frame='map'):
    one = Marker(ns='test', id=name, type=kind, action=action)
    one.header.frame_id = frame
    one.pose = pose_message(Pose2D(x, y, 0.3))
    one.scale.x, one.scale.y, one.scale.z = size
    return one


@pytest.mark.parametrize(('rate', 'size'), [(2.0, (640, 640)), (5.0, (160, 120))])
def test_pictures_come_at_their_rate_in_simulated_time(bench: Bench, pictures, rate, size):
    bench.start('sim_node', camera_rate=rate, camera_size=list(map(float, size)), **BULLET)
    count = 10
    bench.wait_until('some pictures', lambda: len(pictures.images) > count)
    times = np.array([seconds_from_time(image.header.stamp) for image in pictures.images])
    # Best effort may lose one now and then; those that come are on the beat.
    beats = np.rint(times * rate)
    # Best effort may lose one now and then; those that come are on the beat.
    assert times * rate == pytest.approx(beats, abs=1e-6)
    assert np.diff(beats).min() == 1
    image, info = pictures.images[-1], pictures.infos[-1]
    assert (image.width, image.height) == (info.width, info.height) == size
    assert (image.encoding, image.header.frame_id) == ('rgb8', 'ceiling_camera')
    assert info.header.frame_id == 'ceiling_camera'
    stamped = {seconds_from_time(info.header.stamp) for info in pictures.infos}
    assert stamped & set(times)


def test_the_robot_is_seen_where_odometry_says_that_it_is(bench: Bench, pictures):
    bench.start('sim_node', **BULLET)
    model, disc = pictures.model(), RobotMarker.on(ROBOT)
    height = ROBOT.standing_height + disc.height
    ahead, behind = (
        bench.pose @ Pose2D(along * disc.disc_distance, 0.0, 0.0) for along in (0.5, -0.5)
    )
    pictures.wait_until(
        'both discs',
        lambda image: (
            has(image, model, (ahead.x, ahead.y, height), disc.front_color)
            and has(image, model, (behind.x, behind.y, height), disc.rear_color)
        ),
    )


def test_obstacles_and_goal_marker_come_move_and_go(bench: Bench, pictures):
    bench.start('sim_node', camera_rate=5.0, **BULLET)
    model = pictures.model()
    box, moved, drum = (5.0, 3.0, 0.6), (6.0, 2.0, 0.6), (3.0, 6.0, 0.3)

    def red(image):
        return [has(image, model, place, RED) for place in (box, moved, drum)]

    pictures.wait_until('an empty floor', lambda image: red(image) == [False, False, False])
    obstacles = bench.publisher(MarkerArray, 'obstacles')
    both = [marker(Marker.CUBE, 5.0, 3.0, (0.8, 0.5, 0.6))]
    both.append(marker(Marker.CYLINDER, 3.0, 6.0, (0.6, 0.6, 0.3), name=1))
    obstacles.publish(MarkerArray(markers=both))
    pictures.wait_until('box and drum', lambda image: red(image) == [True, False, True])

    # The box moves, the drum goes.
    changes = [marker(Marker.CUBE, 6.0, 2.0, (0.8, 0.5, 0.6))]
    changes.append(Marker(ns='test', id=1, action=Marker.DELETE))
    obstacles.publish(MarkerArray(markers=changes))
    pictures.wait_until('the box elsewhere', lambda image: red(image) == [False, True, False])

    look = GoalMarker()
    for goal in (Pose2D(6.0, 6.0, 2.0), Pose2D(3.0, 5.0, -1.0)):
        given = PoseStamped(pose=pose_message(goal))
        given.header.frame_id = 'map'
        bench.publisher(PoseStamped, 'goal_marker').publish(given)
        ahead = goal @ Pose2D(look.heading_distance, 0.0, 0.0)
        spots = [((goal.x, goal.y, look.height), look.color)]
        spots.append(((ahead.x, ahead.y, look.height), look.heading_color))
        pictures.wait_until(
            f'the goal at {goal}',
            lambda image, spots=spots: all(has(image, model, *spot) for spot in spots),
        )

    obstacles.publish(MarkerArray(markers=[Marker(action=Marker.DELETEALL)]))
    pictures.wait_until('an empty floor', lambda image: red(image) == [False, False, False])


def test_a_robot_walks_into_an_obstacle_that_is_dropped_before_it_and_nobody_sees(bench: Bench):
    north = math.pi / 2.0
    bench.start_robot(backend='bullet', start_pose=[1.5, 1.2, north])
    obstacles = bench.publisher(MarkerArray, 'obstacles')
    bench.give_goal(Pose2D(1.5, 3.0, north))
    bench.wait_for_walking()
    box = marker(Marker.CUBE, 1.5, bench.pose.y + 1.0, (1.0, 0.3, 0.5))
    obstacles.publish(MarkerArray(markers=[box]))
    bench.wait_for_status('sim_node', 'touches obstacle', level=WARN)


def test_obstacles_that_cannot_be_are_refused_with_a_sentence_and_change_nothing(
    bench: Bench, pictures
):
    bench.start('sim_node', camera_rate=5.0, **BULLET)
    model = pictures.model()
    obstacles = bench.publisher(MarkerArray, 'obstacles')
    size = (0.5, 0.5, 0.5)
    bad = [
        (marker(Marker.SPHERE, 5.0, 5.0, size), 'its type is 2; known are CUBE 1 and CYLINDER 3'),
        (marker(Marker.CUBE, 5.0, 5.0, size, frame='odometer'), "in frame 'odometer'; give it"),
        (marker(Marker.CUBE, math.nan, 5.0, size), 'the pose is not a pose'),
        (marker(Marker.CUBE, 5.0, 5.0, (0.5, 0.5, -1.0)), 'each side must be from 0.001 to 100 m'),
        (marker(Marker.CYLINDER, 5.0, 5.0, (0.5, 0.4, 1.0)), "'width' is 0.4; it must be the"),
        (marker(Marker.CUBE, 2.1, 2.0, size), 'from the middle of the robot; it must be at least'),
        (marker(Marker.CUBE, 5.0, 5.0, size, action=7), 'its action is 7'),
    ]
    good = marker(Marker.CUBE, 5.0, 3.0, (0.8, 0.5, 0.6))
    for one, words in bad:
        with bench.expects('sim_node', words, level=ERROR):
            obstacles.publish(MarkerArray(markers=[good, one]))
    goal = PoseStamped()
    with bench.expects('sim_node', "the goal_marker cannot be used: it is in frame ''"):
        bench.publisher(PoseStamped, 'goal_marker').publish(goal)
    # All were heard, and every message had a good marker too.
    since = bench.time + 1.0
    bench.wait_until(
        'a picture from now on',
        lambda: (
            bool(pictures.images) and seconds_from_time(pictures.images[-1].header.stamp) > since
        ),
    )
    assert not has(rgb_from_image(pictures.images[-1]), model, (5.0, 3.0, 0.6), RED)


def test_a_room_of_random_obstacles_takes_the_place_of_the_map(bench: Bench, pictures):
    maps = bench.hear(OccupancyGrid, 'map', LATCHED)
    options = {**BULLET, 'map_file': ''}
    bench.start('sim_node', room_seed=3, room_obstacles=5, **options)
    model = pictures.model()
    room = random_room(3, 5, Pose2D(2.0, 2.0, 0.5))
    spots = [((one.pose.x, one.pose.y, one.height), RED) for one in room.world.obstacles]
    spots.append(((room.goal.x, room.goal.y, GoalMarker().height), GoalMarker().color))
    pictures.wait_until('the room', lambda image: all(has(image, model, *spot) for spot in spots))
    bench.wait_until('the map', lambda: bool(maps))
    cells = np.array(maps[0].data, np.int8).reshape(160, 160)
    for one in room.world.obstacles:
        assert cells[int(one.pose.y / 0.05), int(one.pose.x / 0.05)] == 100


def test_without_publish_map_nobody_is_told(bench: Bench):
    maps = bench.hear(OccupancyGrid, 'map', LATCHED)
    bench.start('sim_node', publish_map=False)
    bench.start('planner_node')
    bench.wait_for_status('planner_node', 'no map')
    since = bench.elapsed
    bench.wait_until('some time', lambda: bench.elapsed > since + 5.0)
    assert maps == []


@pytest.mark.parametrize(
    ('parameters', 'words'),
    [
        ({'backend': 'kinematic', 'camera': True}, "set 'backend' to 'bullet'"),
        ({'room_seed': 1, 'map_file': 'none'}, "'room_seed' is 1; it must be -1 with 'map_file'"),
        ({'room_obstacles': 3}, "'room_obstacles' is 3; it must be -1 without a 'room_seed'"),
        ({'camera': True, 'camera_size': [640.5, 480.0]}, "'camera_size' is [640.5, 480.0]; it"),
        ({'camera': True, 'camera_position': [0.0, 0.0, -1.0]}, 'it must be above the floor'),
        ({'goal_color': [0.0, 0.0, 300.0]}, "'goal_color' is [0.0, 0.0, 300.0]; it must be red"),
    ],
)
def test_a_camera_that_cannot_be_is_refused(bench: Bench, parameters, words):
    with pytest.raises(QuadError) as refused:
        bench.start('sim_node', **parameters)
    assert words in str(refused.value)


def test_the_kinematic_backend_has_no_obstacles_and_says_so(bench: Bench):
    bench.start('sim_node')
    obstacles = bench.publisher(MarkerArray, 'obstacles')
    with bench.expects('sim_node', 'this simulator does not support an obstacle', level=ERROR):
        obstacles.publish(MarkerArray(markers=[marker(Marker.CUBE, 5.0, 3.0, (0.5, 0.5, 0.5))]))
