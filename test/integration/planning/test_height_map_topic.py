"""The simulator publishes its ground, for who listens late too, and a robot stands on it."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from harness import LATCHED, OK, PHYSICS, START, Bench
from sensor_msgs.msg import PointCloud2

from quad_common.ros.height_map_conversions import height_map_from_message
from quad_sim.world.terrain_spec import make_terrain, specs_from_text

pytestmark = pytest.mark.ros


def test_the_height_map_is_that_of_the_ground_and_the_robot_is_on_it(composed_bench: Bench):
    bench = composed_bench
    text = 'cross_slope:angle=0.1+boxes'
    bench.start('sim_node', backend=PHYSICS, map_file='none', terrain=text, terrain_seed=3)
    bench.wait_for_status('sim_node', 'running', level=OK)
    heard = bench.hear(PointCloud2, 'height_map', LATCHED)
    bench.wait_until('a height map', lambda: bool(heard))
    heights = height_map_from_message(heard[0], ('map',))
    bench.wait_for_robot()
    start = bench.odometry.pose.pose.position
    assert heights.bounds == pytest.approx(
        (START.x - 5.0, START.y - 5.0, START.x + 5.0, START.y + 5.0), abs=1e-4
    )
    terrain = make_terrain(
        specs_from_text(text, seed=3), heights.bounds, START, ((START.x, START.y),)
    )
    points = np.random.default_rng(0).uniform(heights.bounds[:2], heights.bounds[2:], (500, 2))
    differences = np.abs(heights.height_at(points) - terrain.height_map.height_at(points))
    assert np.median(differences) < 1e-5
    bench.wait_until('a second', lambda: bench.elapsed > 1.0)
    last = bench.odometry.pose.pose.position
    assert math.hypot(last.x - start.x, last.y - start.y) < 0.02
    assert last.z == pytest.approx(0.26, abs=0.02)


def test_flat_ground_has_no_height_map(composed_bench: Bench):
    bench = composed_bench
    bench.start('sim_node', backend=PHYSICS, map_file='none')
    bench.wait_for_status('sim_node', 'running', level=OK)
    heard = bench.hear(PointCloud2, 'height_map', LATCHED)
    bench.wait_until('half a second', lambda: bench.elapsed > 0.5)
    assert heard == []


def test_unwelcome_ground_ends_the_node(bench: Bench):
    bench.start('sim_node', backend='kinematic', terrain='bumps')
    died = bench.wait_for_end('sim_node')
    assert 'does not support uneven ground' in str(died)
