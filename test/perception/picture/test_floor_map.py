"""Maps are occupied where obstacles stand, free where the floor is seen, unknown elsewhere."""

import math

import cv2
import numpy as np
import pytest
from pictures import (
    FLOOR,
    Obstacle,
    ceiling_camera,
    disturbed,
    paint,
    random_obstacles,
    robot_plates,
    truth,
)

from quad_common.errors import ParameterError
from quad_common.maps.occupancy_grid import UNKNOWN
from quad_common.planar_pose import Pose2D
from quad_common.vision.camera import CameraModel
from quad_common.vision.markers import RobotMarker
from quad_perception.picture.floor_view import FloorView
from quad_perception.picture.perception import Perceiver
from quad_perception.picture.scene_model import SceneModel

BOUNDS = (-4.0, -4.0, 4.0, 4.0)
WIDE = 4.9
"""Half side of the floor that is seen, so that tops at the walls are in the picture [m]."""


def room_camera(half=WIDE, height=6.0, **options):
    return CameraModel.looking_down(
        (0.0, 0.0, height), options.pop('yaw', 0.0), 2.0 * math.atan(half / height), **options
    )


CAMERAS = {
    'straight': room_camera(),
    'distorted': room_camera(distortion=(-0.1, 0.0, 0.0, 0.0, 0.0)),
    'turned': room_camera(yaw=math.pi / 2.0),
}


def tilted():
    straight = room_camera(5.5, yaw=0.3)
    turn, _ = cv2.Rodrigues(np.array([0.12, -0.1, 0.0]))
    return CameraModel(
        640, 640, straight.matrix, straight.rotation @ turn, np.array([0.3, -0.4, 6.0]), np.zeros(5)
    )


CAMERAS['tilted'] = tilted()


def overlap(grid, obstacles):
    expected, occupied = truth(grid, obstacles), grid.occupied()
    return (expected & occupied).sum() / (expected | occupied).sum()


def cell(grid, x, y):
    column, row = np.floor(grid.world_to_map(np.array([x, y]))).astype(int)
    return int(grid.cells[row, column])


@pytest.fixture(scope='module')
def perceivers():
    return {name: Perceiver(camera, bounds=BOUNDS) for name, camera in CAMERAS.items()}


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize('name', CAMERAS)
def test_obstacles_are_found_where_they_stand(perceivers, name, seed):
    rng = np.random.default_rng(seed)
    obstacles = random_obstacles(rng, int(rng.integers(3, 13)), gap=0.8)
    picture = paint(CAMERAS[name], obstacles, floor=(205, 205, 200))
    disturb = disturbed(picture, rng, float(rng.uniform(0.7, 1.3)))
    for shown, least in ((picture, 0.90), (disturb, 0.85)):
        seen = perceivers[name].perceive(shown)
        assert overlap(seen.map, obstacles) >= least
        assert len(seen.footprints) == len(obstacles)


@pytest.mark.parametrize('height', [0.2, 0.5, 1.0])
def test_the_height_of_an_obstacle_follows_from_its_side(perceivers, height):
    picture = paint(CAMERAS['straight'], [Obstacle(2.0, 1.0, height, 0.6, 0.5, 0.4)])
    (footprint,) = perceivers['straight'].perceive(picture).footprints
    assert footprint.height == pytest.approx(height, abs=0.05)


def test_what_a_tall_obstacle_hides_is_unknown_and_the_floor_around_it_free(perceivers):
    picture = paint(CAMERAS['straight'], [Obstacle(2.0, 0.0, 1.0, 0.6, 0.6)])
    grid = perceivers['straight'].perceive(picture).map
    assert cell(grid, 2.0, 0.0) == 100
    # The far edge of the top is seen at 2.3 m * 6 / 5.
    assert cell(grid, 2.5, 0.0) == UNKNOWN
    assert cell(grid, 2.9, 0.0) == 0
    assert cell(grid, 1.6, 0.0) == 0
    assert cell(grid, 2.0, 0.6) == 0


def test_what_lies_outside_the_picture_is_unknown(perceivers):
    view = Perceiver(room_camera(3.0), bounds=BOUNDS)
    grid = view.perceive(paint(room_camera(3.0), [])).map
    assert cell(grid, 3.5, 0.0) == UNKNOWN
    assert cell(grid, 2.5, 0.0) == 0
    fraction = np.mean(grid.cells == 0)
    assert fraction == pytest.approx(36.0 / 64.0, abs=0.01)


