"""Robots that stay are obstacles, and leave the robot that plans its own place."""

import numpy as np
import pytest

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_planner.grid.keepout_mask import with_discs
from quad_planner.methods.planner import make_planner
from quad_planner.traffic.right_of_way import Distances, is_body_ahead
from quad_planner.traffic.robot_on_map import RobotOnMap
from quad_planner.traffic.standing_bodies import StandingBodies

RADIUS = load_robot('a1').standing_radius
SAFETY = 0.05
CELL = 0.05
NOWHERE = np.empty((0, 2))


def standing(x, y, name='a'):
    return RobotOnMap(name, Pose2D(x, y, 0.0), RADIUS, NOWHERE)


@pytest.mark.parametrize('safety', [0.0, SAFETY, 0.12])
def test_past_a_robot_that_stays_there_is_a_path_and_nothing_on_it(safety):
    rng = np.random.default_rng(7)
    grid = OccupancyGrid(np.zeros((100, 160), np.int8), CELL, Pose2D(0.0, 0.0, 0.0))
    planner = make_planner('shortest', clearance_radius=RADIUS + safety, any_angle=True)
    goal = Pose2D(7.2, 2.5, 0.0)
    for _ in range(60):
        pose = Pose2D(*rng.uniform((1.0, 1.0), (3.0, 4.0)), 0.0)
        angle, apart = rng.uniform(-np.pi, np.pi), rng.uniform(2.0 * RADIUS + 0.02, 2.5)
        other = standing(pose.x + apart * np.cos(angle), pose.y + apart * np.sin(angle))
        bodies = StandingBodies()
        bodies.place(pose, [other], planner.clearance_radius, CELL)
        planner.set_map(with_discs(grid, bodies.discs))
        plan = planner.plan(pose, goal)
        own = RobotOnMap('b', pose, RADIUS, plan.corners)
        assert not is_body_ahead(own, other, Distances(), other.name in bodies)


def test_a_path_from_before_the_robot_stayed_is_stopped_on():
    own = RobotOnMap('b', Pose2D(0.0, 0.0, 0.0), RADIUS, np.array([[0.0, 0.0], [4.0, 0.0]]))
    assert is_body_ahead(own, standing(1.3, 0.1), Distances(), is_obstacle=True)


def test_a_body_stays_as_it_was_drawn_while_both_hardly_move():
    bodies = StandingBodies()
    bodies.place(Pose2D(0.0, 0.0, 0.0), [standing(0.8, 0.0)], RADIUS + SAFETY, CELL)
    before = bodies.discs
    assert before[0][2] < RADIUS
    bodies.place(Pose2D(-0.05, 0.0, 0.0), [standing(0.81, 0.01)], RADIUS + SAFETY, CELL)
    assert bodies.discs == before
    bodies.place(Pose2D(-1.0, 0.0, 0.0), [standing(0.81, 0.01)], RADIUS + SAFETY, CELL)
    assert bodies.discs == ((0.8, 0.0, RADIUS),)
    bodies.place(Pose2D(-1.0, 0.0, 0.0), [standing(0.87, 0.0)], RADIUS + SAFETY, CELL)
    assert bodies.discs == ((0.87, 0.0, RADIUS),)
    bodies.place(Pose2D(-1.0, 0.0, 0.0), [], RADIUS + SAFETY, CELL)
    assert bodies.discs == ()
    assert 'a' not in bodies


def test_a_robot_upon_this_one_is_no_obstacle():
    bodies = StandingBodies()
    bodies.place(Pose2D(0.0, 0.0, 0.0), [standing(0.3, 0.0)], RADIUS + SAFETY, CELL)
    assert 'a' not in bodies
