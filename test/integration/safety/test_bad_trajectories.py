"""The simulator refuses a malformed joint trajectory with a reason, and holds still."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Pose, PoseStamped, Vector3
from harness import ERROR, WARN, Bench
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import pose_message

pytestmark = pytest.mark.ros

ROBOT = load_robot('titan_viii')
NAMES = list(ROBOT.joint_names)
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
MOVED = POSTURE + 0.1


def trajectory(names=NAMES, positions=MOVED, velocities=(), times=(1,), stamp=0) -> JointTrajectory:
    """To one posture, from the time of arrival unless a stamp [s] is given."""
    message = JointTrajectory(joint_names=list(names))
    message.header.stamp = Time(sec=stamp)
    message.points = [
        JointTrajectoryPoint(
            positions=list(positions), velocities=list(velocities), time_from_start=Duration(sec=t)
        )
        for t in times
    ]
    return message


REFUSED = {
    'times before the start': (trajectory(times=(-1, 1)), 'must rise, from zero or later'),
    'unknown joint': (trajectory(['tail_joint', *NAMES[1:]]), "there is no joint 'tail_joint'"),
    'missing joint': (trajectory(NAMES[1:], MOVED[1:]), f'leaves out {NAMES[0]}'),
    'joint named twice': (trajectory([NAMES[1], *NAMES[1:]]), 'names a joint twice'),
    'no joints': (trajectory([], []), 'names no joints'),
    'no points': (trajectory(times=()), 'has 0 points'),
    'too few positions': (trajectory(positions=MOVED[1:]), 'has 11 positions'),
    'too many velocities': (trajectory(velocities=[0.0] * 13), '13 velocities for 12 joints'),
    'not a number': (trajectory(positions=[math.nan, *MOVED[1:]]), 'positions that are not finite'),
    'infinite velocity': (trajectory(velocities=[math.inf] * 12), 'velocities that are not finite'),
    'times that fall': (trajectory(times=(2, 1)), 'must rise'),
    'without end': (trajectory(times=range(1, 20_002)), '20001 points; 20000 are the most'),
    'a giant name': (trajectory(['x' * 1_000_000, *NAMES[1:]]), '1000000 characters'),
    'of another clock': (trajectory(stamp=1), 'the trajectory ended at 2.000 s'),
}


def obstacle(**fields) -> MarkerArray:
    """Put a box of 1 m at (3, 3) m, with other fields than that."""
    marker = Marker(ns='box', type=Marker.CUBE, pose=pose_message(Pose2D(3.0, 3.0, 0.0)))
    marker.header.frame_id = 'map'
    marker.scale = Vector3(x=1.0, y=1.0, z=1.0)
    for name, value in fields.items():
        setattr(marker, name, value)
    return MarkerArray(markers=[marker])


def turned(w: float) -> Pose:
    pose = pose_message(Pose2D(3.0, 3.0, 0.0))
    pose.orientation.w = w
    return pose


def goal_marker(w: float) -> PoseStamped:
    message = PoseStamped(pose=turned(w))
    message.header.frame_id = 'map'
    return message


REFUSED_WORLDS = {
    'a huge quaternion': ('obstacles', obstacle(pose=turned(1.4e154)), 'is not a pose'),
    'a long name': ('obstacles', obstacle(ns='x' * 100_000), '100000 characters'),
    'a giant name': ('obstacles', obstacle(ns='x' * 10_000_000), '1000000 are the most'),
    'multitudes': ('obstacles', MarkerArray(markers=[Marker()] * 10_000), 'bytes; 1000000'),
    'a size of no size': ('obstacles', obstacle(scale=Vector3(x=1e-300)), 'from 0.001 to 100 m'),
    'crowds': ('obstacles', MarkerArray(markers=[Marker()] * 1001), '1001 markers'),
    'a huge quaternion of a goal': ('goal_marker', goal_marker(1e308), 'is not a pose'),
}


def test_hostile_obstacles_and_goals_are_refused_and_the_simulation_goes_on(bench: Bench):
    # Nothing walks: the less is simulated while a giant message is on its way, the better.
    bench.start('sim_node', real_time_factor=1.0)
    bench.wait_for_robot()
    for topic, message, words in REFUSED_WORLDS.values():
        with bench.expects('sim_node', words, level=ERROR):
            bench.publisher(type(message), topic).publish(message)
    since = bench.elapsed
    bench.wait_until('two seconds go by', lambda: bench.elapsed > since + 2.0)
    bench.wait_for_status('sim_node', 'running')
    assert bench.call('reset').success
    assert len(bench.processes['sim_node'].log_tail(10_000)) < 20_000


def test_a_bad_trajectory_is_refused_and_a_good_one_after_it_is_executed(composed_bench: Bench):
    bench = composed_bench
    bench.start('sim_node')
    bench.wait_until('fourteen seconds have passed', lambda: bench.time > 14.0)

    def postures() -> np.ndarray:
        names = bench.joint_states.name
        return np.array([bench.joint_states.position[names.index(name)] for name in NAMES])

    publisher = bench.publisher(JointTrajectory, 'joint_trajectory')
    for message, words in REFUSED.values():
        with bench.expects('sim_node', words, level=ERROR):
            publisher.publish(message)
        np.testing.assert_allclose(postures(), POSTURE, atol=1e-9)
    with bench.expects('sim_node', 'the trajectory ended at 12.000 s', level=WARN):
        # By as much a busy machine may be late: that is no fault of anybody.
        publisher.publish(trajectory(stamp=11))
    since = bench.elapsed
    bench.wait_until('two seconds go by', lambda: bench.elapsed > since + 2.0)
    np.testing.assert_allclose(postures(), POSTURE, atol=1e-9)
    bench.wait_for_status('sim_node', 'running')
    assert bench.statuses['sim_node'].values['late_trajectories'] == '1'

    publisher.publish(trajectory())
    bench.wait_until(
        'the good trajectory is executed', lambda: np.abs(postures() - MOVED).max() < 1e-6
    )
    bench.wait_for_status('sim_node', 'running')
