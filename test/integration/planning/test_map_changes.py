"""A map that changes in the middle of a walk changes the plan."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from harness import ERROR, OK, Bench
from std_srvs.srv import SetBool

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D, distance_to_polyline
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import grid_message

pytestmark = pytest.mark.ros

RESOLUTION = 0.05
START, GOAL = Pose2D(1.0, 2.5, 0.0), Pose2D(3.4, 2.5, 0.0)


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what is planned and walked."""
    return composed_bench


def room(wall: slice | None = None):
    """5 m x 5 m, in its middle a wall over these rows."""
    cells = np.zeros((100, 100), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    if wall is not None:
        cells[wall, 48:50] = 100
    grid = OccupancyGrid(cells, RESOLUTION, Pose2D(0.0, 0.0, 0.0))
    return grid, grid_message(grid, 'map', Time())


def test_a_walk_follows_the_map_as_it_changes(bench: Bench):
    start = [START.x, START.y, START.yaw]
    bench.start('sim_node', map_file='none', start_pose=start)
    bench.start('planner_node')
    bench.start('gait_node')
    bench.wait_for_status('planner_node', 'no map')
    bench.wait_for_status('gait_node', 'standing')
    # Given before there is a map, the goal waits for it.
    bench.give_goal(GOAL)
    bench.publish_map(room()[1])
    bench.wait_for_walking()
    [straight] = bench.plans
    assert np.abs(straight.corners[:, 1] - START.y).max() < 0.05

    # A wall with a path around it.
    grid, message = room(slice(42, 58))
    bench.publish_map(message)
    bench.wait_until('a plan around the wall', lambda: len(bench.plans) == 2)
    assert np.abs(bench.plan.corners[:, 1] - START.y).max() > 0.5
    assert bench.plan.poses[-1] == straight.poses[-1]
    clearance = load_robot('titan_viii').footprint_radius
    for row, column in np.argwhere(grid.occupied()):
        x, y = grid.map_to_world(np.array([column + 0.5, row + 0.5]))
        assert distance_to_polyline((x, y), bench.plan.corners) > clearance
    bench.wait_for_status('planner_node', 'plan of', level=OK, code=0)

    # A wall from side to side.
    bench.publish_map(room(slice(None))[1])
    bench.wait_for_status('planner_node', 'no path from', level=ERROR, code=208)
    bench.wait_until('the plan is taken back', lambda: bench.plan is None)
    bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)
    stopped, since = bench.pose, bench.elapsed
    bench.wait_until('ten seconds go by', lambda: bench.elapsed > since + 10.0)
    assert bench.pose.distance_to(stopped) < 1e-6
    assert not bench.is_near(GOAL)

    # And none again.
    bench.publish_map(room()[1])
    bench.wait_for_arrival(GOAL)


def test_a_robot_that_is_stopped_while_there_is_no_path_stays_when_there_is_one(bench: Bench):
    start = [START.x, START.y, START.yaw]
    bench.start('sim_node', map_file='none', start_pose=start)
    bench.start('planner_node')
    bench.start('gait_node')
    for service in ('stop', 'stand'):
        bench.client(service)
    bench.client('emergency_stop', SetBool)
    bench.publish_map(room()[1])
    for stop in ('stop', 'emergency stop'):
        bench.wait_for_status('planner_node', 'ready', level=OK)
        bench.give_goal(GOAL)
        bench.wait_for_walking()
        bench.publish_map(room(slice(None))[1])
        bench.wait_for_status('planner_node', 'no path from', level=ERROR, code=208)
        bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)
        if stop == 'stop':
            assert bench.call('stop').success
        else:
            bench.call('emergency_stop', SetBool, SetBool.Request(data=True))
            bench.call('emergency_stop', SetBool, SetBool.Request(data=False))
            assert bench.call('stand').success
        bench.publish_map(room()[1])
        bench.wait_for_status('planner_node', 'ready', level=OK)
        stopped, until = bench.pose, bench.elapsed + 10.0
        bench.wait_until('ten seconds go by', lambda until=until: bench.elapsed > until)
        assert bench.pose.distance_to(stopped) < 1e-6
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL)


def test_a_planner_without_a_map_says_why_the_last_one_was_refused(bench: Bench):
    bench.start('sim_node', map_file='none', start_pose=[START.x, START.y, START.yaw])
    bench.start('planner_node', largest_map=9999)
    bench.wait_for_status('planner_node', 'no map: waiting')
    bench.publish_map(room()[1])
    refused = "no map: the one on 'map' is refused: the map has 100 x 100 cells"
    bench.wait_for_status('planner_node', refused, level=ERROR)
    cells = np.zeros((60, 60), np.int8)
    smaller = OccupancyGrid(cells, RESOLUTION, Pose2D(0.0, 0.0, 0.0))
    bench.publish_map(grid_message(smaller, 'map', Time()))
    bench.wait_for_status('planner_node', 'ready', level=OK)
