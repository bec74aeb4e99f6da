"""Where nav2_msgs is not installed nodes say so once, and work as ever."""

from __future__ import annotations

import os

import pytest

pytest.importorskip('rclpy')

from harness import OK, Bench

from quad_common.planar_pose import Pose2D

pytestmark = pytest.mark.ros

SENTENCE = 'nav2_msgs is not installed: no actions are served'


def test_without_nav2_msgs_there_are_no_actions_and_goals_go_by_topic(
    bench: Bench, tmp_path, monkeypatch
):
    package = tmp_path / 'nav2_msgs'
    package.mkdir()
    (package / '__init__.py').write_text("raise ImportError('not here')\n")
    paths = [str(tmp_path), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(path for path in paths if path))
    bench.start_robot()
    for node in ('planner_node', 'gait_node'):
        log = bench.processes[node].log_tail(1000)
        assert log.count(SENTENCE) == 1
        services = bench.node.get_service_names_and_types_by_node(node, '/')
        assert not any('/_action/' in name for name, _ in services)
    bench.give_goal(Pose2D(1.8, 1.2, 0.0))
    bench.wait_until('a plan', lambda: bench.plan is not None)
    bench.wait_for_status('planner_node', 'plan of', level=OK)
