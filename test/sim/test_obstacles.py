"""Obstacles are where they are said to be: in the plane, in the map, and in the physics."""

import math

import numpy as np
import pytest

from quad_common.errors import MapError, NotSimulated, ObstacleOnRobot, ParameterError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.vision.camera import CameraModel
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.engines.registry import ENGINES, engines_with, make_simulator
from quad_sim.simulation import Simulation
from quad_sim.world.obstacle_changes import ObstacleChange
from quad_sim.world.simulated_camera import SimulatedCamera
from quad_sim.world.world import Obstacle, World, occupancy_of, world_from_map

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
NO_WALLS = np.empty((0, 4, 2))
BOX = Obstacle.box(Pose2D(2.0, 1.0, 0.5), 0.8, 0.4, 0.6)
CYLINDER = Obstacle.cylinder(-1.0, 0.5, 0.3, 1.0)


@pytest.mark.parametrize('one', [BOX, CYLINDER], ids=['box', 'cylinder'])
def test_points_are_as_far_from_an_obstacle_as_from_its_outline(one):
    points = np.random.default_rng(0).uniform(-3.0, 3.0, (300, 2))
    outline = one.outline(sides=96)
    along = np.linspace(0.0, 1.0, 100)[:, None, None]
    edge = (outline + along * (np.roll(outline, -1, axis=0) - outline)).reshape(-1, 2)
    to_edge = np.linalg.norm(points[:, None] - edge[None], axis=2).min(axis=1)
    distance = one.distance_to(points)
    outside = distance > 0.0
    assert distance[outside] == pytest.approx(to_edge[outside], abs=0.01)
    near = np.hypot(points[:, 0] - one.pose.x, points[:, 1] - one.pose.y)
    assert (near[~outside] <= one.outer_radius).all()
    assert outside[near > one.outer_radius].all()
    assert one.distance_to(np.array([one.pose.x, one.pose.y])) == 0.0


def test_outlines_are_counter_clockwise_and_have_the_area():
    for one, area in ((BOX, 0.32), (CYLINDER, math.pi * 0.09)):
        x, y = one.outline(sides=400).T
        signed = 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
        assert signed == pytest.approx(area, rel=1e-3)


@pytest.mark.parametrize(
    ('changes', 'name'),
    [
        ({'kind': 'sphere'}, 'kind'),
        ({'length': 0.0}, 'length'),
        ({'width': -1.0}, 'width'),
        ({'height': math.nan}, 'height'),
        ({'height': math.inf}, 'height'),
        ({'pose': Pose2D(math.nan, 0.0, 0.0)}, 'pose'),
        ({'kind': 'cylinder'}, 'width'),
        ({'color': (0, 0, 256)}, 'color'),
        ({'color': (0.5, 0.5, 0.5)}, 'color'),
    ],
)
def test_what_is_no_obstacle_is_refused(changes, name):
    fields = {'kind': 'box', 'pose': Pose2D(0.0, 0.0, 0.0), 'length': 1.0, 'width': 0.5}
    with pytest.raises(ParameterError, match=f"'{name}' is"):
        Obstacle(**{**fields, 'height': 0.5, **changes})


def test_a_cell_of_the_true_map_is_occupied_if_its_centre_is_in_a_footprint():
    world = World(NO_WALLS, obstacles=(BOX, CYLINDER))
    grid = occupancy_of(world, 0.05, (-2.0, -1.0, 3.0, 2.0))
    assert (grid.height, grid.width) == (60, 100)
    rows, columns = np.indices(grid.cells.shape)
    centers = grid.map_to_world(np.stack([columns, rows], axis=-1) + 0.5)
    nearest = np.minimum(BOX.distance_to(centers), CYLINDER.distance_to(centers))
    assert ((nearest == 0.0) == grid.occupied()).mean() > 0.9999
    assert set(np.unique(grid.cells)) == {0, 100}
    area = grid.occupied().sum() * 0.05**2
    assert area == pytest.approx(0.32 + math.pi * 0.09, rel=0.02)


def test_the_true_map_of_a_maps_walls_is_the_map():
    cells = np.random.default_rng(3).choice(np.array([0, 100], np.int8), (12, 17), p=[0.7, 0.3])
    grid = OccupancyGrid(cells, 0.1, Pose2D(0.5, -0.3, 0.0))
    again = occupancy_of(world_from_map(grid), 0.1, grid.bounds())
    assert (again.cells == cells).all()
    assert again.is_aligned_with(grid)


def test_what_lies_outside_the_bounds_is_left_out():
    world = World(NO_WALLS, obstacles=(BOX,))
    assert not occupancy_of(world, 0.1, (-5.0, -5.0, 0.0, 0.0)).occupied().any()
    clipped = occupancy_of(world, 0.1, (2.0, 1.0, 4.0, 3.0))
    assert clipped.occupied().any()
    assert clipped.cells[0, 0] == 100


