"""Nodes begin with valid parameters only, and end quietly."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from harness import Bench

from quad_common.planar_pose import Pose2D

pytestmark = pytest.mark.ros

INVALID = [
    ('gait_node', {'settle_time': -1}, "'settle_time' is -1; it must be a finite number from 0"),
    ('gait_node', {'settle_time': float('nan')}, "'settle_time' is nan; it must be a finite"),
    ('gait_node', {'gait': 'gallop'}, "'gait' is 'gallop'; it must be one of crawl,"),
    ('gait_node', {'use_sim_time': 'perhaps'}, "'use_sim_time' to 'perhaps'"),
    ('planner_node', {'robot': 'unicorn'}, "there is no robot 'unicorn'; available: "),
    ('planner_node', {'robot': 5}, "'robot' is 5; it must be a text"),
    ('planner_node', {'method': 'magic'}, "'method' is 'magic'; it must be one of mesh"),
    ('sim_node', {'map_file': '/nowhere.yaml'}, 'map file /nowhere.yaml cannot be read: '),
    ('sim_node', {'start_pose': [1.0, 2.0]}, "'start_pose' is [1.0, 2.0]; it must be 3 finite"),
    ('sim_node', {'seed': -1}, "'seed' is -1; it must be a whole number of at least 0"),
]


@pytest.mark.parametrize(('node', 'parameters', 'words'), INVALID)
def test_an_invalid_parameter_ends_a_node_with_one_sentence(bench: Bench, node, parameters, words):
    bench.start(node, **parameters)
    end = bench.wait_for_end(node)
    assert end.code == 2
    [sentence] = end.log.splitlines()
    assert sentence.startswith('error: ')
    assert words in sentence


def test_whole_numbers_will_do_where_others_are_expected(bench: Bench):
    bench.start('sim_node', start_pose=[2, 3, 0])
    bench.wait_until('odometry', lambda: bench.odometry is not None)
    assert bench.is_near(Pose2D(2.0, 3.0, 0.0))


@pytest.mark.parametrize('gap', [0.0, 0.01, 0.1])
def test_two_interrupts_end_every_node_quietly_in_the_middle_of_a_walk(bench: Bench, gap):
    bench.start_robot()
    bench.give_goal(Pose2D(2.0, 1.2, 0.0))
    bench.wait_for_walking()
    for node, process in bench.processes.items():
        assert bench.interrupt(node, gap) == 0, node
        assert 'Traceback' not in process.log_tail(1000)
