"""Fixtures of the tests that start real nodes."""

from __future__ import annotations

import pytest


@pytest.fixture
def domain(tmp_path, monkeypatch):
    """Claim a ROS domain that nobody else on this machine hears."""
    from quad_lab.topic_walk.node_processes import isolated_domain

    monkeypatch.delenv('ROS_DOMAIN_ID', raising=False)
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'ros_log'))
    with isolated_domain() as number:
        yield number


@pytest.fixture
def process_bench(domain):
    """Give a bench to start nodes on, as processes; see `harness.Bench`."""
    from harness import Bench

    with Bench() as bench:
        yield bench


@pytest.fixture
def bench(process_bench):
    """Give the bench of a module: nodes are processes unless it says otherwise."""
    return process_bench


@pytest.fixture
def composed_bench(domain):
    """Give a bench that makes its nodes in this process; see `composed_bench.ComposedBench`."""
    from composed_bench import ComposedBench

    with ComposedBench() as bench:
        yield bench


@pytest.fixture
def make_node(domain):
    """Make gait nodes in this process, each with a simulation; see `node_in_process`."""
    import rclpy
    from node_in_process import NodeInProcess
    from rclpy.parameter import Parameter

    from quad_gait.gait_node import GaitNode

    context = rclpy.Context()
    rclpy.init(context=context)
    robots = []

    def make(backend='kinematic', **parameters):
        # Time is odometry's here: nothing publishes a clock.
        given = {'use_sim_time': False, **parameters}
        overrides = [Parameter(key, value=value) for key, value in given.items()]
        robots.append(
            NodeInProcess(GaitNode(context=context, parameter_overrides=overrides), backend)
        )
        return robots[-1]

    yield make
    for robot in robots:
        robot.simulation.close()
        robot.node.destroy_node()
    context.try_shutdown()