def test_without_bounds_the_map_is_the_visible_floor():
    view = FloorView(room_camera(3.0))
    assert view.shape == (120, 120)
    assert (view.origin.x, view.origin.y) == pytest.approx((-3.0, -3.0))


def test_below_the_camera_a_height_is_assumed(perceivers):
    picture = paint(CAMERAS['straight'], [Obstacle(0.0, 0.05, 0.6, 0.8, 0.6)])
    seen = perceivers['straight'].perceive(picture)
    assert seen.footprints[0].height is None
    assert overlap(seen.map, [Obstacle(0.0, 0.05, 0.6, 0.8, 0.6)]) > 0.85


def test_a_tall_obstacle_in_front_of_another_hides_a_part_of_it_and_not_all(perceivers):
    both = [Obstacle(1.5, 0.0, 0.8, 0.5, 0.5), Obstacle(2.4, 0.1, 0.9, 0.6, 0.9)]
    seen = perceivers['straight'].perceive(paint(CAMERAS['straight'], both))
    assert len(seen.footprints) == 2
    assert overlap(seen.map, both) > 0.8


@pytest.mark.parametrize('heights', [(0.9, 0.3), (0.3, 0.9), (0.5, 0.5)])
def test_tops_that_touch_are_brought_back_each_by_its_height(perceivers, heights):
    # Side by side, seen from the camera, and nearer to each other than a pixel.
    both = [
        Obstacle(2.5, 0.305, heights[0], 0.6, 0.6),
        Obstacle(2.5, -0.305, heights[1], 0.6, 0.6),
    ]
    seen = perceivers['straight'].perceive(paint(CAMERAS['straight'], both))
    assert overlap(seen.map, both) > 0.85
    for one in both:
        assert seen.map.occupied()[truth(seen.map, [one])].mean() > 0.85


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('seed', range(3))
def test_in_a_crowd_none_is_missed_and_none_taken_for_floor(perceivers, seed):
    rng = np.random.default_rng(seed)
    obstacles = random_obstacles(rng, 12, gap=0.05)
    picture = paint(CAMERAS['straight'], obstacles, floor=(205, 205, 200))
    grid = perceivers['straight'].perceive(picture).map
    assert overlap(grid, obstacles) > 0.9
    for one in obstacles:
        cells = truth(grid, [one])
        assert grid.occupied()[cells].mean() > 0.4
        assert (grid.cells[cells] == 0).mean() < 0.15


def test_an_obstacle_that_the_border_cuts_is_occupied_where_it_is_sure():
    camera = room_camera(4.0)
    cut = Obstacle(3.4, 0.0, 0.8, 0.9, 0.6)
    grid = Perceiver(camera, bounds=BOUNDS).perceive(paint(camera, [cut])).map
    occupied, expected = grid.occupied(), truth(grid, [cut])
    assert occupied.any()
    assert (occupied & ~expected).sum() <= 0.1 * occupied.sum()
    assert not (expected & (grid.cells == 0)).any()


def test_a_thing_of_another_color_is_unknown(perceivers):
    picture = paint(CAMERAS['straight'], [Obstacle(1.0, 1.0, 0.3, 0.6, 0.6)], color=(130, 60, 200))
    grid = perceivers['straight'].perceive(picture).map
    assert cell(grid, 1.0, 1.0) == UNKNOWN
    assert not grid.occupied().any()


def test_an_empty_room_is_free_with_noise_too(perceivers):
    picture = disturbed(paint(CAMERAS['straight'], []), np.random.default_rng(0), 0.7)
    assert np.all(perceivers['straight'].perceive(picture).map.cells == 0)


def test_under_the_robot_the_map_keeps_what_was_known(perceivers):
    perceiver, camera = perceivers['straight'], CAMERAS['straight']
    before = perceiver.perceive(paint(camera, []))
    plates = robot_plates(Pose2D(1.0, 1.0, 0.5), RobotMarker())
    with_robot = paint(camera, [], plates)
    alone = perceiver.perceive(with_robot)
    assert alone.robot is not None
    assert cell(alone.map, 1.0, 1.0) == UNKNOWN
    assert cell(alone.map, -1.0, 1.0) == 0
    assert not alone.map.occupied().any()
    after = perceiver.perceive(with_robot, before.map)
    assert np.array_equal(after.map.cells, before.map.cells)


