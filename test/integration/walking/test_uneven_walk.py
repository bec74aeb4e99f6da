"""The three nodes walk a robot over uneven ground, by topics alone."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

pytest.importorskip('rclpy')

from harness import EVERY_SAMPLE, OK, PHYSICS, START, Bench
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import orientation_from_odometry, seconds_from_time
from quad_common.rotations import tilt_from_quaternion

pytestmark = pytest.mark.ros

GOAL = START @ Pose2D(0.9, 0.0, 0.0)


def start_nodes(bench: Bench, terrain: str, **simulator):
    bench.start(
        'sim_node',
        backend=PHYSICS,
        terrain=terrain,
        terrain_clear=0.5,
        **simulator,
    )
    bench.start('planner_node', method='shortest', any_angle=True)
    bench.start('gait_node', ground='uneven')
    bench.wait_for_status('planner_node', 'ready', level=OK)
    bench.wait_for_status('gait_node', 'standing', level=OK)
    bench.wait_for_robot()


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('sees', [True, False])
def test_it_climbs_a_kerb_with_its_body_level(composed_bench: Bench, sees: bool):
    bench = composed_bench
    start_nodes(bench, 'kerb:height=0.04,length=2.0', publish_height_map=sees)
    heard = bench.hear(Odometry, 'odom', EVERY_SAMPLE)
    beats = bench.hear(Header, 'gait/heartbeat', EVERY_SAMPLE)
    lowest = bench.odometry.pose.pose.position.z
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL, simulated_timeout=120.0)
    assert bench.odometry.pose.pose.position.z == pytest.approx(lowest + 0.04, abs=0.01)
    tilts = [tilt_from_quaternion(orientation_from_odometry(message)) for message in heard]
    assert max(tilts) < math.radians(6.0)
    # The simulator waits for each answer: feet that feel for the ground are told when to stop.
    answered = [seconds_from_time(beat.stamp) for beat in beats]
    assert max(after - before for before, after in pairwise(answered)) < 0.05


def test_a_gait_on_two_feet_is_refused_in_a_sentence(bench: Bench):
    bench.start('gait_node', ground='uneven', gait='trot')
    died = bench.wait_for_end('gait_node')
    assert 'must be one with three feet on the ground' in str(died)
