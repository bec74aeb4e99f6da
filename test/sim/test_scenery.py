"""What the parameters say of world and camera is what is built."""

import re
from dataclasses import replace

import pytest

from quad_common.errors import ParameterError
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.vision.markers import RobotMarker
from quad_sim.parameters import SimParameters
from quad_sim.scenery import appearance_from, camera_from, scenery_from
from quad_sim.world.appearance import Appearance
from quad_sim.world.random_room import random_room
from quad_sim.world.terrain_spec import TerrainSpec, make_terrain

ROBOT = load_robot('titan_viii')


def parameters(**changes):
    return replace(SimParameters(), **changes)


def test_a_map_gives_walls_and_the_map_and_no_goal():
    scenery = scenery_from(parameters(friction=0.4), ROBOT)
    assert scenery.grid is not None
    assert len(scenery.world.boxes) > 3
    assert scenery.world.friction == 0.4
    assert (scenery.world.obstacles, scenery.goal) == ((), None)
    untold = scenery_from(parameters(publish_map=False), ROBOT)
    assert untold.grid is None
    assert (untold.world.boxes == scenery.world.boxes).all()


def test_no_map_is_an_empty_floor():
    scenery = scenery_from(parameters(map_file='none'), ROBOT)
    assert scenery.grid is None
    assert len(scenery.world.boxes) == 0


def test_a_seed_gives_its_room_its_map_and_a_goal():
    room = random_room(5, None, Pose2D(1.2, 1.2, 0.0))
    scenery = scenery_from(parameters(room_seed=5, backend='bullet'), ROBOT)
    assert scenery.world.obstacles == room.world.obstacles
    assert (scenery.start, scenery.goal) == (room.start, room.goal)
    assert scenery.grid.bounds() == pytest.approx(room.bounds)
    assert len(scenery_from(parameters(room_seed=5, room_obstacles=4), ROBOT).world.obstacles) == 4
    assert scenery_from(parameters(room_seed=5, backend='kinematic'), ROBOT).goal is None


def test_flat_ground_is_none_and_uneven_ground_reaches_beyond_the_map():
    assert scenery_from(parameters(), ROBOT).world.terrain is None
    assert scenery_from(parameters(), ROBOT).height_map is None
    scenery = scenery_from(parameters(terrain='bumps', terrain_height=0.03), ROBOT)
    x_min, y_min, x_max, y_max = scenery.grid.bounds()
    around = (x_min - 1.0, y_min - 1.0, x_max + 1.0, y_max + 1.0)
    assert scenery.height_map.bounds == pytest.approx(around)
    assert 0.02 < scenery.height_map.heights.max() <= 0.03
    assert len(scenery.world.boxes) > 3
    untold = scenery_from(parameters(terrain='bumps', publish_height_map=False), ROBOT)
    assert untold.height_map is None
    assert untold.world.terrain is not None


def test_every_number_of_the_ground_is_a_parameter():
    for name in ('height', 'angle', 'size', 'length', 'clear', 'seed'):
        table = parameters()
        assert getattr(table, f'terrain_{name}') == getattr(TerrainSpec('bumps'), name)
    spec = {'angle': 0.2, 'length': 0.7, 'clear': 0.6}
    numbers = {f'terrain_{name}': value for name, value in spec.items()}
    start = Pose2D(3.0, 2.0, 0.5)
    scenery = scenery_from(
        parameters(terrain='slope', map_file='none', start_pose=[3.0, 2.0, 0.5], **numbers), ROBOT
    )
    bounds = (-2.0, -3.0, 8.0, 7.0)
    expected = make_terrain((TerrainSpec('slope', **spec),), bounds, start)
    assert scenery.height_map.bounds == pytest.approx(bounds)
    assert scenery.height_map.heights == pytest.approx(expected.field.heights)


def test_a_room_is_level_around_its_goal_too():
    scenery = scenery_from(parameters(terrain='boxes', room_seed=5, backend='bullet'), ROBOT)
    for pose in (scenery.start, scenery.goal):
        heights = scenery.height_map.highest_within([pose.x, pose.y], 0.75)
        assert heights == 0.0


def test_ground_that_does_not_exist_is_refused():
    with pytest.raises(ParameterError, match="'terrain' is 'hills'; it must be flat, one of"):
        scenery_from(parameters(terrain='hills'), ROBOT)


@pytest.mark.parametrize(
    ('changes', 'told'),
    [
        ({'room_seed': 0, 'map_file': 'none'}, "'room_seed' is 0; it must be -1 with 'map_file'"),
        ({'room_obstacles': 4}, "'room_obstacles' is 4; it must be -1 without a 'room_seed'"),
        ({'room_seed': 0, 'start_pose': [9.0, 1.0, 0.0]}, "'start_pose' is .9.0"),
        ({'start_pose': [0.1, 0.1, 0.0]}, "'start_pose' is"),
    ],
)
def test_what_contradicts_itself_is_refused(changes, told):
    with pytest.raises(ParameterError, match=told):
        scenery_from(parameters(**changes), ROBOT)


@pytest.mark.parametrize(
    ('pose', 'told'),
    [
        ([1e300, 0.0, 0.0], "'start_pose.x' is 1e+300"),
        ([0.0, -2e9, 0.0], "'start_pose.y' is -2000000000.0"),
        ([0.0, 0.0, 1e17], "'start_pose.yaw' is 1e+17"),
    ],
)
@pytest.mark.parametrize('map_file', ['', 'none'])
def test_a_start_that_is_no_place_is_refused(pose, told, map_file):
    with pytest.raises(ParameterError, match=re.escape(told)):
        scenery_from(parameters(start_pose=pose, map_file=map_file), ROBOT)


def test_the_defaults_are_those_of_the_appearance_and_of_the_markers():
    default = appearance_from(parameters(), ROBOT)
    assert default == replace(Appearance(), robot_marker=RobotMarker.on(ROBOT))


def test_a_color_is_three_numbers_up_to_255():
    look = appearance_from(parameters(front_color=[1.0, 2.0, 3.0]), ROBOT)
    assert look.robot_marker.front_color == (1, 2, 3)
    with pytest.raises(ParameterError, match=r"'rear_color' is .*, from 0 to 255"):
        appearance_from(parameters(rear_color=[0.0, 0.0, 256.0]), ROBOT)


def test_the_camera_sees_the_whole_room_also_the_tops_at_its_rim():
    model = camera_from(parameters()).model
    rim = [(x, y, z) for x in (0.0, 8.0) for y in (0.0, 8.0) for z in (0.0, 1.0)]
    pixels = model.project(rim)
    assert (model.width, model.height) == (640, 640)
    assert pixels.min() > 0.0
    assert pixels.max() < 640.0


@pytest.mark.parametrize('size', [[8.0, 640.0], [640.0, 4096.0], [100.5, 100.0]])
def test_a_picture_has_a_sensible_whole_number_of_pixels(size):
    with pytest.raises(ParameterError, match='two whole numbers from 16 to 2048'):
        camera_from(parameters(camera_size=size))
