"""Where nav2_msgs is not installed nodes say so once, and serve no actions."""

from __future__ import annotations

import os

import pytest

pytest.importorskip('rclpy')

from harness import Bench

pytestmark = pytest.mark.ros

SENTENCE = 'nav2_msgs is not installed: no actions are served'


def test_without_nav2_msgs_there_are_no_actions_and_goals_come_by_topic(
    bench: Bench, tmp_path, monkeypatch
):
    package = tmp_path / 'nav2_msgs'
    package.mkdir()
    (package / '__init__.py').write_text("raise ImportError('not here')\n")
    paths = [str(tmp_path), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(path for path in paths if path))
    for node in ('planner_node', 'gait_node'):
        bench.start(node)
        bench.wait_for_status(node, '')
        log = bench.processes[node].log_tail(1000)
        assert log.count(SENTENCE) == 1
        assert not any('/_action/' in name for name in bench.services_of(node))
    bench.wait_until(
        'goals are subscribed to',
        lambda: bench.node.count_subscribers('goal_pose') == 1,
    )
