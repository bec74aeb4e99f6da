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
def bench(domain):
    """Give a bench to start nodes on; see `harness.Bench`."""
    from harness import Bench

    with Bench() as bench:
        yield bench
