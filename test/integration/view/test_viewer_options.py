"""What is chosen on the page is taken by the nodes, or refused with the reason."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from harness import Bench
from rcl_interfaces.srv import SetParameters

from quad_common.planar_pose import Pose2D
from quad_view.ros_conversions import option_request

pytestmark = pytest.mark.ros


def test_choices_of_the_page_are_taken_or_refused_with_the_reason(composed_bench: Bench):
    bench = composed_bench
    bench.start_robot()

    def choose(node: str, name: str, value: str) -> tuple[bool, str]:
        answer = bench.call(f'{node}/set_parameters', SetParameters, option_request(name, value))
        return answer.results[0].successful, answer.results[0].reason

    assert choose('gait_node', 'gait', 'trot') == (True, '')
    assert choose('gait_node', 'turning', 'arc') == (True, '')
    is_taken, reason = choose('planner_node', 'method', 'magic')
    assert not is_taken
    assert "'method' is 'magic'; it must be one of mesh" in reason

    goal = Pose2D(2.0, 2.4, 0.0)
    bench.give_goal(goal)
    bench.wait_until('a plan over the mesh', lambda: len(bench.plans) == 1)
    assert choose('planner_node', 'method', 'shortest') == (True, '')
    bench.give_goal(goal)
    bench.wait_until('a plan by the other method', lambda: len(bench.plans) == 2)
    mesh, shortest = bench.plans
    assert mesh is not None
    assert shortest is not None
    assert shortest.length < mesh.length + 0.05
    bench.wait_for_arrival(goal)