def test_noise_does_not_make_cells_go_to_and_fro(perceivers):
    perceiver, camera = perceivers['straight'], CAMERAS['straight']
    rng = np.random.default_rng(3)
    room = paint(camera, random_obstacles(rng, 6))
    alone = after = None
    alone_changes, changes = [], []
    for _ in range(8):
        again = disturbed(room, rng)
        alone_before, before = alone, after
        alone, after = perceiver.perceive(again).map, perceiver.perceive(again, after).map
        if before is not None:
            alone_changes.append(np.sum(alone.cells != alone_before.cells))
            changes.append(np.sum(after.cells != before.cells))
    assert np.mean(alone_changes[3:]) > 5.0
    assert np.mean(changes[3:]) < 0.3 * np.mean(alone_changes[3:])


def test_floor_that_is_seen_beside_the_robot_is_free_at_once(perceivers):
    # It may hide what lies outward of it; all of its circle, raised to its back, is more.
    perceiver, camera = perceivers['straight'], CAMERAS['straight']
    pose = Pose2D(2.5, 2.5, 0.5)
    alone = perceiver.perceive(paint(camera, [], robot_plates(pose, RobotMarker()))).map
    rows, columns = np.indices(alone.cells.shape)
    centers = alone.map_to_world(np.stack((columns + 0.5, rows + 0.5), axis=-1))
    away = np.hypot(centers[..., 0] - pose.x, centers[..., 1] - pose.y)
    assert (alone.cells[away > perceiver.scene.robot_radius] == 0).all()


def test_a_robot_of_the_floors_color_makes_no_obstacle_vanish(perceivers):
    perceiver, camera = perceivers['straight'], CAMERAS['straight']
    low = Obstacle(1.0, 1.5, 0.05, 0.3, 0.3)
    before = perceiver.perceive(paint(camera, [low])).map
    assert cell(before, 1.0, 1.5) == 100
    pose = Pose2D(1.0, 1.0, 0.5)
    white = (pose.transform(0.6 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])), 0.1, FLOOR)
    picture = paint(camera, [low], [white, *robot_plates(pose, RobotMarker())])
    assert cell(perceiver.perceive(picture, before).map, 1.0, 1.5) == 100


def test_a_previous_map_of_other_cells_says_nothing(perceivers):
    plates = robot_plates(Pose2D(1.0, 1.0, 0.5), RobotMarker())
    picture = paint(CAMERAS['straight'], [], plates)
    other = Perceiver(CAMERAS['straight'], bounds=BOUNDS, resolution=0.1)
    coarse = other.perceive(paint(CAMERAS['straight'], [])).map
    assert cell(perceivers['straight'].perceive(picture, coarse).map, 1.0, 1.0) == UNKNOWN


def test_a_camera_that_sees_the_horizon_needs_bounds():
    turn, _ = cv2.Rodrigues(np.array([1.2, 0.0, 0.0]))
    down = room_camera()
    aslant = CameraModel(640, 640, down.matrix, down.rotation @ turn, down.position, np.zeros(5))
    with pytest.raises(ParameterError, match='horizon'):
        FloorView(aslant)
    assert FloorView(aslant, bounds=BOUNDS).shape == (160, 160)


@pytest.mark.parametrize(
    ('scene', 'options'),
    [
        ({}, {'resolution': 0.0}),
        ({}, {'resolution': math.nan}),
        ({}, {'resolution': 1e-5}),
        ({}, {'bounds': (1.0, 0.0, 0.0, 1.0)}),
        ({}, {'bounds': (0.0, 0.0, math.inf, 1.0)}),
        ({'largest_height': 6.0}, {}),
        ({'robot_radius': -1.0}, {}),
        ({'ranges': ()}, {}),
    ],
)
def test_bad_numbers_are_refused(scene, options):
    with pytest.raises(ParameterError, match=next(iter({**scene, **options}))):
        Perceiver(ceiling_camera(), SceneModel(**scene), **options)
