"""Pictures are what the camera's model says, and taking them changes nothing."""

import math

import cv2
import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.vision.camera import CameraModel
from quad_common.vision.markers import GoalMarker, RobotMarker
from quad_sim.engines.registry import ENGINES, engines_with, make_simulator
from quad_sim.world.appearance import Appearance
from quad_sim.world.random_room import random_room
from quad_sim.world.simulated_camera import SimulatedCamera
from quad_sim.world.world import Obstacle, world_from_map

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
BARREL = (-0.25, 0.06, 0.001, -0.0005, 0.0)
LOOK = Appearance()
MARKER = RobotMarker.on(ROBOT)


def camera_model(position=(4.0, 4.0, 6.0), yaw=0.0, field_of_view=1.4, size=(640, 640), **options):
    return CameraModel.looking_down(position, yaw, field_of_view, size, **options)


def tilted_model():
    """Return a camera that looks at the room aslant, with a principal point off the middle."""
    straight = camera_model()
    turn, _ = cv2.Rodrigues(np.array([0.3, -0.2, 0.4]))
    matrix = np.array([[420.0, 0.0, 300.0], [0.0, 410.0, 260.0], [0.0, 0.0, 1.0]])
    rotation = straight.rotation @ turn
    return CameraModel(640, 560, matrix, rotation, np.array([4.5, 3.0, 7.0]), np.zeros(5))


MODELS = {
    'straight': camera_model(),
    'small': camera_model(size=(320, 240), field_of_view=1.3),
    'tilted': tilted_model(),
    'distorted and turned': camera_model((4.1, 3.8, 5.5), -2.0, distortion=BARREL),
    'pincushion': camera_model(field_of_view=1.3, distortion=(0.1, 0.0, 0.0, 0.0, 0.0)),
}


@pytest.fixture(params=engines_with('has_pictures'))
def make(request):
    """Make simulators that are closed after the test."""
    pytest.importorskip(ENGINES[request.param].package)
    made = []

    def make_one(world=None, **options):
        world = world_from_map(None) if world is None else world
        made.append(make_simulator(request.param, ROBOT, world, **options))
        return made[-1]

    yield make_one
    for simulator in made:
        simulator.close()


def picture(simulator, model, seed=0, **options):
    return SimulatedCamera(model, **options).take(simulator, np.random.default_rng(seed))


def weights(image, color, background):
    """How much of a color is in each pixel, from 0 to 1, where it lies on a background."""
    axis = np.subtract(color, background, dtype=float)
    return np.clip((image - np.asarray(background, float)) @ axis / (axis @ axis), 0.0, 1.0)


def blobs(image, color):
    """Centers of the spots that have nearly a color, (column, row), with their areas."""
    mask = np.abs(image.astype(int) - color).max(axis=2) < 40
    _, _, stats, centers = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    return centers[1:] + 0.5, stats[1:, cv2.CC_STAT_AREA]


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('name', MODELS)
def test_things_are_seen_where_the_model_projects_them(make, name):
    model = MODELS[name]
    color = (20, 170, 60)
    places = [(x, y) for x in (2.2, 3.4, 4.6, 5.8) for y in (2.4, 3.3, 4.8, 5.6)]
    simulator = make()
    simulator.reset(Pose2D(-3.0, -3.0, 0.0))
    height = 0.004
    for index, (x, y) in enumerate(places):
        simulator.put_obstacle(index, Obstacle.cylinder(x, y, 0.12, height, color))
    centers, areas = blobs(picture(simulator, model), color)
    assert len(centers) == len(places)
    missed = []
    for x, y in places:
        # The middle of a disc's picture is not the picture of its middle.
        angles = np.linspace(0.0, 2.0 * math.pi, 64, endpoint=False)
        inner = [(x, y, height)] + [
            (x + r * math.cos(a), y + r * math.sin(a), height)
            for r in np.sqrt((np.arange(8) + 0.5) / 8.0) * 0.12
            for a in angles
        ]
        expected = model.project(inner[1:]).mean(axis=0)
        missed.append((centers - expected)[np.argmin(np.linalg.norm(centers - expected, axis=1))])
    missed = np.array(missed)
    assert np.abs(missed).max() < 0.5
    # No half pixels: the renderer's own shift is taken out.
    assert np.abs(missed.mean(axis=0)).max() < 0.12
    assert areas.min() > 20


