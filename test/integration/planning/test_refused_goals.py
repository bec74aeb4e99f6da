"""A goal that cannot be walked to is refused with its reason; the plan before it stays."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped
from harness import ERROR, Bench

from quad_common.maps.map_file import save_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_message

pytestmark = pytest.mark.ros

GOAL = Pose2D(2.0, 1.2, 0.0)


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what the planner says."""
    return composed_bench


@pytest.fixture
def two_rooms(tmp_path):
    """A map of 8 m x 5 m: two rooms, and no door between them."""
    cells = np.zeros((100, 160), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    cells[:, 100:104] = 100
    path = tmp_path / 'two_rooms.yaml'
    save_map(OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)), path)
    return str(path)


def goal(x=1.0, y=1.0, yaw=0.0, **orientation):
    message = PoseStamped(pose=pose_message(Pose2D(x, y, yaw)))
    for axis, value in orientation.items():
        setattr(message.pose.orientation, axis, value)
    return message


REFUSED = {
    'in a wall': (goal(5.1, 2.0), 'map', 206, 'from the nearest occupied'),
    'too near to a wall': (goal(0.3, 2.0), 'map', 206, 'the robot needs'),
    'outside the map': (goal(-3.0, 2.0), 'map', 204, 'is outside the map, which spans'),
    'in the other room': (goal(6.5, 2.5), 'map', 208, 'no path from'),
    'not a number': (goal(math.nan, 2.0), 'map', 200, 'nan'),
    'infinitely far': (goal(2.0, math.inf), 'map', 200, 'inf'),
    'no rotation': (goal(2.0, 2.0, w=0.0), 'map', 200, 'has length 0'),
    'an unknown frame': (goal(2.0, 2.0), 'moon', 202, "frame 'moon'"),
}


def test_a_refused_goal_is_explained_and_the_plan_before_it_stays(bench: Bench, two_rooms):
    bench.start_robot(map_file=two_rooms)
    bench.give_goal(GOAL)
    bench.wait_until('a plan', lambda: bench.plan is not None)
    for message, frame, code, words in REFUSED.values():
        with bench.expects('planner_node', words, level=ERROR, code=code):
            bench.give_goal(message, frame)
    bench.wait_for_arrival(GOAL)
    assert len(bench.plans) == 1


@pytest.mark.parametrize(
    ('start', 'code', 'words'),
    [
        pytest.param([-2.0, 1.0, 0.0], 203, 'the start (-2.00, 1.00) m is outside', id='outside'),
        pytest.param([5.1, 2.0, 0.0], 205, 'the start (5.10, 2.00) m is 0.00 m', id='in a wall'),
    ],
)
def test_a_robot_where_it_cannot_stand_is_told_so(bench: Bench, two_rooms, start, code, words):
    bench.start('sim_node', map_file=two_rooms, start_pose=start)
    bench.start('planner_node')
    bench.wait_for_status('planner_node', 'ready')
    bench.give_goal(GOAL)
    bench.wait_for_status('planner_node', words, level=ERROR, code=code)
    assert bench.plans == []
