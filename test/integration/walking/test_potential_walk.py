"""A robot walks down a potential, out of a pocket in which the paper's would stick."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from harness import ERROR, OK, Bench

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import grid_message

pytestmark = pytest.mark.ros

START, GOAL = Pose2D(1.2, 2.0, 0.0), Pose2D(2.8, 2.0, 0.0)


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is where the robot walks."""
    return composed_bench


def pocket():
    """5 m x 4 m; before the robot a wall that bends towards it."""
    cells = np.zeros((80, 100), np.int8)
    cells[34:47, 40:42] = 100
    cells[[34, 46], 37:42] = 100
    return grid_message(OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)), 'map', Time())


def start_nodes(bench: Bench, **planner_parameters):
    bench.start('sim_node', map_file='none', start_pose=[START.x, START.y, START.yaw])
    bench.start('planner_node', method='potential', **planner_parameters)
    bench.wait_for_status('planner_node', 'no map')
    bench.publish_map(pocket())


def test_it_walks_round_the_pocket_along_arcs(bench: Bench):
    start_nodes(bench, path_deviation=0.01, influence=0.3)
    bench.start('gait_node', gait='trot', turning='arc', corner_deviation=0.02)
    bench.wait_for_status('gait_node', 'standing')
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL, simulated_timeout=600.0)
    [plan] = bench.plans
    assert len(plan.poses) > 8
    assert np.abs(plan.corners[:, 1] - START.y).max() > 0.6


def test_the_papers_descent_sticks_and_diagnostics_say_where(bench: Bench):
    start_nodes(bench, potential='paper')
    bench.wait_for_status('planner_node', 'ready', level=OK)
    bench.give_goal(GOAL)
    words = 'a local minimum: attraction and repulsion are equal there'
    bench.wait_for_status('planner_node', words, level=ERROR, code=208)
    assert bench.plans == []