def test_the_robots_marker_shows_position_and_heading(make):
    model = camera_model()
    simulator = make()
    for pose in (Pose2D(2.0, 3.0, 0.4), Pose2D(6.0, 5.5, -2.5), Pose2D(4.0, 4.0, math.pi / 2)):
        simulator.reset(pose)
        image = picture(simulator, model)
        height = simulator.observe().position[2] + MARKER.height
        ends = []
        for color in (MARKER.front_color, MARKER.rear_color):
            centers, areas = blobs(image, color)
            ends.append(model.on_plane([centers[np.argmax(areas)]], height)[0])
        front, rear = ends
        assert np.linalg.norm((front + rear) / 2.0 - (pose.x, pose.y)) < 0.006
        assert np.linalg.norm(front - rear) == pytest.approx(MARKER.disc_distance, abs=0.008)
        seen = math.atan2(front[1] - rear[1], front[0] - rear[0])
        assert abs(math.remainder(seen - pose.yaw, 2.0 * math.pi)) < math.radians(2.0)


def test_the_robot_in_the_picture_moves_with_the_simulation(make):
    simulator = make()
    model = camera_model((0.0, 0.0, 3.0))
    before = picture(simulator, model)
    for _ in range(100):
        simulator.step(POSTURE + np.tile([0.3, 0.0, 0.0], 4), np.zeros(12))
    moved = picture(simulator, model)
    assert (before != moved).any(axis=2).sum() > 100
    simulator.reset(Pose2D(0.0, 0.0, 0.0))
    assert (picture(simulator, model) == before).all()


def test_the_goals_marker_is_laid_and_moved(make):
    model = camera_model()
    simulator = make()
    simulator.reset(Pose2D(1.0, 1.0, 0.0))
    marker = GoalMarker()
    assert len(blobs(picture(simulator, model), marker.color)[0]) == 0
    for pose in (Pose2D(5.0, 5.0, 1.0), Pose2D(3.0, 6.0, -2.0)):
        simulator.put_goal_marker(pose)
        image = picture(simulator, model)
        ahead = pose @ Pose2D(marker.heading_distance, 0.0, 0.0)
        for color, place in ((marker.color, pose), (marker.heading_color, ahead)):
            [center], _ = blobs(image, color)
            expected = model.project([(place.x, place.y, marker.height)])[0]
            assert np.abs(center - expected).max() < 0.5


def test_hues_of_markers_obstacles_and_floor_are_far_apart(make):
    room = random_room(4, 8)
    simulator = make(room.world)
    simulator.reset(room.start)
    simulator.put_goal_marker(room.goal)
    image = picture(simulator, camera_model())
    hsv = cv2.cvtColor(image, cv2.COLOR_RGB2HSV)
    colored = hsv[..., 1] > 100
    hues = np.unique(2 * hsv[colored][:, 0].astype(int))
    expected = {
        2 * int(cv2.cvtColor(np.uint8([[color]]), cv2.COLOR_RGB2HSV)[0, 0, 0])
        for color in (
            LOOK.obstacle_color,
            MARKER.front_color,
            MARKER.rear_color,
            LOOK.goal_marker.color,
            LOOK.goal_marker.heading_color,
        )
    }
    ordered = sorted(expected)
    gaps = np.diff([*ordered, ordered[0] + 360])
    assert gaps.min() > 40
    # Whatever has a color has one of these; floor, plate and body have none.
    nearest = [min(abs(math.remainder(hue - other, 360)) for other in expected) for hue in hues]
    assert max(nearest) <= 6


