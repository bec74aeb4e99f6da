"""What an installation lacks is said once, and where it was asked for by a parameter, at once."""

from __future__ import annotations

import os

import pytest

pytest.importorskip('rclpy')

from harness import Bench

pytestmark = pytest.mark.ros


@pytest.fixture
def without(tmp_path, monkeypatch):
    """Have nodes begin where packages of messages are not installed."""

    def hide(*packages):
        for package in packages:
            (tmp_path / package).mkdir()
            (tmp_path / package / '__init__.py').write_text("raise ImportError('not here')\n")
        paths = [str(tmp_path), os.environ.get('PYTHONPATH', '')]
        monkeypatch.setenv('PYTHONPATH', os.pathsep.join(path for path in paths if path))

    return hide


def test_without_simulation_interfaces_robots_come_by_the_parameter(bench: Bench, without):
    without('simulation_interfaces')
    bench.start('sim_node', robots='none')
    bench.wait_for_status('sim_node', 'running')
    sentence = 'simulation_interfaces is not installed: robots are spawned by the parameter'
    assert bench.processes['sim_node'].log_tail(1000).count(sentence) == 1
    offered = bench.services_of('sim_node').values()
    assert not any('simulation_interfaces' in kind for kinds in offered for kind in kinds)


def test_without_control_msgs_no_gait_begins_that_needs_it(bench: Bench, without):
    without('control_msgs')
    bench.start('gait_node', trajectory_action='arm/follow_joint_trajectory')
    ended = bench.wait_for_end('gait_node')
    assert "this needs the package 'control_msgs'" in str(ended)
    assert 'Traceback' not in bench.processes['gait_node'].log_tail(1000)
