"""Robots on one map give way to one another, and arrive."""

import math

import numpy as np

from quad_common.maps.occupancy_grid import OCCUPIED, OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_lab.fleet.fleet_walk import FleetWalk, Member
from quad_lab.tools.fleet_maps import corridor, warehouse


def walk(members, grid, timeout=120.0):
    """Walk without physics, where only distances tell whether robots would touch."""
    fleet = FleetWalk(members, grid, 'kinematic')
    return fleet, fleet.run(timeout)


def test_two_that_meet_in_a_corridor_both_get_through():
    grid, left, right = corridor()
    members = {
        'robot1': Member('a1', left, Pose2D(right.x, right.y, 0.0)),
        'robot2': Member('a1', right, Pose2D(left.x, left.y, math.pi)),
    }
    _, record = walk(members, grid)
    assert record.arrived.keys() == members.keys()
    assert record.least_gap > 0.0
    assert 'robot2: giving way to robot1' in record.waits
    assert not any(wait.startswith('robot1: giving way') for wait in record.waits)


def test_one_that_cannot_give_way_goes_first():
    grid, _, right = corridor()
    cells = grid.cells.copy()
    # The right room is walled off just behind the corridor's end: a dead end.
    end = round(7.0 / grid.resolution)
    cells[:, end : end + 3] = OCCUPIED
    dead_end = OccupancyGrid(cells, grid.resolution, grid.origin)
    y = right.y
    members = {
        'robot1': Member('a1', Pose2D(1.5, y, 0.0), Pose2D(6.2, y, 0.0)),
        'robot2': Member('a1', Pose2D(6.0, y, math.pi), Pose2D(1.5, y + 0.9, math.pi)),
    }
    _, record = walk(members, dead_end)
    assert record.arrived.keys() == members.keys()
    assert record.least_gap > 0.0


def test_three_kinds_cross_a_warehouse():
    # Two go to where the other was, and one across their way; the benchmark has four.
    grid, corners = warehouse()
    members = {
        f'robot{k + 1}': Member(kind, corners[k], corners[(k + 2) % 4])
        for k, kind in enumerate(('a1', 'cuhk', 'titan_viii'))
    }
    _, record = walk(members, grid, 400.0)
    assert record.arrived.keys() == members.keys()
    assert record.least_gap > 0.0


def test_a_robot_that_stays_is_walked_around():
    free = OccupancyGrid(np.zeros((80, 120), np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
    members = {
        'robot1': Member('a1', Pose2D(3.0, 2.0, 0.0), Pose2D(3.0, 2.0, 0.0)),
        'robot2': Member('a1', Pose2D(1.0, 2.0, 0.0), Pose2D(5.0, 2.0, 0.0)),
    }
    fleet, record = walk(members, free)
    assert record.arrived.keys() == members.keys()
    assert record.least_gap > 0.0
    assert fleet.poses['robot1'].distance_to(Pose2D(3.0, 2.0, 0.0)) < 0.05
