"""While footholds are looked for on a new height map, the planner answers everything else."""

from __future__ import annotations

import threading

import numpy as np
import pytest

pytest.importorskip('rclpy')

import rclpy
from nav_msgs.srv import GetPlan
from rcl_interfaces.srv import GetParameters
from std_msgs.msg import Header

from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_message
from quad_common.ros.run_node import make_executor
from quad_planner.footing.footing import Footing
from quad_planner.methods.planner import Planner
from quad_planner.methods.planner_options import within

pytestmark = pytest.mark.ros

START, GOAL = Pose2D(1.0, 1.5, 0.0), Pose2D(3.0, 1.5, 0.0)


def test_the_node_is_not_deaf_while_footholds_are_looked_for(domain, monkeypatch):
    from quad_planner.planner_node import PlannerNode

    begun, released = threading.Event(), threading.Event()
    fill = Footing._fill

    def slow_fill(*args):
        begun.set()
        assert released.wait(60.0)
        fill(*args)

    monkeypatch.setattr(Footing, '_fill', slow_fill)
    monkeypatch.setattr(Planner, 'warm_up', lambda self: None)
    context = rclpy.Context()
    rclpy.init(context=context, args=['--ros-args', '-p', 'use_sim_time:=false'])
    node, asker = PlannerNode(context=context), rclpy.create_node('asker', context=context)
    executor = make_executor(context)
    executor.add_node(node)
    executor.add_node(asker)

    def spin_until(what, is_so):
        for _ in range(600):
            if is_so():
                return
            executor.spin_once(timeout_sec=0.05)
        raise AssertionError(what)

    beats = []
    asker.create_subscription(Header, 'plan/heartbeat', beats.append, 10)
    plans = asker.create_client(GetPlan, 'get_plan')
    parameters = asker.create_client(GetParameters, 'planner_node/get_parameters')
    try:
        spin_until('services', lambda: plans.service_is_ready() and parameters.service_is_ready())
        spin_until('a first heartbeat', lambda: beats)
        grid = OccupancyGrid(np.zeros((60, 80), dtype=np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
        node._session.take_grid(grid, 'map')
        heights = HeightMap.level((0.0, 0.0, 4.0, 3.0), 0.04)
        node._session.take_heights(heights, 'map')
        request = GetPlan.Request()
        request.start.pose, request.goal.pose = pose_message(START), pose_message(GOAL)
        answers = [plans.call_async(request) for _ in range(2)]
        spin_until('footholds are looked for', begun.is_set)

        heard = len(beats)
        spin_until('heartbeats meanwhile', lambda: len(beats) >= heard + 2)
        other = parameters.call_async(GetParameters.Request(names=['method']))
        spin_until('another answer meanwhile', other.done)
        # As the traffic asks for the path of a robot that waits, in this very thread.
        with within(1.0):
            hurried = node._session.map.planner.plan(START, GOAL)
        assert not any(answer.done() for answer in answers)

        released.set()
        spin_until('every plan', lambda: all(answer.done() for answer in answers))
        for answer in answers:
            assert len(answer.result().plan.poses) == len(hurried.poses) > 1
    finally:
        released.set()
        node.destroy_node()
        asker.destroy_node()
        executor.shutdown()
        context.try_shutdown()
