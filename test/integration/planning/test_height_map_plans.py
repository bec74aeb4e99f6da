"""The planner walks over low blocks and around high ones, by the height map it receives."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from harness import ERROR, LATCHED, OK, SENSOR, Bench
from nav_msgs.msg import Odometry
from nav_msgs.srv import GetPlan
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import PointCloud2

from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.height_map_conversions import height_map_message
from quad_common.ros.pose_conversions import (
    grid_message,
    plan_from_message,
    pose_message,
)

pytestmark = pytest.mark.ros

START, GOAL = Pose2D(1.0, 2.5, 0.0), Pose2D(5.0, 2.5, 0.0)
STEP = load_robot('titan_viii').step_height


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what is planned."""
    return composed_bench


def room():
    grid = OccupancyGrid(np.zeros((100, 120), np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
    return grid_message(grid, 'map', Time())


def block(height: float, frame: str = 'map') -> PointCloud2:
    """Give level ground with a block in the middle of the room."""
    level = HeightMap.level((0.0, 0.0, 6.0, 5.0), 0.02)
    x, y = np.moveaxis(level.centers, -1, 0)
    heights = np.where((np.abs(x - 3.0) < 0.2) & (np.abs(y - 2.5) < 0.3), height, 0.0)
    return height_map_message(level.with_heights(heights), frame, Time())


def detour(bench: Bench) -> float:
    """Ask for a plan; return how far it goes aside [m]."""
    request = GetPlan.Request()
    request.start.pose, request.goal.pose = pose_message(START), pose_message(GOAL)
    plan = plan_from_message(bench.call('get_plan', GetPlan, request).plan)
    assert plan is not None
    return float(np.abs(plan.corners[:, 1] - START.y).max())


def test_plans_lead_over_what_is_low_and_around_what_is_high(bench: Bench):
    bench.start('planner_node', method='shortest', any_angle=True, use_sim_time=False)
    bench.wait_for_status('planner_node', 'no map')
    heights = bench.publisher(PointCloud2, 'height_map', LATCHED)
    # It comes before the map, and waits for it.
    heights.publish(block(STEP - 0.001))
    bench.publish_map(room())
    bench.wait_for_status('planner_node', 'no odometry')
    assert detour(bench) < 1e-3

    # A walk that is planned over it is planned again when it turns out to be high.
    pose = Odometry()
    pose.header.frame_id = 'odom'
    pose.pose.pose = pose_message(START)
    with bench.publishing('odom', pose, SENSOR):
        bench.give_goal(GOAL)
        bench.wait_until('a plan', lambda: bench.plan is not None)
        assert len(bench.plan.poses) <= 2
        heights.publish(block(STEP + 0.001))
        bench.wait_until('a plan around the block', lambda: len(bench.plans) == 2)
        assert np.abs(bench.plan.corners[:, 1] - START.y).max() > 0.7
        assert detour(bench) > 0.7

        # What is refused changes nothing.
        with bench.expects('planner_node', "it is in frame 'moon'", level=ERROR):
            heights.publish(block(0.0, 'moon'))
        broken = block(0.0)
        broken.height = 1
        with bench.expects('planner_node', 'it must be organized', level=ERROR):
            heights.publish(broken)
        bench.wait_for_status('planner_node', 'plan of', level=OK)
        assert 'it must be organized' in bench.statuses['planner_node'].values['last_error']
        assert detour(bench) > 0.7

        heights.publish(block(STEP - 0.001))
        bench.wait_until('a straight plan', lambda: len(bench.plans) == 3)
        assert detour(bench) < 1e-3


def rough_patch() -> PointCloud2:
    """Give level ground with low steps, one every 0.2 m, on most of the room's middle."""
    level = HeightMap.level((0.0, 0.0, 6.0, 5.0), 0.02)
    x, y = np.moveaxis(level.centers, -1, 0)
    is_high = (np.abs(x - 3.0) < 0.8) & (y < 3.2) & (np.floor(x / 0.1) % 2 == 0)
    return height_map_message(level.with_heights(np.where(is_high, 0.03, 0.0)), 'map', Time())


def test_plans_lead_around_rough_ground_where_that_is_quicker_and_else_over_it(bench: Bench):
    bench.start('planner_node', method='quickest', roughness_cost=1.1, use_sim_time=False)
    bench.wait_for_status('planner_node', 'no map')
    bench.publisher(PointCloud2, 'height_map', LATCHED).publish(rough_patch())
    bench.publish_map(room())
    bench.wait_for_status('planner_node', 'no odometry')
    assert detour(bench) < 1e-3
    kind = ParameterType.PARAMETER_DOUBLE
    cost = Parameter(name='roughness_cost', value=ParameterValue(type=kind, double_value=15.0))
    request = SetParameters.Request(parameters=[cost])
    [result] = bench.call('planner_node/set_parameters', SetParameters, request).results
    assert result.successful, result.reason
    assert detour(bench) > 0.7
