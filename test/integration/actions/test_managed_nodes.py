"""Nodes with managed:=true do nothing until they are activated, nor once they are not."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from harness import WARN, Bench
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState

from quad_common.planar_pose import Pose2D

pytestmark = pytest.mark.ros

GOAL = Pose2D(6.8, 4.8, 1.57)


def change(bench: Bench, node: str, label: str) -> bool:
    request = ChangeState.Request(transition=Transition(label=label))
    return bench.call(f'{node}/change_state', ChangeState, request).success


def state(bench: Bench, node: str) -> str:
    return bench.call(f'{node}/get_state', GetState).current_state.label


def test_managed_nodes_work_only_while_they_are_active(composed_bench: Bench):
    bench = composed_bench
    bench.start('sim_node')
    bench.start('planner_node', managed=True)
    bench.start('gait_node', managed=True)
    events = bench.hear(TransitionEvent, 'planner_node/transition_event')
    for node in ('planner_node', 'gait_node'):
        bench.wait_for_status(node, 'is unconfigured', level=WARN)
        assert state(bench, node) == 'unconfigured'
    bench.wait_for_robot()
    with bench.expects('planner_node', 'planner_node is unconfigured'):
        bench.give_goal(GOAL)
    assert bench.plans == []
    assert not change(bench, 'planner_node', 'activate')

    for node in ('planner_node', 'gait_node'):
        assert change(bench, node, 'configure')
        assert change(bench, node, 'activate')
        assert state(bench, node) == 'active'
    bench.wait_until('both are heard', lambda: len(events) == 2)
    assert [event.goal_state.label for event in events] == ['inactive', 'active']
    answer = bench.call('gait_node/get_available_transitions', GetAvailableTransitions)
    labels = [each.transition.label for each in answer.available_transitions]
    assert labels == ['deactivate', 'shutdown']

    bench.give_goal(GOAL)
    bench.wait_for_walking()
    assert change(bench, 'gait_node', 'deactivate')
    bench.wait_for_status('gait_node', 'is inactive', level=WARN)
    bench.wait_until('the robot stands', lambda: bench.activity == 'standing')
    # Its planner has no goal any more either, and the robot stays when it is activated again.
    assert change(bench, 'gait_node', 'activate')
    bench.wait_until('the plan is taken back', lambda: bench.plan is None)
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    assert change(bench, 'planner_node', 'deactivate')
    bench.wait_until('the robot stands', lambda: bench.activity == 'standing')