@pytest.mark.parametrize(
    ('resolution', 'bounds'),
    [
        (0.1, (0.0, 0.0, 0.0, 1.0)),
        (0.1, (1.0, 0.0, 0.0, 1.0)),
        (1e-5, (0.0, 0.0, 8.0, 8.0)),
        (math.nan, (0.0, 0.0, 8.0, 8.0)),
    ],
)
def test_a_true_map_without_cells_or_with_too_many_is_refused(resolution, bounds):
    with pytest.raises(MapError, match='cannot be drawn'):
        occupancy_of(World(NO_WALLS), resolution, bounds)


@pytest.fixture(params=engines_with('has_world'))
def make(request):
    """Make physics simulators that are closed after the test."""
    pytest.importorskip(ENGINES[request.param].package)
    made = []

    def make_one(*obstacles):
        made.append(make_simulator(request.param, ROBOT, World(NO_WALLS, obstacles=obstacles)))
        return made[-1]

    yield make_one
    for simulator in made:
        simulator.close()


def touching(simulator, steps=5):
    for _ in range(steps):
        simulator.step(POSTURE, np.zeros(12))
    return {contact.other for contact in simulator.observe().contacts}


# The left front foot's ball ends at y = 0.316.
NEAR_FOOT = {
    'box': lambda gap: Obstacle.box(Pose2D(0.2, 0.316 + gap + 0.1, math.pi / 2), 0.2, 0.3, 0.3),
    'cylinder': lambda gap: Obstacle.cylinder(0.201, 0.316 + gap + 0.15, 0.15, 0.3),
}


@pytest.mark.parametrize('kind', NEAR_FOOT)
def test_an_obstacle_is_met_where_it_stands(make, kind):
    assert touching(make(NEAR_FOOT[kind](-0.004)), steps=1) == {'obstacle'}
    assert touching(make(NEAR_FOOT[kind](0.006))) == set()


def test_obstacles_come_go_and_take_the_place_of_their_namesakes(make):
    simulator = make(BOX)
    near, far = NEAR_FOOT['box'](-0.004), CYLINDER
    assert touching(simulator) == set()
    simulator.put_obstacle('crate', near)
    assert simulator.obstacles == {('room', 0): BOX, 'crate': near}
    assert touching(simulator, steps=1) == {'obstacle'}
    simulator.put_obstacle('crate', far)
    assert simulator.obstacles == {('room', 0): BOX, 'crate': far}
    assert touching(simulator) == set()
    simulator.remove_obstacle('crate')
    simulator.remove_obstacle('crate')
    assert simulator.obstacles == {('room', 0): BOX}


def test_an_obstacle_far_away_does_not_change_the_run(make):
    states = []
    for dropped in (False, True):
        simulator = make()
        for k in range(100):
            if dropped and k == 50:
                simulator.put_obstacle('far', BOX)
            simulator.step(POSTURE + 0.1 * math.sin(0.1 * k), np.zeros(12))
        states.append(simulator.observe().position)
    assert (states[0] == states[1]).all()


def test_changes_of_obstacles_are_made_all_or_none(make):
    simulator = make(BOX)
    simulation = Simulation(simulator, ROBOT, Pose2D(-2.0, -2.0, 0.0))
    there = Obstacle.box(Pose2D(-2.0, -1.5, 0.0), 0.4, 0.4, 0.4)
    with pytest.raises(ObstacleOnRobot, match=r'would stand 0\.30 m from the middle of the robot'):
        simulation.change_obstacles([ObstacleChange('a', CYLINDER), ObstacleChange('b', there)])
    assert simulator.obstacles == {('room', 0): BOX}
    simulation.change_obstacles([ObstacleChange('a', CYLINDER), ObstacleChange('x', None)])
    assert simulator.obstacles == {('room', 0): BOX, 'a': CYLINDER}
    simulation.change_obstacles([ObstacleChange(None, None), ObstacleChange('c', BOX)])
    assert simulator.obstacles == {'c': BOX}


def test_without_physics_there_are_neither_obstacles_nor_pictures():
    simulation = Simulation(KinematicSimulator(ROBOT), ROBOT, Pose2D(0.0, 0.0, 0.0))
    camera = SimulatedCamera(CameraModel.looking_down((0.0, 0.0, 3.0), 0.0, 1.0))
    for ask in (
        lambda: simulation.change_obstacles([ObstacleChange('a', CYLINDER)]),
        lambda: simulation.put_goal_marker(Pose2D(0.0, 0.0, 0.0)),
        lambda: simulation.picture(camera, np.random.default_rng(0)),
    ):
        with pytest.raises(NotSimulated, match="set 'backend' to 'bullet'"):
            ask()
