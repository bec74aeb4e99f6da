"""The planner's first work may end at any time: its answer is heard all the same."""

from __future__ import annotations

import threading

import pytest

pytest.importorskip('rclpy')

import rclpy

from quad_common.ros.run_node import make_executor
from quad_planner.methods.planner import Planner
from quad_planner.session import planning_session

pytestmark = pytest.mark.ros


def test_work_that_ends_at_once_is_answered(domain, monkeypatch):
    from quad_planner.planner_node import PlannerNode

    warmed, answered = threading.Event(), threading.Event()
    monkeypatch.setattr(Planner, 'warm_up', lambda self: warmed.set())
    note_warm = planning_session._note_warm
    monkeypatch.setattr(
        planning_session,
        '_note_warm',
        lambda output, result: (note_warm(output, result), answered.set()),
    )
    context = rclpy.Context()
    rclpy.init(context=context, args=['--ros-args', '-p', 'use_sim_time:=false'])
    node = PlannerNode(context=context)
    executor = make_executor(context)
    try:
        # Time enough for the work to end before there is an executor to hear of it.
        warmed.wait(0.2)
        executor.add_node(node)
        for _ in range(100):
            if answered.is_set():
                break
            executor.spin_once(timeout_sec=0.1)
        assert warmed.is_set()
        assert answered.is_set()
    finally:
        node.destroy_node()
        executor.shutdown()
        context.try_shutdown()