def test_tops_are_brighter_than_sides_and_have_their_own_color(make):
    simulator = make()
    simulator.reset(Pose2D(1.0, 1.0, 0.0))
    simulator.put_obstacle(0, Obstacle.box(Pose2D(6.0, 6.0, 0.3), 0.8, 0.8, 1.0))
    model = camera_model()
    image = picture(simulator, model)
    column, row = model.project([(6.0, 6.0, 1.0)])[0].astype(int)
    assert image[row, column] == pytest.approx(LOOK.obstacle_color, abs=2)
    red = image[(image[..., 0] > 100) & (image[..., 1] < 80)]
    assert len(np.unique(red, axis=0)) >= 2
    assert (red[:, 0] <= LOOK.obstacle_color[0] + 1).all()


def rocked(simulator, camera=None, steps=300):
    """Move the robot about, with a picture every now and then, and return its states."""
    rng = np.random.default_rng(1)
    rates, sizes = rng.uniform(1.0, 5.0, 12), rng.uniform(-0.15, 0.15, 12)
    states = []
    for k in range(steps):
        t = 0.005 * k
        simulator.step(POSTURE + sizes * np.sin(rates * t), sizes * rates * np.cos(rates * t))
        if camera is not None and k % 40 == 20:
            camera.take(simulator, rng)
            simulator.put_goal_marker(Pose2D(0.1 * k, 0.0, 0.0))
        seen = simulator.observe()
        states.append(np.concatenate([seen.position, seen.orientation, seen.joint_positions]))
    return np.array(states)


def test_a_run_with_pictures_is_the_same_bit_for_bit_as_one_without(make):
    world = random_room(2, 5, Pose2D(1.0, 1.0, 0.0)).world
    camera = SimulatedCamera(camera_model(size=(64, 64)), noise=3.0)
    assert (rocked(make(world), camera) == rocked(make(world))).all()


def test_noise_is_that_of_the_seed(make):
    simulator, model = make(), camera_model(size=(160, 160))
    clean = picture(simulator, model)
    noisy = picture(simulator, model, seed=5, noise=8.0)
    assert (noisy == picture(simulator, model, seed=5, noise=8.0)).all()
    assert (noisy != picture(simulator, model, seed=6, noise=8.0)).any()
    plain = (clean == LOOK.floor_color).all(axis=2)
    assert plain.sum() > 10_000
    added = noisy[plain].astype(float) - clean[plain]
    assert added.std() == pytest.approx(8.0, rel=0.03)
    assert abs(added.mean()) < 0.3


def test_brightness_is_a_factor_that_ends_at_white(make):
    simulator, model = make(), camera_model(size=(160, 160))
    clean = picture(simulator, model).astype(float)
    assert picture(simulator, model, brightness=0.5) == pytest.approx(clean / 2.0, abs=0.51)
    bright = picture(simulator, model, brightness=2.0)
    assert bright == pytest.approx(np.minimum(2.0 * clean, 255.0), abs=0.51)


def test_pictures_of_one_state_are_the_same(make):
    simulator = make(random_room(1, 4).world)
    model = camera_model(distortion=BARREL, size=(200, 200))
    assert (picture(simulator, model) == picture(simulator, model)).all()


def test_a_pattern_on_the_floor_is_drawn_if_it_is_asked_for(make):
    model = camera_model((0.0, 0.0, 6.0), size=(200, 200))
    patterned = picture(make(appearance=Appearance(checker_size=0.5)), model)
    plain = picture(make(), model)
    fraction = np.mean((patterned != plain).any(axis=2))
    assert 0.4 < fraction < 0.6


@pytest.mark.parametrize('value', [-1.0, math.nan, math.inf])
@pytest.mark.parametrize('name', ['noise', 'brightness'])
def test_numbers_that_are_not_valid_for_a_camera_are_refused(name, value):
    with pytest.raises(ParameterError, match=name):
        SimulatedCamera(camera_model(), **{name: value})


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('distortion', [(-1.0, 0.0, 0.0, 0.0, 0.0), (-0.45, 0.0, 0.0, 0.0, 0.0)])
def test_a_lens_that_folds_the_picture_over_is_refused(distortion):
    with pytest.raises(ParameterError, match=r"'distortion' is .* it must be smaller"):
        SimulatedCamera(camera_model(distortion=distortion, size=(200, 200)))
